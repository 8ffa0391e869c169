"""What `benchmark policies` prints and draws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from active_perceiver.figures.policies_spread import SpreadDot, SpreadRow
from active_perceiver.utils.result import format_number

Run = dict[str, Any]


def summary(setup: dict[str, Any], learner: str, runs: Sequence[Run]) -> dict[str, Any]:
    """What several seeds come to, the worst one beside the median.

    Args:
        setup: see `PolicySetup.described`.
        learner: name.
        runs: of that learner in that setup, at least one.

    Returns:
        "setup", "learner", "seeds"; "success" and "spl": the least; "ratio", "seconds" and "cpu_seconds": "median"
        and "worst"; "seconds_to_fine_ratio": likewise, None if a training never got there; "iterations": "median" and
        "worst"; "worst_target": "target", "success", "ratio" and "seed" of the target that was searched for worst;
        "unseen_pictures": the least "success" and the largest "ratio", None if there are none; "kept": whether the
        worst seed keeps the limits of the setup.
    """
    fine = [run["seconds_to_fine_ratio"] for run in runs]
    unseen = [run["unseen_pictures"] for run in runs]
    ratio, seconds = (_spread([run[name] for run in runs]) for name in ("ratio", "seconds"))
    return {
        "setup": setup["setup"],
        "learner": learner,
        "seeds": len(runs),
        "success": min(run["success"] for run in runs),
        "spl": min(run["spl"] for run in runs),
        "ratio": ratio,
        "seconds": seconds,
        "cpu_seconds": _spread([run["cpu_seconds"] for run in runs]),
        "seconds_to_fine_ratio": None if None in fine else _spread(fine),
        "iterations": _spread([run["iterations"] for run in runs]),
        "worst_target": _worst_target(runs),
        "unseen_pictures": None
        if None in unseen
        else {
            "success": min(one["success"] for one in unseen),
            "ratio": _spread([one["ratio"] for one in unseen])["worst"],
        },
        "kept": all(
            run["arrives"] and run["ratio"] <= setup["ratio_limit"] and run["seconds"] <= setup["seconds_limit"]
            for run in runs
        ),
    }


def _spread(values: Sequence[float | None]) -> dict[str, float | None]:
    """The median and the worst; where no search arrives there is no ratio (None), which is worse than any."""
    known = [np.inf if value is None else value for value in values]
    return {
        name: float(value) if np.isfinite(value) else None
        for name, value in (("median", np.median(known)), ("worst", max(known)))
    }


def _worst_target(runs: Sequence[Run]) -> dict[str, Any]:
    """The target that is missed most often in some run; among those never missed the one with the longest ways."""
    results = [(result, run["seed"]) for run in runs for result in run["per_target"]]
    result, seed = max(results, key=lambda one: (round(1 - one[0]["success"], 6), one[0]["ratio"] or np.inf))
    return {
        "target": f"{result['scene']}/{result['target']}",
        "success": result["success"],
        "ratio": result["ratio"],
        "seed": seed,
    }


def format_policies(body: dict[str, Any]) -> str:
    """A row for each setup and learner."""
    protocol = body["protocol"]
    setups = {setup["setup"]: setup for setup in body["setups"]}
    lines = [
        f"{'':30}{'':>8}{'ratio':>17}{'seconds':>16}{'to ' + format(protocol['fine_ratio'], 'g') + ' x':>16}"
        f"{'unseen':>8}{'in':>8}",
        f"{'setup':16}{'learner':15}{'success':>8}{'median':>9}{'worst':>8}{'median':>8}{'worst':>8}{'median':>8}"
        f"{'worst':>8}{'ratio':>8}{'limits':>8}  worst target",
    ]
    for row in body["summary"]:
        fine, unseen, worst = row["seconds_to_fine_ratio"] or {}, row["unseen_pictures"] or {}, row["worst_target"]
        lines.append(
            f"{row['setup']:16}{row['learner']:15}{_share(row['success']):>8}"
            f"{_figure(row['ratio']['median'], '.4f'):>9}{_figure(row['ratio']['worst'], '.4f'):>8}"
            f"{_figure(row['seconds']['median'], '.1f'):>8}{_figure(row['seconds']['worst'], '.1f'):>8}"
            f"{_figure(fine.get('median'), '.1f'):>8}{_figure(fine.get('worst'), '.1f'):>8}"
            f"{_figure(unseen.get('ratio')):>8}{'yes' if row['kept'] else 'no':>8}"
            f"  {_short_name(worst, setups)} {_figure(worst['ratio'])}"
        )
    lines += [
        f"{protocol['seeds']} seeds, {protocol['threads']} thread(s); exact, over all reachable starts, with the"
        " recogniser's boxes. Success: the worst seed's. Ratio: mean",
        "steps over the fewest possible. Limits, for the worst seed: success 1, "
        + "; ".join(_limits(body["setups"]))
        + ".",
    ]
    return "\n".join(lines)


def spread_rows(body: dict[str, Any]) -> list[SpreadRow]:
    """A row of dots for each setup."""
    return [
        SpreadRow(
            about["setup"],
            {
                learner: tuple(
                    SpreadDot(run["ratio"], run["seconds"], run["arrives"])
                    for run in body["runs"]
                    if (run["setup"], run["learner"]) == (about["setup"], learner)
                )
                for learner in body["protocol"]["settings"]
            },
            about["ratio_limit"],
            about["seconds_limit"],
        )
        for about in body["setups"]
    ]


def _figure(value: float | None, form: str = ".3f") -> str:
    """As `shown`, and the same for a figure from the result file, where it has six digits."""
    return format_number(None if value is None else float(f"{value:.6g}"), form)


def _share(success: float) -> str:
    """Never more than it is: 1.000 means always."""
    return format(1.0 if success > 1 - 1e-6 else min(success, 0.9994), ".3f")


def _short_name(worst: dict[str, Any], setups: dict[str, Any]) -> str:
    """Without its scene where there is only one."""
    scene, _, target = worst["target"].partition("/")
    return target if scene in setups else worst["target"]


def _limits(setups: Sequence[dict[str, Any]]) -> list[str]:
    kinds = {(len(setup["scenes"]) > 1, setup["ratio_limit"], setup["seconds_limit"]) for setup in setups}
    return [
        f"{ratio:g} x and {seconds:g} s {'for several scenes' if several else 'for one scene'}"
        for several, ratio, seconds in sorted(kinds)
    ]
