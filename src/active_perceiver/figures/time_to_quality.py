"""How good policies get in how much time, for several learners: the ratio to the shortest paths, and the success."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, PercentFormatter
from numpy.typing import NDArray

from active_perceiver.figures.style import INK, MUTED, SERIES


@dataclass(frozen=True, eq=False)
class Training:
    """How one training went.

    Attributes:
        seconds: (n,) when it was measured, increasing.
        success: (n,) share of searches that arrive, 0..1.
        ratio: (n,) steps of those over the fewest possible; NaN where none arrives.

    Raises:
        ValueError: if the shapes do not fit, or times are not positive and increasing.
    """

    seconds: NDArray[np.floating]
    success: NDArray[np.floating]
    ratio: NDArray[np.floating]

    def __post_init__(self) -> None:
        shapes = {np.shape(values) for values in (self.seconds, self.success, self.ratio)}
        if len(shapes) != 1 or len(next(iter(shapes))) != 1 or shapes == {(0,)}:
            raise ValueError(f"a training has as many times as figures, at least one; got {sorted(shapes)}")
        if not (np.diff(self.seconds, prepend=0) > 0).all():
            raise ValueError("times must be positive and increase")


def time_to_quality(learners: Mapping[str, Sequence[Training]], ratio: float) -> Figure:
    """Ratio and success over seconds: the median over seeds as a line, the least to the most as a band.

    Between two measurements a training is as good as at the earlier one, after its last one as good as there. A curve
    begins when all seeds have been measured once.

    Args:
        learners: the trainings of each, one per seed.
        ratio: the quality that is waited for, a dashed line.

    Raises:
        ValueError: if a learner has no training, there is no learner, or there are more than colours.
    """
    if not learners or not all(learners.values()) or len(learners) > len(SERIES):
        raise ValueError(f"from 1 to {len(SERIES)} learners with trainings can be told apart, got {len(learners)}")
    figure = Figure(figsize=(8.4, 6.4), dpi=130, layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1.7, 1))
    for colour, (label, trainings) in zip(SERIES, learners.items(), strict=False):
        seconds = np.unique(np.concatenate([training.seconds for training in trainings]))
        seconds = seconds[seconds >= max(training.seconds[0] for training in trainings)]
        _draw(above, seconds, np.stack([_held(one, one.ratio, seconds) for one in trainings]), colour, label)
        _draw(below, seconds, np.stack([_held(one, one.success, seconds) for one in trainings]), colour, label)
    above.axhline(ratio, color=MUTED, linestyle="--", linewidth=1.5, zorder=1)
    above.annotate(
        f"{ratio:g} x", (1, ratio), (-4, 3), xycoords=("axes fraction", "data"), textcoords="offset points",
        ha="right", fontsize=9, color=INK,
    )  # fmt: skip
    _draw_axes(above, below)
    handles, labels = above.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=min(6, len(labels)), fontsize=10, frameon=False,
        labelcolor=INK,
    )  # fmt: skip
    return figure


def _held(training: Training, figures: NDArray[np.floating], seconds: NDArray[np.floating]) -> NDArray[np.floating]:
    """The figure at some times, none before the first measurement: that of the latest measurement."""
    return figures[np.searchsorted(training.seconds, seconds, side="right") - 1]


def _draw(axes: Axes, seconds: NDArray[np.floating], figures: NDArray[np.floating], colour: str, label: str) -> None:
    """(n,) times and (seeds, n) figures; where one is missing there is a gap."""
    axes.fill_between(
        seconds, figures.min(0), figures.max(0), step="post", color=colour, alpha=0.18, linewidth=0, zorder=2
    )  # fmt: skip
    axes.step(seconds, np.median(figures, axis=0), where="post", color=colour, linewidth=1.9, label=label, zorder=3)
    axes.plot(seconds[-1:], np.median(figures, axis=0)[-1:], "o", color=colour, markersize=4, zorder=4)


def _draw_axes(above: Axes, below: Axes) -> None:
    for axes in (above, below):
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(color=MUTED, alpha=0.25, linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=9, colors=INK)
    above.set_yscale("log")
    above.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    above.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    above.yaxis.set_minor_formatter(NullFormatter())
    above.set_ylim(bottom=0.95)
    below.yaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    above.set_ylabel("actions of searches that arrive,\nx fewest possible", fontsize=11, color=INK)
    below.set_ylabel("searches that arrive", fontsize=11, color=INK)
    below.set_xlabel("seconds of training", fontsize=11, color=INK)
