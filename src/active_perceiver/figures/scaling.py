"""What training costs over the number of scenes: time and memory, side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from active_perceiver.figures.style import INK, MUTED, SERIES

# By learner and states of each scene: number of scenes and cost.
Curves = Mapping[str, Mapping[int, Sequence[tuple[int, float]]]]

_STYLES: tuple[Literal["-", "--", ":"], ...] = ("-", "--", ":")
_MARKERS = ("o", "s", "^")


def scaling_figure(seconds: Curves, memory: Curves) -> Figure:
    """Two panels over the number of scenes, all axes logarithmic.

    Each size of scenes has a colour, each learner a line style.

    Args:
        seconds: until the policy is good.
        memory: in MiB.

    Raises:
        ValueError: if there is nothing to draw, more sizes than colours or more learners than line styles.
    """
    learners = list(dict.fromkeys([*seconds, *memory]))
    sizes = sorted({size for curves in (seconds, memory) for some in curves.values() for size in some})
    if not sizes or len(sizes) > len(SERIES) or len(learners) > len(_STYLES):
        raise ValueError(
            f"from 1 to {len(SERIES)} sizes and {len(_STYLES)} learners can be told apart, got {len(sizes)} and "
            f"{len(learners)}"
        )
    counts = sorted(
        {
            count
            for curves in (seconds, memory)
            for some in curves.values()
            for points in some.values()
            for count, _ in points
        }
    )
    colours = dict(zip(sizes, SERIES, strict=False))
    figure = Figure(figsize=(9.6, 4.4), dpi=130, layout="constrained")
    labels = ("seconds of training", "memory of training, MiB")
    for axes, curves, label in zip(figure.subplots(1, 2, sharex=True), (seconds, memory), labels, strict=True):
        for learner, style, marker in zip(learners, _STYLES, _MARKERS, strict=False):
            for size, points in curves.get(learner, {}).items():
                axes.plot(
                    *zip(*points, strict=True), color=colours[size], linestyle=style, marker=marker, markersize=4.5,
                    linewidth=1.9,
                )  # fmt: skip
        _style(axes, counts)
        axes.set_ylabel(label, fontsize=11, color=INK)
    handles = [Line2D([], [], color=colours[size], linewidth=1.9, label=f"{size} states each") for size in sizes]
    handles += [
        Line2D([], [], color=INK, linestyle=style, marker=marker, markersize=4.5, label=learner)
        for learner, style, marker in zip(learners, _STYLES, _MARKERS, strict=False)
    ]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), fontsize=9, frameon=False, labelcolor=INK
    )
    return figure


def _style(axes: Axes, counts: Sequence[int]) -> None:
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xticks(counts)
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.margins(x=0.1)
    axes.grid(color=MUTED, alpha=0.25, linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=9, colors=INK)
    axes.set_xlabel("scenes", fontsize=11, color=INK)
