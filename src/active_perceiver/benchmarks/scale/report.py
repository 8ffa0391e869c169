"""The tables and curves of what `measure.py` measured."""

from __future__ import annotations

import textwrap
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from active_perceiver.benchmarks.scale.clock import PARTS

Curve = list[tuple[int, float]]


def format_scale(body: dict[str, Any]) -> str:
    """A table of what each training took, and one of where the time went."""
    protocol = body["protocol"]
    head = (
        f"{protocol['targets']} targets in each scene, {protocol['features']} features, {protocol['threads']} "
        f"thread(s), at most {protocol['seconds']:g} s of training; seconds until every search arrives, on "
        "average within so many times the fewest steps; memory in MiB"
    )
    columns = [
        "scenes", "states each", "rows", "learner",
        *(f"s to {ratio:g} x" for ratio in protocol["ratios"]), "s/iteration", "data", "training", "with measuring",
    ]  # fmt: skip
    rows = [
        [
            str(run["scenes"]),
            str(run["states"]),
            f"{run['rows']:,}".replace(",", " "),
            run["learner"],
            *(_reached(run, ratio) for ratio in protocol["ratios"]),
            f"{run['seconds_per_iteration']:.2f}",
            *(_number(run[label]) for label in ("data_mib", "training_mib", "peak_mib")),
        ]
        for run in body["runs"]
    ]
    parts = [*PARTS, "rest"]
    shares = [
        [
            *row[:4],
            *(f"{100 * run['parts'][part] / run['seconds']:.0f} %" for part in parts),
            f"{run['measuring_seconds']:.1f}",
        ]
        for row, run in zip(rows, body["runs"], strict=True)
    ]
    return "\n".join(
        [
            *textwrap.wrap(head, 110),
            *_aligned([columns, *rows]),
            "",
            "where the time of the training went, and seconds of measuring beside it",
            *_aligned([[*columns[:4], *parts, "measuring"], *shares]),
        ]
    )


def cost_curves(body: dict[str, Any]) -> tuple[dict[str, dict[int, Curve]], dict[str, dict[int, Curve]]]:
    """Over the number of scenes, by learner and states: seconds to the best quality, and MiB of memory.

    A training that did not get there has no time, and where the system tells no memory there is none.
    """
    times: dict[str, dict[int, Curve]] = defaultdict(lambda: defaultdict(list))
    memory: dict[str, dict[int, Curve]] = defaultdict(lambda: defaultdict(list))
    best = f"{body['protocol']['ratios'][-1]:g}"
    for run in body["runs"]:
        reached = run["reached"][best]
        if reached is not None:
            times[run["learner"]][run["asked_states"]].append((run["scenes"], reached["seconds"]))
        if run["training_mib"] is not None:
            memory[run["learner"]][run["asked_states"]].append((run["scenes"], run["training_mib"]))
    return times, memory


def _reached(run: dict[str, Any], ratio: float) -> str:
    reached = run["reached"][f"{ratio:g}"]
    if reached is not None:
        return f"{reached['seconds']:.1f}"
    if run["ended"] == "iterations":
        return f"not in {run['iterations']} iterations"
    return f"not in {run['seconds']:.0f} s"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
