"""How searches end when something is different from training: a bar for each condition."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from active_perceiver.figures.style import GOAL, INK, MUTED, OBSTACLE, SERIES

ENDS = {"found": GOAL, "false “found”": SERIES[1], "not found": OBSTACLE}
"""How a search by the agent's own word may end, and the colours of its parts of the bars."""


def robustness_figure(bars: Mapping[str, tuple[float, float, float]]) -> Figure:
    """Horizontal bars from 0 to 100 %, each the shares of searches that ended truly, falsely and not at all.

    Args:
        bars: by condition, from top to bottom, the three shares, 0..1, which sum to 1.

    Raises:
        ValueError: if there are no bars, or the shares of one do not sum to 1.
    """
    if not bars:
        raise ValueError("there is nothing to draw")
    for condition, shares in bars.items():
        if abs(sum(shares) - 1) > 1e-3 or min(shares) < 0:
            raise ValueError(f"the shares of '{condition}' must not be negative and sum to 1, got {shares}")
    figure = Figure(figsize=(7.4, 1.3 + 0.3 * len(bars)), dpi=130, layout="constrained")
    axes = figure.subplots()
    rows = np.arange(len(bars))
    ends = np.zeros(len(bars))
    for column, (label, colour) in enumerate(ENDS.items()):
        widths = 100 * np.array([shares[column] for shares in bars.values()])
        axes.barh(rows, widths, left=ends, height=0.72, color=colour, label=label)
        ends += widths
    for row, (true, false, _) in zip(rows, bars.values(), strict=True):
        text = f"{100 * true:.1f} %" + (f", false {100 * false:.1f} %" if false >= 0.0005 else "")
        axes.annotate(text, (100, row), (5, 0), textcoords="offset points", va="center", fontsize=9, color=INK)
    axes.set_yticks(rows, list(bars))
    axes.invert_yaxis()
    axes.set_xlim(0, 124)
    axes.set_xticks(range(0, 101, 20))
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(labelsize=9, colors=INK, left=False)
    axes.set_xlabel("searches, %", fontsize=10, color=INK)
    axes.set_axisbelow(True)
    axes.grid(axis="x", color=MUTED, alpha=0.25, linewidth=0.6)
    figure.legend(loc="outside upper center", ncols=len(ENDS), fontsize=9, frameon=False, labelcolor=INK)
    return figure
