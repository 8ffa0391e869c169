"""Plots of benchmarks: everything given is in them, and nonsense is refused."""

from __future__ import annotations

import pytest

from active_perceiver.figures.speed import parts_figure, speed_figure

POINTS = [(1, 90.0, 100.0, 110.0), (64, 4000.0, 5000.0, 6000.0)]
PANELS = {"Lite0": {"1 thread": {"a": 2.0, "b": 3.0}, "torch": {"c": 30.0}}, "ResNet": {"1 thread": {"a": 70.0}}}


def test_speeds_are_curves_through_the_medians() -> None:
    (axes,) = speed_figure({"scalar": POINTS[:1], "vector": POINTS}).axes
    drawn = {line.get_label(): line.get_xydata().tolist() for line in axes.get_lines()}
    assert drawn == {"scalar": [[1, 100.0]], "vector": [[1, 100.0], [64, 5000.0]]}
    assert {text.get_text() for text in axes.texts} == {"100", "5 k"}
    assert axes.get_xticks().tolist() == [1, 64]


def test_parts_are_stacked_in_panels_with_one_legend() -> None:
    figure = parts_figure(PANELS)
    assert [axes.get_title("left") for axes in figure.axes] == list(PANELS)
    first = figure.axes[0]
    assert [(bar.get_x(), bar.get_width()) for bar in first.patches] == [(0, 2.0), (2.0, 3.0), (0, 30.0)]
    assert [text.get_text() for text in first.texts] == ["5.0 ms", "30.0 ms"]
    colours = {axes.patches[0].get_facecolor() for axes in figure.axes}
    assert len(colours) == 1  # part "a" in both panels
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["a", "b", "c"]


def test_nonsense_is_refused() -> None:
    for curves in ({}, {"vector": []}, {str(number): POINTS for number in range(8)}):
        with pytest.raises(ValueError, match="can be told apart"):
            speed_figure(curves)
    for panels in ({}, {"Lite0": {}}, {"Lite0": {"bar": {str(number): 1.0 for number in range(8)}}}):
        with pytest.raises(ValueError, match="can be told apart"):
            parts_figure(panels)
    with pytest.raises(ValueError, match="negative"):
        parts_figure({"Lite0": {"bar": {"a": -1.0}}})
