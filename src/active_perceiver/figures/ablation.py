"""What each ingredient is worth: a bar for each variant, a panel for each scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from active_perceiver.figures.style import INK, MUTED, SERIES

BAR, SEEN, UNKNOWN = "#9cc3e0", SERIES[0], SERIES[1]
"""Colours of the bars and of the two marks."""


@dataclass(frozen=True)
class AblationRow:
    """One variant in one scene; figures are 0..1, None for what was not measured.

    Attributes:
        label: its name.
        unseen: AP50 with pictures not trained with.
        seen: AP50 with pictures trained with.
        unknown: AP50 of targets that were held out.
    """

    label: str
    unseen: float | None
    seen: float | None
    unknown: float | None = None


def ablation_figure(panels: Mapping[str, Sequence[AblationRow]]) -> Figure:
    """Horizontal bars; the first variant's value is drawn on through all rows, to compare with.

    Args:
        panels: for each scene, by its name, the variants from top to bottom, the same in all.

    Raises:
        ValueError: if there is nothing to draw, panels have different variants, or a figure is not in 0..1.
    """
    labels = [row.label for rows in list(panels.values())[:1] for row in rows]
    if not labels or any([row.label for row in rows] != labels for rows in panels.values()):
        raise ValueError(f"each panel needs the same variants, at least one; got {list(panels.values())}")
    figures = [value for rows in panels.values() for row in rows for value in (row.unseen, row.seen, row.unknown)]
    if any(value is not None and not 0.0 <= value <= 1.0 for value in figures):
        raise ValueError(f"AP50 is a number in 0..1, got {figures}")
    figure = Figure(figsize=(3.0 + 3.3 * len(panels), 1.5 + 0.3 * len(labels)), dpi=130, layout="constrained")
    columns = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    heights = np.arange(len(labels))
    for axes, (scene, rows) in zip(columns, panels.items(), strict=True):
        axes.barh(heights, [row.unseen or 0.0 for row in rows], height=0.66, color=BAR)
        if rows[0].unseen is not None:
            axes.axvline(rows[0].unseen, color=INK, linewidth=0.9, linestyle=(0, (4, 3)), zorder=2)
        for height, row in zip(heights, rows, strict=True):
            for value, marker, colour in ((row.seen, "|", SEEN), (row.unknown, "D", UNKNOWN)):
                if value is not None:
                    size = 11 if marker == "|" else 5
                    axes.plot(
                        [value], [height], marker, color=colour, markersize=size, markeredgewidth=2, clip_on=False,
                        zorder=3,
                    )  # fmt: skip
            text = "-" if row.unseen is None else f"{row.unseen:.3f}"
            axes.annotate(
                text, (1.0, height), (9, 0), textcoords="offset points", va="center", fontsize=9, color=INK,
                annotation_clip=False,
            )  # fmt: skip
        axes.set_title(scene, fontsize=11, color=INK)
        axes.set_yticks(heights, labels)
        axes.set_ylim(len(labels) - 0.5, -0.5)
        axes.set_xlim(0.0, 1.0)
        axes.set_axisbelow(True)
        axes.grid(axis="x", color=MUTED, alpha=0.25, linewidth=0.6)
        axes.spines[["top", "right", "left"]].set_visible(False)
        axes.tick_params(labelsize=9.5, colors=INK, left=False)
        axes.set_xlabel("AP50, places not trained in", fontsize=10, color=INK)
    marks: list[Line2D | Patch] = [
        Patch(color=BAR, label="pictures not trained with"),
        Line2D([], [], marker="|", linestyle="", color=SEEN, markersize=11, markeredgewidth=2, label="trained with"),
    ]
    if any(row.unknown is not None for rows in panels.values() for row in rows):
        marks.append(Line2D([], [], marker="D", linestyle="", color=UNKNOWN, label="targets never learned"))
    figure.legend(
        handles=marks, loc="outside lower center", ncols=len(marks), fontsize=9.5, frameon=False, labelcolor=INK
    )
    return figure
