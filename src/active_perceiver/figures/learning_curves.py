"""How the length of searches falls during training, one panel for each learner."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from active_perceiver.figures.style import INK, MUTED, SERIES

PANELS_PER_ROW = 3
RANDOM_WALK, SHORTEST = "random walk", "shortest paths"
# Up to so many measurements are marked by dots, so that even a single one shows.
_MARKED = 12


@dataclass(frozen=True, eq=False)
class Curve:
    """One method's searches during training.

    Attributes:
        label: the method.
        iterations: (n,) when it was measured, increasing.
        lengths: (seeds, n) expected number of actions per search, failures counted as the limit.

    Raises:
        ValueError: if the shapes do not fit, if the iterations do not increase, or if a length is not a positive
            number, which a logarithmic axis could not show.
    """

    label: str
    iterations: NDArray[np.number]
    lengths: NDArray[np.floating]

    def __post_init__(self) -> None:
        iterations, lengths = np.shape(self.iterations), np.shape(self.lengths)
        if len(iterations) != 1 or len(lengths) != 2 or lengths[1:] != iterations or 0 in lengths:
            raise ValueError(f"{self.label}: (n,) iterations go with (seeds, n) lengths, got {iterations}, {lengths}")
        if not (np.diff(self.iterations) > 0).all():
            raise ValueError(f"{self.label}: the iterations do not increase")
        if not (np.isfinite(self.lengths) & (self.lengths > 0)).all():
            raise ValueError(f"{self.label}: each length is a positive number; count failures as the limit")


def learning_curves(
    panels: Mapping[str, Sequence[Curve]],
    random_walk: Mapping[str, float] = {},
    shortest: Mapping[str, float] = {},
) -> Figure:
    """The mean over seeds as a line and the least to the most as a band, on a logarithmic axis that all share.

    A label has the same colour in all panels, and the legend stands below them.

    Args:
        panels: for each learner the curves of its methods.
        random_walk: for some learners the expected actions of a random walk, a dashed line.
        shortest: for some learners the mean fewest actions possible, a dotted line.

    Raises:
        ValueError: if there is no panel, if a panel has the same label twice, if there are more labels than
            colours, or if a line is for a learner without a panel or not a positive number.
    """
    colours = _colours(panels)
    for name, length in (*random_walk.items(), *shortest.items()):
        if name not in panels or not 0 < length < np.inf:
            raise ValueError(f"a line at {length} for {name!r} cannot be drawn; the panels are {', '.join(panels)}")
    columns = min(PANELS_PER_ROW, len(panels))
    rows = -(-len(panels) // columns)
    width = max(6.0, 4.8 * columns)
    figure = Figure(figsize=(width, 3.6 * rows + 0.7), dpi=130, layout="constrained")
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
    handles: dict[str, Line2D] = {}
    for axes, (title, curves) in zip(grid.flat, panels.items(), strict=False):
        _draw_axes(axes, title)
        for curve in curves:
            _draw_curve(axes, curve, colours[curve.label])
        if title in random_walk:
            axes.axhline(random_walk[title], color=MUTED, linestyle="--", linewidth=1.5, label=RANDOM_WALK, zorder=1)
        if title in shortest:
            axes.axhline(shortest[title], color=MUTED, linestyle=":", linewidth=1.8, label=SHORTEST, zorder=1)
        handles |= {str(line.get_label()): line for line in axes.get_lines()}
    for axes in grid.flat[len(panels) :]:
        axes.remove()
    for axes in grid[:, 0]:
        axes.set_ylabel("expected actions per search", fontsize=11, color=INK)
    order = [label for label in (*colours, RANDOM_WALK, SHORTEST) if label in handles]
    entry = 0.7 + 0.085 * max(map(len, order))  # inches that the widest entry of the legend takes, generously
    figure.legend(
        handles=[handles[label] for label in order], loc="outside lower center", ncols=max(1, int(width / entry)),
        fontsize=10, frameon=False, labelcolor=INK,
    )  # fmt: skip
    return figure


def _colours(panels: Mapping[str, Sequence[Curve]]) -> dict[str, str]:
    """The colour of each label, in the order of their first appearance."""
    if not any(panels.values()):
        raise ValueError("at least one curve is needed")
    for title, curves in panels.items():
        if len({curve.label for curve in curves}) < len(curves):
            raise ValueError(f"{title}: two curves have the same label")
    labels = list(dict.fromkeys(curve.label for curves in panels.values() for curve in curves))
    if len(labels) > len(SERIES):
        raise ValueError(f"{len(labels)} labels are too many to tell apart, at most {len(SERIES)}")
    return dict(zip(labels, SERIES, strict=False))


def _draw_axes(axes: Axes, title: str) -> None:
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}".replace(",", " ")))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
    axes.grid(color=MUTED, alpha=0.25, linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=9, colors=INK, labelleft=True)
    axes.set_title(title, fontsize=12, color=INK)
    axes.set_xlabel("iterations", fontsize=11, color=INK)


def _draw_curve(axes: Axes, curve: Curve, colour: str) -> None:
    lengths = np.asarray(curve.lengths, float)
    axes.fill_between(
        curve.iterations, lengths.min(0), lengths.max(0), color=colour, alpha=0.18, linewidth=0, zorder=2
    )  # fmt: skip
    marker = "o" if len(curve.iterations) <= _MARKED else None
    axes.plot(
        curve.iterations, lengths.mean(0), color=colour, linewidth=1.9, marker=marker, markersize=3.5,
        label=curve.label, zorder=3,
    )  # fmt: skip
