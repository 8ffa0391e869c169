"""The paper's tables from the results of cells: figures for the result file, and Markdown for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy import stats

from active_perceiver.reproduction.cells import Cell
from active_perceiver.reproduction.paper import TABLE_1, TABLE_2
from active_perceiver.reproduction.setups import CHOICES, METHODS, BudgetConfig

CONFIDENCE = 0.95
LEARNER_LABELS = {"a3c": "A3C", "ppo": "PPO", None: "-"}

Results = Mapping[Cell, Mapping[str, Any]]


def mean_and_interval(values: Sequence[float | None]) -> dict[str, float | int | None]:
    """Mean over seeds with half the width of its confidence interval (Student's t); None counts as missing.

    Returns:
        `mean` (None if there is no value), `half` (None for fewer than two values) and `n`, the values there are.
    """
    known = np.array([value for value in values if value is not None], float)
    half = None
    if len(known) > 1:
        quantile = stats.t.ppf(0.5 + CONFIDENCE / 2, len(known) - 1)
        half = float(quantile * known.std(ddof=1) / np.sqrt(len(known)))
    return {"mean": float(known.mean()) if len(known) else None, "half": half, "n": len(known)}


def _summary(results: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Means over seeds of sampled and exact figures, each from a part of an evaluation with the same keys."""

    def over_seeds(kind: str, figure: str) -> dict[str, float | int | None]:
        return mean_and_interval([result[kind][figure] for result in results])

    return {
        "sampled": {figure: over_seeds("sampled", figure) for figure in ("mean_steps", "success")},
        "exact": {figure: over_seeds("exact", figure) for figure in ("mean_steps", "success", "ratio", "spl")},
    }


def _groups(results: Results) -> dict[tuple[str, str, str | None], list[Mapping[str, Any]]]:
    groups: dict[tuple[str, str, str | None], list[Mapping[str, Any]]] = {}
    for cell, result in results.items():
        groups.setdefault((cell.setup, cell.method, cell.learner), []).append(result)
    return groups


def table_1(results: Results) -> list[dict[str, Any]]:
    """Rows of table I: setup, method, learner, the paper's figures, and ours over seeds."""
    rows = []
    for (setup, method, learner), group in _groups(results).items():
        overall = [{kind: result[kind]["overall"] for kind in ("sampled", "exact")} for result in group]
        paper = TABLE_1[setup].get(method)
        rows.append(
            {
                "setup": setup,
                "method": method,
                "learner": learner,
                "seeds": len(group),
                "paper": paper and {"mean_steps": paper[0], "success": paper[1] / 100},
                **_summary(overall),
                "samples": mean_and_interval([_samples(result) for result in group])["mean"],
                "seconds": mean_and_interval([result["seconds"] for result in group])["mean"],
            }
        )
    return rows


def _samples(result: Mapping[str, Any]) -> float | None:
    return result["history"][-1]["samples"] if result["history"] else None


def table_2(results: Results) -> list[dict[str, Any]]:
    """Rows of table II: target, method, learner, the paper's figures, and ours over seeds."""
    rows = []
    for (_, method, learner), group in _groups(results).items():
        for number, first in enumerate(group[0]["exact"]["per_target"]):
            per_target = [
                {kind: result[kind]["per_target"][number] for kind in ("sampled", "exact")} for result in group
            ]
            paper = TABLE_2.get(first["target"], {}).get(method)
            rows.append(
                {
                    "target": first["target"],
                    "method": method,
                    "learner": learner,
                    "seeds": len(group),
                    "paper": paper and {"mean_steps": paper[0], "success": paper[1] / 100},
                    **_summary(per_target),
                }
            )
    return sorted(rows, key=lambda row: row["target"])


def format_table_1(rows: Sequence[Mapping[str, Any]], scale: BudgetConfig) -> str:
    """Table I as Markdown, one part per setup."""
    parts = []
    for setup, described in scale.setups.items():
        some = [row for row in rows if row["setup"] == setup]
        if some:
            lines = [_line(METHODS[row["method"]].label, row) for row in some]
            parts.append("\n".join([f"**{described.label}**", "", *_head("method"), *lines]))
    return "\n\n".join(parts)


def format_table_2(rows: Sequence[Mapping[str, Any]]) -> str:
    """Table II as Markdown."""
    lines = [_line(f"{row['target']}, {METHODS[row['method']].label}", row) for row in rows]
    return "\n".join([*_head("target, method"), *lines])


def table_of_choices(results: Results) -> list[dict[str, Any]]:
    """Rows for what the paper leaves open: as it was chosen first, then each choice made otherwise."""
    return [
        {
            "choice": cell.choice,
            "label": CHOICES[cell.choice].label if cell.choice else "as in table 1",
            "exact": result["exact"]["overall"],
            "updates": result["history"][-1]["iteration"],
            "samples": result["history"][-1]["samples"],
            "seconds": result["seconds"],
        }
        for cell, result in results.items()
    ]


def format_choices(rows: Sequence[Mapping[str, Any]]) -> str:
    """The same as Markdown."""
    head = ("chosen", "exact success", "mean actions", "x shortest", "updates", "actions in training")
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for row in rows:
        exact = row["exact"]
        cells = (
            row["label"], f"{100 * exact['success']:.1f} %", _number(exact["mean_steps"], ".1f"),
            _number(exact["ratio"], ".1f"), f"{row['updates']:.0f}", f"{row['samples']:,.0f}".replace(",", " "),
        )  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def format_recogniser(scenes: Mapping[str, Mapping[str, Any]]) -> str:
    """How well the cross-validated recognisers do, as Markdown."""
    head = ("scene", "pictures", "AUROC", "AP50", "mean IoU", "recall", "false alarms")
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for scene, described in scenes.items():
        for pictures, metrics in described["metrics"].items():
            figures = [f"{metrics[name]:.3f}" for name in ("auroc", "ap50", "mean_iou")]
            rates = [f"{100 * metrics[name]:.1f} %" for name in ("recall", "false_positive_rate")]
            lines.append(f"| {' | '.join([scene, pictures.removesuffix(' pictures'), *figures, *rates])} |")
    return "\n".join(lines)


def _head(first: str) -> list[str]:
    columns = (
        first,
        "learner",
        "paper: steps / success",
        "ours: steps / success",
        "exact success",
        "x shortest path",
    )
    return [f"| {' | '.join(columns)} |", "|" + "---|" * len(columns)]


def _line(label: str, row: Mapping[str, Any]) -> str:
    paper, sampled, exact = row["paper"], row["sampled"], row["exact"]
    cells = (
        label,
        LEARNER_LABELS[row["learner"]],
        "not run" if paper is None else f"{_number(paper['mean_steps'], '.1f')} / {100 * paper['success']:.1f} %",
        f"{_interval(sampled['mean_steps'], '.1f')} / {_interval(sampled['success'], '.1f', 100)} %",
        f"{_interval(exact['success'], '.1f', 100)} %",
        _interval(exact["ratio"], ".1f" if (exact["ratio"]["mean"] or 0) >= 10 else ".2f"),
    )
    return f"| {' | '.join(cells)} |"


def _interval(value: Mapping[str, Any], form: str, times: float = 1.0) -> str:
    if value["mean"] is None:
        return "-"
    half = "" if value["half"] is None else f" ± {times * value['half']:{form}}"
    return f"{times * value['mean']:{form}}{half}"


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)
