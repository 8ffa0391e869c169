"""The bars of `benchmark recogniser`: as long as the AP50, with marks for what else was measured."""

from __future__ import annotations

import dataclasses

import pytest

from active_perceiver.figures.ablation import AblationRow, ablation_figure
from active_perceiver.figures.floor import figure_png

KITCHEN = [
    AblationRow("default", 0.9, 0.95), AblationRow("held out", 0.8, 0.85, 0.4), AblationRow("bare", None, 0.1),
]  # fmt: skip
OFFICE = [dataclasses.replace(row, unseen=0.5, unknown=None) for row in KITCHEN]


def marks(axes, marker):
    return [
        (float(line.get_xdata()[0]), int(line.get_ydata()[0]))
        for line in axes.get_lines()
        if line.get_marker() == marker
    ]


def test_bars_and_marks_are_where_the_figures_say():
    figure = ablation_figure({"kitchen": KITCHEN, "office": OFFICE})
    kitchen, office = figure.axes
    assert [axes.get_title() for axes in figure.axes] == ["kitchen", "office"]
    assert [bar.get_width() for bar in kitchen.patches] == [0.9, 0.8, 0.0]
    assert [bar.get_width() for bar in office.patches] == [0.5, 0.5, 0.5]
    assert marks(kitchen, "|") == [(0.95, 0), (0.85, 1), (0.1, 2)]
    assert marks(kitchen, "D") == [(0.4, 1)]
    assert marks(office, "D") == []
    assert [text.get_text() for text in kitchen.texts] == ["0.900", "0.800", "-"]
    assert [label.get_text() for label in kitchen.get_yticklabels()] == ["default", "held out", "bare"]
    assert kitchen.get_ylim()[0] > kitchen.get_ylim()[1]  # from top to bottom
    assert figure_png(figure)[:4] == b"\x89PNG"


def test_the_first_variant_goes_on_as_a_line():
    for axes, value in zip(ablation_figure({"kitchen": KITCHEN, "office": OFFICE}).axes, (0.9, 0.5), strict=True):
        assert [list(line.get_xdata()) for line in axes.get_lines() if line.get_linestyle() == "--"] == [[value] * 2]


def test_the_legend_names_only_what_is_there():
    def named(panels):
        return [text.get_text() for text in ablation_figure(panels).legends[0].get_texts()]

    assert named({"office": OFFICE}) == ["pictures not trained with", "trained with"]
    assert named({"kitchen": KITCHEN})[2:] == ["targets never learned"]


@pytest.mark.parametrize(
    ("panels", "message"),
    [
        ({}, "at least one"),
        ({"kitchen": []}, "at least one"),
        ({"kitchen": KITCHEN, "office": OFFICE[:2]}, "the same variants"),
        ({"kitchen": [AblationRow("default", 1.2, 0.9)]}, "in 0..1"),
        ({"kitchen": [AblationRow("default", float("nan"), 0.9)]}, "in 0..1"),
    ],
)
def test_nonsense_is_refused(panels, message):
    with pytest.raises(ValueError, match=message):
        ablation_figure(panels)
