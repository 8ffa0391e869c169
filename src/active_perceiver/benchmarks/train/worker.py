"""One training of a policy that is measured as it goes; `measure.py` gives it a process of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from active_perceiver.benchmarks.train.baselines import Baseline, baseline_named
from active_perceiver.parallel.executor import tell
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.result import format_number

Point = dict[str, Any]


@dataclass(frozen=True)
class Training:
    """A training to do.

    Attributes:
        name: of the baseline.
        seed: of everything random.
        threads: of torch.
        seconds: longest it may take.
    """

    name: str
    seed: int
    threads: int
    seconds: float


def train(training_task: TrainingTask, training: Training) -> dict[str, Any]:
    """Train once.

    What happens once in a process, such as compiling or loading what the first step of an optimiser needs, is not the
    learner's: a training of one iteration comes before the one that counts.

    Returns:
        "learner", "seed" and "points": its measurements, see `measured`.
    """
    baseline = baseline_named(training.name)
    config = replace(baseline.config, seed=training.seed, threads=training.threads)
    points: list[Point] = []

    def inspect(record: dict[str, float], tables: Any) -> None:
        points.append(measured(record, baseline))
        tell(_words(points[-1]))

    baseline.learner.train([training_task], replace(config, iterations=1))
    baseline.learner.train([training_task], replace(config, seconds=training.seconds), inspect=inspect)
    return {"learner": training.name, "seed": training.seed, "points": points}


def measured(record: dict[str, float], baseline: Baseline) -> Point:
    """What counts of a record of a history.

    Returns:
        "seconds" of training until then, "steps" in the environment, "success", and "ratio", None if no search
        arrives.
    """
    # Inside, because the process that starts this one must not need torch to say what is wrong.
    from active_perceiver.policies.monitor import ALWAYS

    pause = 0.0 if baseline.goes_on else record["measuring"]
    return {
        "seconds": record["seconds"] - pause,
        "steps": record["samples"],
        # Rounding keeps an exact success from being 1.
        "success": 1.0 if record["success"] >= ALWAYS else record["success"],
        "ratio": None if math.isnan(record["ratio"]) else record["ratio"],
    }


def _words(point: Point) -> str:
    return f"{point['seconds']:.0f} s, success {point['success']:.3f}, {format_number(point['ratio'], '.2f')} x"
