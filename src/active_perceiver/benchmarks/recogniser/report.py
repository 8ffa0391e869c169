"""What `benchmark recogniser` prints and draws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from active_perceiver.figures.ablation import AblationRow
from active_perceiver.utils.result import format_number

Run = dict[str, Any]

GOALS: dict[str, Any] = {
    "seen pictures": {"auroc": 0.997, "ap50": 0.95},
    "unseen pictures": {"auroc": 0.995, "ap50": 0.92},
    "false_positive_rate": 0.01,
    "seconds": 240.0,
}
"""What every seed is to reach: least AUROC and AP50, most false alarms and most seconds of training."""

# Heading and digits of the columns.
FIGURES = {
    "auroc": ("AUROC", 4),
    "ap50": ("AP50", 3),
    "mean_iou": ("IoU", 3),
    "recall": ("recall", 3),
    "false_positive_rate": ("false", 4),
    "calibration_error": ("ECE", 4),
}
WIDTH = 31


def summary(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """The seeds of each variant in each scene together.

    Args:
        runs: of `benchmark recogniser`.

    Returns:
        For each scene and variant, in the order of the runs, "scene", "variant", "seeds", the mean "seconds",
        "metrics": the mean of each figure, None if a seed has none, and "kept": whether every seed keeps the goals.
    """
    groups: dict[tuple[str, str], list[Run]] = {}
    for run in runs:
        groups.setdefault((run["scene"], run["variant"]), []).append(run)
    return [
        {
            "scene": scene,
            "variant": variant,
            "seeds": len(seeds),
            "seconds": float(np.mean([run["seconds"] for run in seeds])),
            "metrics": {
                name: {figure: _mean([run["metrics"][name][figure] for run in seeds]) for figure in FIGURES}
                for name in seeds[0]["metrics"]
            },
            "kept": all(map(keeps_goals, seeds)),
        }
        for (scene, variant), seeds in groups.items()
    ]


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if len(known) == len(values) else None


def keeps_goals(run: Run) -> bool:
    """Whether a training reaches all of `GOALS`; what could not be measured does not."""
    for name in ("seen pictures", "unseen pictures"):
        measured = run["metrics"].get(name)
        if measured is None or None in (measured[figure] for figure in (*GOALS[name], "false_positive_rate")):
            return False
        if any(measured[figure] < least for figure, least in GOALS[name].items()):
            return False
        if measured["false_positive_rate"] >= GOALS["false_positive_rate"]:
            return False
    return bool(run["seconds"] <= GOALS["seconds"])


def format_recogniser_ablation(body: dict[str, Any]) -> str:
    """A table for each scene with a row for each variant, and one of targets that were never learned."""
    protocol = body["protocol"]
    lines: list[str] = []
    for about in body["scenes"]:
        rows = [row for row in body["summary"] if row["scene"] == about["scene"]]
        lines += [
            f"{'':{WIDTH}}{'':>8}  {'seen pictures':17}{'unseen pictures'}",
            f"{about['scene']:{WIDTH}}{'seconds':>8}{_heads('auroc', 'ap50')} {_heads(*FIGURES)}{'goals':>7}",
        ]
        for row in rows:
            seen, unseen = (row["metrics"].get(f"{word} pictures", {}) for word in ("seen", "unseen"))
            lines.append(
                f"{row['variant']:{WIDTH}}{_figure(row['seconds'], 0):>8}{_cells(seen, 'auroc', 'ap50')} "
                f"{_cells(unseen, *FIGURES)}{'yes' if row['kept'] else 'no':>7}"
            )
        lines.append("")
    lines += _never_learned(body)
    seen, unseen = GOALS["seen pictures"], GOALS["unseen pictures"]
    lines += [
        f"{protocol['seeds']} seed(s), {protocol['threads']} thread(s), {protocol['backbone']} at "
        f"{protocol['image_size']} pixels; views of places not trained in. False: views without",
        "the target that count as showing it. ECE: expected calibration error. Goals: AUROC and AP50 at least "
        f"{unseen['auroc']:g} and {unseen['ap50']:g}",
        f"({seen['auroc']:g} and {seen['ap50']:g} with pictures seen), false alarms under "
        f"{100 * GOALS['false_positive_rate']:g} %, at most {GOALS['seconds']:g} s.",
    ]
    if protocol["start"] is None:
        lines.append("There were no weights of other rooms for this backbone and size: all start from random ones.")
    return "\n".join(lines)


def _never_learned(body: dict[str, Any]) -> list[str]:
    """The table of targets that the recogniser has not been trained on; nothing if no variant has any."""
    rows = []
    for about in body["scenes"]:
        for row in body["summary"]:
            name = body["protocol"]["variants"][row["variant"]]["never_learned"]
            if row["scene"] == about["scene"] and name in row["metrics"]:
                count = len(about["held_out_targets"]) if name == "unknown targets" else about["targets"]
                targets = f"{count} of {about['targets']}"
                cells = _cells(row["metrics"][name], *FIGURES)
                rows.append(f"{row['variant']:{WIDTH}}{about['scene']:20}{targets:>9}{cells}")
    head = f"{'targets never learned':{WIDTH}}{'':20}{'targets':>9}{_heads(*FIGURES)}"
    return [head, *rows, ""] if rows else []


def _heads(*figures: str) -> str:
    return "".join(f"{FIGURES[figure][0]:>8}" for figure in figures)


def _cells(measured: dict[str, Any], *figures: str) -> str:
    return "".join(f"{_figure(measured.get(figure), FIGURES[figure][1]):>8}" for figure in figures)


def _figure(value: float | None, digits: int) -> str:
    """As `shown`, and the same for a figure from the result file, where it has six digits."""
    return format_number(None if value is None else float(f"{value:.6g}"), f".{digits}f")


def ablation_rows(body: dict[str, Any]) -> dict[str, list[AblationRow]]:
    """For each scene a row for each variant."""
    return {
        about["scene"]: [
            AblationRow(
                row["variant"],
                *(
                    row["metrics"].get(name, {}).get("ap50")
                    for name in ("unseen pictures", "seen pictures", "unknown targets")
                ),
            )
            for row in body["summary"]
            if row["scene"] == about["scene"]
        ]
        for about in body["scenes"]
    }
