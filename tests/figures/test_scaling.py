"""The plot of what training costs: every point is in it, and nonsense is refused."""

from __future__ import annotations

import pytest

from active_perceiver.figures.scaling import scaling_figure

SECONDS = {"distil": {200: [(1, 1.0), (16, 20.0)], 800: [(1, 2.0)]}, "ppo": {200: [(1, 6.0)]}}
MEMORY = {"distil": {200: [(1, 40.0), (16, 200.0)]}, "ppo": {200: [(1, 30.0), (64, 90.0)], 3200: [(1, 100.0)]}}


def test_every_point_is_drawn_by_size_and_learner() -> None:
    figure = scaling_figure(SECONDS, MEMORY)
    for axes, curves in zip(figure.axes, (SECONDS, MEMORY), strict=True):
        drawn = [[tuple(point) for point in line.get_xydata().tolist()] for line in axes.get_lines()]
        assert drawn == [points for some in curves.values() for points in some.values()]
        assert axes.get_xticks().tolist() == [1, 16, 64]
        assert axes.get_xscale() == axes.get_yscale() == "log"
    time, memory = (axes.get_lines() for axes in figure.axes)
    assert time[0].get_color() == time[2].get_color() == memory[0].get_color() != time[1].get_color()
    assert time[0].get_linestyle() == time[1].get_linestyle() != time[2].get_linestyle()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["200 states each", "800 states each", "3200 states each", "distil", "ppo"]


def test_what_was_never_good_leaves_a_gap() -> None:
    figure = scaling_figure({}, MEMORY)
    assert [len(axes.get_lines()) for axes in figure.axes] == [0, 3]


def test_nonsense_is_refused() -> None:
    many_sizes = {"distil": {size: [(1, 1.0)] for size in range(1, 9)}}
    many_learners = {str(number): {200: [(1, 1.0)]} for number in range(4)}
    for curves in ({}, {"distil": {}}, many_sizes, many_learners):
        with pytest.raises(ValueError, match="can be told apart"):
            scaling_figure(curves, {})
