"""The plot of policies over seeds: a dot for each training, limits that differ by setup, and nonsense is refused."""

from __future__ import annotations

import dataclasses

import pytest
from matplotlib.colors import to_hex

from active_perceiver.figures.policies_spread import SpreadDot, SpreadRow, policies_spread
from active_perceiver.figures.style import SERIES

KITCHEN = SpreadRow(
    "kitchen",
    {"a": [SpreadDot(1.004, 5.0, True), SpreadDot(1.012, 30.0, True)], "b": [SpreadDot(1.2, 3.0, False)]},
    1.02,
    15.0,
)
ROOMS = SpreadRow("4 scenes", {"a": [SpreadDot(None, 80.0, False)], "b": []}, 1.03, 90.0)


def dots(axes):
    """(x, row, colour, filled) of each."""
    return [
        (float(line.get_xdata()[0]), round(float(line.get_ydata()[0])), line.get_color(), line.get_markerfacecolor())
        for line in axes.get_lines()
        if line.get_marker() == "o"
    ]


def test_every_training_is_a_dot_in_both_panels():
    left, right = policies_spread([KITCHEN, ROOMS]).axes
    blue, orange = SERIES[:2]
    edge = left.get_xlim()[1]
    assert dots(left) == [
        (1.004, 0, blue, blue), (1.012, 0, blue, blue), (1.2, 0, orange, "white"), (edge, 1, blue, "white"),
    ]  # fmt: skip
    assert [x for x, *_ in dots(right)] == [5.0, 30.0, 3.0, 80.0]
    heights = [float(line.get_ydata()[0]) for line in left.get_lines() if line.get_marker() == "o"]
    assert len(set(heights)) == len(heights)  # none hides another of its row
    assert [label.get_text() for label in left.get_yticklabels()] == ["kitchen", "4 scenes"]
    assert left.get_ylim()[0] > left.get_ylim()[1]  # from top to bottom


def test_limits_stand_in_their_rows():
    for axes, limits in zip(policies_spread([KITCHEN, ROOMS]).axes, ([1.02, 1.03], [15.0, 90.0]), strict=True):
        strokes = [line for line in axes.get_lines() if line.get_marker() != "o"]
        assert [line.get_xdata()[0] for line in strokes] == limits
        assert [sum(line.get_ydata()) / 2 for line in strokes] == pytest.approx([0, 1])
        assert axes.get_xlim()[0] < limits[0] < limits[1] < axes.get_xlim()[1]


def test_the_legend_names_learners_and_limit():
    (legend,) = policies_spread([KITCHEN]).legends
    assert [text.get_text() for text in legend.get_texts()] == ["a", "b", "limit"]
    assert [to_hex(line.get_color()) for line in legend.get_lines()][:2] == list(SERIES[:2])


@pytest.mark.parametrize(
    "rows",
    [
        [],
        [dataclasses.replace(KITCHEN, dots={})],
        [KITCHEN, dataclasses.replace(ROOMS, dots={"a": []})],
        [dataclasses.replace(KITCHEN, dots={str(number): [] for number in range(8)})],
    ],
)
def test_nonsense_is_refused(rows):
    with pytest.raises(ValueError, match="can be told apart"):
        policies_spread(rows)
