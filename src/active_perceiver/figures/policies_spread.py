"""How much policies differ between seeds: a dot for each training, beside the limit it has to keep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator
from numpy.typing import NDArray

from active_perceiver.figures.style import INK, MUTED, SERIES

# Heights within a row, of which the next one is 1 away.
_LEARNERS = 0.6
_SEEDS = 0.12


@dataclass(frozen=True)
class SpreadDot:
    """One training.

    Attributes:
        ratio: mean steps over the fewest possible, at least 1; None if no search arrives.
        seconds: of training, positive.
        arrives: whether every search does.
    """

    ratio: float | None
    seconds: float
    arrives: bool


@dataclass(frozen=True)
class SpreadRow:
    """The trainings in one setup.

    Attributes:
        label: of the setup.
        dots: for each learner, one per seed.
        ratio_limit: most that a ratio may be.
        seconds_limit: most that a training may take.
    """

    label: str
    dots: Mapping[str, Sequence[SpreadDot]]
    ratio_limit: float
    seconds_limit: float


def policies_spread(rows: Sequence[SpreadRow], least_span: float = 1.02) -> Figure:
    """Two panels with a row per setup: ratios on the left, seconds on the right; limits are vertical strokes.

    A training in which some search never arrives is a hollow dot; one without any ratio stands at the right edge of
    the left panel.

    Args:
        rows: the setups from top to bottom, with the same learners.
        least_span: the axis of ratios reaches at least so far.

    Raises:
        ValueError: if there is nothing to draw, rows have different learners, or there are more than colours.
    """
    learners = list(rows[0].dots) if rows else []
    if not learners or len(learners) > len(SERIES) or any(list(row.dots) != learners for row in rows):
        raise ValueError(f"from 1 to {len(SERIES)} learners can be told apart, the same in all rows; got {learners}")
    colours = dict(zip(learners, SERIES, strict=False))
    figure = Figure(figsize=(9.2, 1.5 + 0.62 * len(rows)), dpi=130, layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    ratios = [dot.ratio for row in rows for dots in row.dots.values() for dot in dots if dot.ratio is not None]
    most = 1 + 1.12 * (max([least_span, *ratios, *(row.ratio_limit for row in rows)]) - 1)
    for axes, limit in ((left, "ratio_limit"), (right, "seconds_limit")):
        for height, row in enumerate(rows):
            edge = getattr(row, limit)
            axes.plot([edge, edge], [height - 0.42, height + 0.42], color=INK, linewidth=1.6, zorder=2)
        _style(axes)
    for height, row in enumerate(rows):
        for learner, dots in row.dots.items():
            heights = height + _places(len(learners), learners.index(learner), len(dots))
            for y, dot in zip(heights, dots, strict=True):
                face = colours[learner] if dot.arrives else "white"
                ratio = most if dot.ratio is None else dot.ratio
                for axes, value in ((left, ratio), (right, dot.seconds)):
                    axes.plot(
                        [value], [y], "o", markersize=5, color=colours[learner], markerfacecolor=face, clip_on=False,
                        zorder=3,
                    )  # fmt: skip
    left.set_yticks(range(len(rows)), [row.label for row in rows])
    left.set_ylim(len(rows) - 0.45, -0.55)
    left.set_xlim(1.0, most)
    seconds = [dot.seconds for row in rows for dots in row.dots.values() for dot in dots]
    seconds += [row.seconds_limit for row in rows]
    right.set_xscale("log")
    right.set_xlim(0.7 * min(seconds), 1.3 * max(seconds))
    right.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    right.xaxis.set_minor_locator(NullLocator())
    right.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    left.set_xlabel("mean steps over the fewest possible", fontsize=11, color=INK)
    right.set_xlabel("seconds of training", fontsize=11, color=INK)
    marks = [Line2D([], [], marker="o", linestyle="", color=colour, label=name) for name, colour in colours.items()]
    marks.append(Line2D([], [], color=INK, linewidth=1.6, label="limit"))
    figure.legend(
        handles=marks, loc="outside lower center", ncols=len(marks), fontsize=10, frameon=False, labelcolor=INK
    )
    return figure


def _places(learners: int, learner: int, seeds: int) -> NDArray[np.float64]:
    """(seeds,) heights of a learner's dots about the middle of the row."""
    middle = (learner + 0.5) / learners - 0.5
    spread = np.linspace(-0.5, 0.5, seeds) if seeds > 1 else np.zeros(seeds)
    return _LEARNERS * middle + _SEEDS * spread


def _style(axes: Axes) -> None:
    axes.grid(axis="x", color=MUTED, alpha=0.25, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(labelsize=9.5, colors=INK, left=False)
