"""What `benchmark export` prints."""

from __future__ import annotations

from functools import reduce
from typing import Any

from active_perceiver.benchmarks.act.worker import PARTS
from active_perceiver.utils.result import format_number

GROUPS = {"pictures_seen": "pictures trained with", "pictures_unseen": "pictures never seen"}


def format_exported(body: dict[str, Any]) -> str:
    """A table with a column for each of the exported agents."""
    protocol, agents = body["protocol"], body["agents"]
    lines = [f"{'':44}" + "".join(f"{label:>10}" for label in agents)]

    def row(label: str, *path: str, form: str = ".3f") -> None:
        values = [reduce(lambda inside, key: inside[key], path, one) for one in agents.values()]
        lines.append(f"  {label:42}" + "".join(f"{format_number(value, form):>10}" for value in values))

    lines.append("MB")
    for part in agents["fp32"]["megabytes"]:
        row(part, "megabytes", part, form=".2f")
    lines.append("from the start of the process to the first command, s")
    row("three packages installed", "cold_start", "whole")
    row("all packages installed", "cold_start_here", "whole")
    row("ratio", "start_ratio")
    row("of that, comparing checksums", "cold_start", "checking")
    lines.append("one action, median, ms")
    for part in (*PARTS, "rest", "whole"):
        row(part, "ms", part, "median", form=".2f")
    lines.append("searches, exact")
    row("success", "evaluation", "overall", "success")
    row("ratio to the fewest actions", "evaluation", "overall", "ratio")
    for group, words in GROUPS.items():
        if group in agents["fp32"]["evaluation"]["stop_evaluation"]:
            lines.append(f"by its own word, {words}")
            for name in ("true_found", "false_found", "mean_steps"):
                row(name.replace("_", " "), "evaluation", "stop_evaluation", group, "overall", name)
    if "detection" in agents["fp32"]["evaluation"]:
        lines.append("recognition in places not trained in")
        for name in ("auroc", "ap50", "mean_iou"):
            row(name, "evaluation", "detection", "pictures_seen", name)
    ratios = ", ".join(f"{name} {value:.2f}" for name, value in body["int8_over_fp32"].items())
    width, height = protocol["frame"]
    return "\n".join(
        [
            *lines,
            f"int8 / fp32: {ratios}",
            f"{protocol['backbone']}, {protocol['image_size']} pixels, trained in {', '.join(protocol['scenes'])}",
            f"int8 set by {protocol['calibrated_by']}; {protocol['threads']} thread(s)",
            f"{protocol['starts']} processes of {protocol['repeats']} actions each, on JPEG of {width} x {height}",
        ]
    )


def action_bars(body: dict[str, Any]) -> dict[str, dict[str, dict[str, float]]]:
    """Median milliseconds of the parts of an action, for each agent."""
    threads, agents = body["protocol"]["threads"], body["agents"]
    bars = {label: {part: one["ms"][part]["median"] for part in (*PARTS, "rest")} for label, one in agents.items()}
    return {f"one action, {threads} thread{'s' if threads > 1 else ''}": bars}
