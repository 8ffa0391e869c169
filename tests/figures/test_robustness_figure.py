"""The bars of `benchmark robustness`: as long as the shares say."""

import pytest

from active_perceiver.figures.floor import figure_png
from active_perceiver.figures.robustness import ENDS, robustness_figure

BARS = {"as trained": (1.0, 0.0, 0.0), "noise 25": (0.5, 0.125, 0.375)}


def test_bars_are_as_long_as_the_shares():
    figure = robustness_figure(BARS)
    (axes,) = figure.axes
    widths = [[bar.get_width() for bar in bars] for bars in axes.containers]
    assert widths == [[100.0, 50.0], [0.0, 12.5], [0.0, 37.5]]
    lefts = [bars[1].get_x() for bars in axes.containers]
    assert lefts == [0.0, 50.0, 62.5]
    assert [label.get_text() for label in axes.get_yticklabels()] == list(BARS)
    assert [text.get_text() for text in axes.texts] == ["100.0 %", "50.0 %, false 12.5 %"]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(ENDS)
    assert figure_png(figure)[:4] == b"\x89PNG"


@pytest.mark.parametrize("bars", [{}, {"fog": (0.5, 0.2, 0.2)}, {"fog": (1.2, -0.2, 0.0)}])
def test_what_cannot_be_drawn_is_refused(bars):
    with pytest.raises(ValueError, match=r"nothing to draw|sum to 1"):
        robustness_figure(bars)
