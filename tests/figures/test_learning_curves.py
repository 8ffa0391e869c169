"""Learning curves: lines and bands are where the numbers are, and nothing is hidden or mixed up."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from active_perceiver.figures.floor import figure_png
from active_perceiver.figures.learning_curves import Curve, learning_curves
from active_perceiver.figures.style import SERIES

LENGTHS = np.array([[4000.0, 900.0, 100.0], [3000.0, 500.0, 80.0], [5000.0, 400.0, 60.0]])


def curve(label: str = "record", points: int = 3, factor: float = 1.0) -> Curve:
    return Curve(label, np.arange(points) * 10, LENGTHS[:, :points] * factor)


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def test_the_line_is_the_mean_and_the_band_reaches_from_least_to_most():
    axes = learning_curves({"PPO": [curve()]}).axes[0]
    line = lines(axes)["record"]
    np.testing.assert_allclose(line.get_xdata(), [0, 10, 20])
    np.testing.assert_allclose(line.get_ydata(), [4000, 600, 80])
    (band,) = axes.collections
    corners = {tuple(corner) for corner in band.get_paths()[0].vertices}
    assert {(0, 3000), (0, 5000), (10, 400), (10, 900), (20, 60), (20, 100)} <= corners
    assert axes.get_yscale() == "log"
    assert axes.get_title() == "PPO"


def test_each_panel_shows_its_own_curves_and_lines():
    figure = learning_curves(
        {"A3C": [curve("reward 1"), curve("record", 2)], "PPO": [curve("record")]},
        random_walk={"A3C": 2000.0, "PPO": 2500.0},
        shortest={"PPO": 12.0},
    )
    a3c, ppo = (lines(axes) for axes in figure.axes)
    assert set(a3c) == {"reward 1", "record", "random walk"}
    assert set(ppo) == {"record", "random walk", "shortest paths"}
    assert len(a3c["record"].get_xdata()) == 2
    assert set(ppo["random walk"].get_ydata()) == {2500}
    assert set(ppo["shortest paths"].get_ydata()) == {12}
    assert (ppo["random walk"].get_linestyle(), ppo["shortest paths"].get_linestyle()) == ("--", ":")
    # Panels are compared with each other.
    assert figure.axes[0].get_ylim() == figure.axes[1].get_ylim()
    assert figure.axes[0].get_ylim()[0] < 12


def test_a_label_keeps_its_colour_and_stands_in_the_legend_once():
    figure = learning_curves({"A3C": [curve("a"), curve("b")], "PPO": [curve("b"), curve("c")]}, {"PPO": 99.0})
    a3c, ppo = (lines(axes) for axes in figure.axes)
    assert a3c["b"].get_color() == ppo["b"].get_color()
    assert len({a3c["a"].get_color(), a3c["b"].get_color(), ppo["c"].get_color()}) == 3
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["a", "b", "c", "random walk"]


def test_colours_of_curves_are_far_apart():
    colours = np.array([to_rgb(colour) for colour in SERIES])
    distance = np.linalg.norm(colours[:, None] - colours, axis=-1) + 9 * np.eye(len(colours))
    assert distance.min() > 0.25


@pytest.mark.parametrize("panels", [1, 2, 4])
def test_the_legend_lies_within_the_figure_and_below_the_axes(panels):
    labels = ["reward 1 (goal only)", "reward 2 (area)", "record, high entropy", "record, low entropy"]
    figure = learning_curves({f"learner {k}": [curve(label) for label in labels] for k in range(panels)})
    assert figure_png(figure).startswith(b"\x89PNG")
    legend = figure.legends[0].get_window_extent()
    assert legend.x0 >= 0
    assert legend.x1 <= figure.bbox.width
    assert legend.y0 >= 0
    assert legend.y1 <= min(axes.xaxis.label.get_window_extent().y0 for axes in figure.axes)
    assert len(figure.axes) == panels


def test_a_single_measurement_shows():
    figure = learning_curves({"PPO": [Curve("x", np.array([0]), np.array([[200.0]]))]})
    assert lines(figure.axes[0])["x"].get_marker() == "o"
    assert figure_png(figure).startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("iterations", "lengths"),
    [
        ([0, 1], [[1.0, 2.0, 3.0]]),
        ([0, 1], [1.0, 2.0]),
        ([[0, 1]], [[1.0, 2.0]]),
        ([], np.zeros((2, 0))),
        ([0, 1], np.zeros((0, 2))),
        ([0, 1], [[1.0, np.nan]]),
        ([0, 1], [[1.0, np.inf]]),
        ([0, 1], [[1.0, 0.0]]),
        ([1, 1], [[1.0, 2.0]]),
        ([0, np.nan], [[1.0, 2.0]]),
    ],
)
def test_bad_curves_are_refused(iterations, lengths):
    with pytest.raises(ValueError, match="reward 1: "):
        Curve("reward 1", np.array(iterations), np.array(lengths))


def test_what_could_be_misread_is_refused():
    with pytest.raises(ValueError, match="at least one curve"):
        learning_curves({})
    with pytest.raises(ValueError, match="at least one curve"):
        learning_curves({"PPO": []})
    with pytest.raises(ValueError, match="same label"):
        learning_curves({"PPO": [curve("a"), curve("a")]})
    with pytest.raises(ValueError, match="too many"):
        learning_curves({"PPO": [curve(str(k)) for k in range(len(SERIES) + 1)]})
    with pytest.raises(ValueError, match="'ppo' cannot be drawn; the panels are PPO"):
        learning_curves({"PPO": [curve()]}, random_walk={"ppo": 100.0})
    with pytest.raises(ValueError, match="line at nan"):
        learning_curves({"PPO": [curve()]}, shortest={"PPO": float("nan")})
