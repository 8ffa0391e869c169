"""How fast things run: speeds over how many run side by side, and times by their parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from active_perceiver.figures.style import INK, MUTED, SERIES


def speed_figure(curves: Mapping[str, Sequence[tuple[int, float, float, float]]]) -> Figure:
    """Steps per second over the number of searches side by side, both logarithmic.

    Args:
        curves: by environment, for each number of searches that number and the least, median and most steps per
            second; lines go through the medians, bands from the least to the most.

    Raises:
        ValueError: if there is nothing to draw, or there are more curves than colours.
    """
    if not any(curves.values()) or len(curves) > len(SERIES):
        raise ValueError(f"from 1 to {len(SERIES)} curves can be told apart, got {len(curves)}")
    figure = Figure(figsize=(7.4, 4.6), dpi=130, layout="constrained")
    axes = figure.subplots()
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    for colour, (label, points) in zip(SERIES, curves.items(), strict=False):
        counts, least, median, most = zip(*points, strict=True)
        axes.fill_between(counts, least, most, color=colour, alpha=0.2, linewidth=0)
        axes.plot(counts, median, color=colour, marker="o", markersize=4.5, linewidth=1.9, label=label)
        axes.annotate(
            _short(median[-1]), (counts[-1], median[-1]), (6, -3), textcoords="offset points", fontsize=9, color=INK
        )
    axes.set_xticks(sorted({point[0] for points in curves.values() for point in points}))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: _short(value)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.margins(x=0.1)
    axes.grid(color=MUTED, alpha=0.25, linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=9, colors=INK)
    axes.set_xlabel("searches side by side", fontsize=11, color=INK)
    axes.set_ylabel("environment steps per second", fontsize=11, color=INK)
    axes.legend(fontsize=10, frameon=False, labelcolor=INK)
    return figure


def parts_figure(panels: Mapping[str, Mapping[str, Mapping[str, float]]], unit: str = "ms") -> Figure:
    """Times as horizontal bars, each made up of its parts, the sum written at its end.

    A part has the same colour in all bars. Each panel has a scale of its own.

    Args:
        panels: by panel and bar, from top to bottom, how long each of the bar's parts takes.
        unit: of the times.

    Raises:
        ValueError: if there is nothing to draw, a time is negative, or there are more parts than colours.
    """
    bars = [bar for panel in panels.values() for bar in panel.values()]
    parts = list(dict.fromkeys(part for bar in bars for part in bar))
    if not parts or len(parts) > len(SERIES):
        raise ValueError(f"from 1 to {len(SERIES)} parts can be told apart, got {len(parts)}")
    if any(time < 0 for bar in bars for time in bar.values()):
        raise ValueError("a time is never negative")
    colours = dict(zip(parts, SERIES, strict=False))
    heights = [0.8 + 0.36 * len(panel) for panel in panels.values()]
    figure = Figure(figsize=(8.6, 0.6 + sum(heights)), dpi=130, layout="constrained")
    rows = figure.subplots(len(panels), squeeze=False, height_ratios=heights)
    for axes, (title, panel) in zip(rows[:, 0], panels.items(), strict=True):
        _draw_bars(axes, panel, colours, unit)
        axes.set_title(title, fontsize=12, color=INK, loc="left")
    handles = [Patch(color=colour, label=part) for part, colour in colours.items()]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(parts), fontsize=9, frameon=False, labelcolor=INK
    )
    return figure


def _draw_bars(axes: Axes, bars: Mapping[str, Mapping[str, float]], colours: Mapping[str, str], unit: str) -> None:
    for row, bar in enumerate(bars.values()):
        end = 0.0
        for part, time in bar.items():
            axes.barh(row, time, left=end, height=0.66, color=colours[part])
            end += time
        axes.annotate(
            f"{end:.1f} {unit}", (end, row), (5, 0), textcoords="offset points", va="center", fontsize=9, color=INK
        )
    axes.set_yticks(range(len(bars)), list(bars))
    axes.invert_yaxis()
    axes.set_xlim(0, 1.12 * max([sum(bar.values()) for bar in bars.values()], default=1.0))
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.grid(axis="x", color=MUTED, alpha=0.25, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=9, colors=INK, left=False)


def _short(value: float) -> str:
    """12345 as "12 k"."""
    for size, letter in ((1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:.3g} {letter}"
    return f"{value:.3g}"
