"""What `benchmark train` says of its trainings: when each got how good, the table and the curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from active_perceiver.benchmarks.train.baselines import FINE_RATIO, RATIO
from active_perceiver.figures.time_to_quality import Training

RIVAL = "sb3-ppo"
"""Whose time others are compared with."""

Points = Sequence[dict[str, Any]]


def first_good(points: Points, ratio: float | None) -> dict[str, Any] | None:
    """The first measurement at which every search arrives, in at most so many times the fewest steps; None if none.

    Args:
        points: measurements of a training, see `train_process.measured`.
        ratio: None if the number of steps does not matter.
    """
    for point in points:
        if point["success"] == 1 and (ratio is None or point["ratio"] <= ratio):
            return point
    return None


def learner_summary(trainings: Sequence[Points]) -> dict[str, Any]:
    """How a learner did.

    Args:
        trainings: for each seed its measurements.

    Returns:
        "seeds"; "success", "ratio", "fine_ratio": when each quality was reached, see `_reached`; "steps": median of
        the steps in the environment until "ratio", None if it was not reached; "per_second": median of the steps per
        second of training; "longest": seconds of the longest training.
    """
    good = [first_good(points, RATIO) for points in trainings]
    steps = _middle([math.inf if point is None else point["steps"] for point in good])
    ends = [points[-1] for points in trainings]
    return {
        "seeds": len(trainings),
        "success": _reached([first_good(points, None) for points in trainings]),
        "ratio": _reached(good),
        "fine_ratio": _reached([first_good(points, FINE_RATIO) for points in trainings]),
        "steps": steps,
        "per_second": float(np.median([end["steps"] / end["seconds"] for end in ends])),
        "longest": max(end["seconds"] for end in ends),
    }


def _reached(points: Sequence[dict[str, Any] | None]) -> dict[str, Any]:
    """In how many trainings something was reached, and the median, least and most seconds; None stands for never."""
    seconds = [math.inf if point is None else point["seconds"] for point in points]
    return {
        "reached": sum(map(math.isfinite, seconds)),
        "median": _middle(seconds),
        "least": _finite(min(seconds)),
        "most": _finite(max(seconds)),
    }


def _middle(values: Sequence[float]) -> float | None:
    """The upper median, which exists if some values are infinite; None if it is."""
    return _finite(sorted(values)[len(values) // 2])


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def times_faster(body: dict[str, Any], learner: dict[str, Any]) -> float | None:
    """Median time of the rival to `RATIO` over a learner's; None if one of them never got there."""
    rivals = [other["ratio"]["median"] for other in body["learners"] if other["learner"] == RIVAL]
    if not rivals or rivals[0] is None or learner["ratio"]["median"] is None:
        return None
    return rivals[0] / learner["ratio"]["median"]


def format_train_speed(body: dict[str, Any]) -> str:
    """A table of what `measure_train_speed` found."""
    protocol = body["protocol"]
    ratio, fine = f"{protocol['ratio']:g} x", f"{protocol['fine_ratio']:g} x"
    lines = [
        f"{protocol['scene']}: {protocol['states']} states, {len(protocol['targets'])} targets, boxes:"
        f" {protocol['boxes']}; {protocol['threads']} thread(s), {protocol['seeds']} seed(s)",
        f"seconds of training until every search arrives (success), and in {ratio} and {fine} the fewest steps;"
        " median (least..most)",
        f"{'learner':15}{'success':>9}{'seconds':>24}{ratio:>8}{'seconds':>24}{fine:>8}{'seconds':>24}{'steps':>11}"
        f"{'steps/s':>10}{'x faster':>10}",
    ]
    for learner in body["learners"]:
        acts = protocol["takes_steps"][learner["learner"]]
        steps = _number(learner["steps"]) if acts else "none"
        faster = times_faster(body, learner)
        lines.append(
            f"{learner['learner']:15}"
            + "".join(
                f"{learner[what]['reached']:>{width}}/{learner['seeds']}{_seconds(learner, what):>24}"
                for what, width in (("success", 7), ("ratio", 6), ("fine_ratio", 6))
            )
            + f"{steps:>11}{_number(learner['per_second']) if acts else 'none':>10}"
            + f"{'-' if faster is None else f'{faster:.1f}':>10}"
        )
    return "\n".join([*lines, *_NOTES])


_NOTES = (
    "steps: in the environment, until 1.25 x; mirror-descent and distil take none. x faster than sb3-ppo, to 1.25 x.",
    "sb3: stable-baselines3, with the same network, environment and pay; it and a3c stop at 1.25 x.",
)


def _seconds(learner: dict[str, Any], what: str) -> str:
    """The median, least and most, "1.23 (1.10..1.40)", or how long it was tried."""
    times = learner[what]
    never = f"not in {learner['longest']:.0f} s"
    if times["least"] is None:
        return never
    middle, least, most = (times[key] for key in ("median", "least", "most"))
    longest = "never" if most is None else _short(most)
    return f"{never if middle is None else _short(middle)} ({_short(least)}..{longest})"


def _short(seconds: float) -> str:
    return f"{seconds:.2f}" if seconds < 10 else f"{seconds:.1f}"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:,.0f}".replace(",", " ")


def trainings_of(body: dict[str, Any]) -> dict[str, list[Training]]:
    """What `time_to_quality` draws, by learner."""
    trainings: dict[str, list[Training]] = {}
    for run in body["runs"]:
        columns = {
            name: np.array([point[name] for point in run["points"]], float)
            for name in ("seconds", "success", "ratio")
        }
        trainings.setdefault(run["learner"], []).append(Training(**columns))
    return trainings
