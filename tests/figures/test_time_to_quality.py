"""Time to quality: curves hold what was measured last, bands reach over all seeds, and nonsense is refused."""

import numpy as np
import pytest

from active_perceiver.figures.floor import figure_png
from active_perceiver.figures.time_to_quality import Training, time_to_quality


def training(seconds, ratio, success=None):
    success = np.ones(len(seconds)) if success is None else success
    return Training(np.array(seconds, float), np.array(success, float), np.array(ratio, float))


def curve(axes, label):
    (line,) = (line for line in axes.get_lines() if line.get_label() == label)
    return line.get_xdata().tolist(), line.get_ydata().tolist()


def test_a_curve_is_the_median_of_what_each_seed_was_measured_at_last():
    seeds = [training([1, 4], [9, 3]), training([2, 3], [7, 1]), training([1.5], [5])]
    figure = time_to_quality({"a": seeds}, 1.25)
    seconds, ratios = curve(figure.axes[0], "a")
    # It begins when the last seed has been measured once.
    assert seconds == [2, 3, 4]
    assert ratios == [7, 5, 3]
    band = figure.axes[0].collections[0].get_paths()[0].vertices
    assert {(2, 5), (2, 9), (3, 1), (4, 1), (4, 5)} <= {tuple(corner) for corner in band}


def test_both_panels_and_the_quality_waited_for_are_there():
    learners = {
        "mine": [training([0.1, 1], [20, 1.1], [0.5, 1])],
        "theirs": [training([10, 100], [30, 1.2], [0.6, 1])],
    }
    figure = time_to_quality(learners, 1.25)
    above, below = figure.axes
    assert curve(above, "theirs") == ([10, 100], [30, 1.2])
    assert curve(below, "mine") == ([0.1, 1], [0.5, 1])
    assert any(set(line.get_ydata()) == {1.25} for line in above.get_lines())
    assert above.get_xscale() == above.get_yscale() == below.get_xscale() == "log"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["mine", "theirs"]
    colours = [
        next(line for line in axes.get_lines() if line.get_label() == "mine").get_color() for axes in figure.axes
    ]
    assert colours[0] == colours[1]
    assert figure_png(figure).startswith(b"\x89PNG")


def test_where_no_search_arrives_there_is_a_gap_in_the_ratio_only():
    figure = time_to_quality({"a": [training([1, 2], [np.nan, 2], [0, 0.5])]}, 1.25)
    np.testing.assert_equal(curve(figure.axes[0], "a")[1], [np.nan, 2])
    assert curve(figure.axes[1], "a")[1] == [0, 0.5]
    assert figure_png(figure).startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("seconds", "ratio", "message"),
    [
        ([1, 2], [1], "as many times"),
        ([], [], "as many times"),
        ([0, 1], [2, 2], "positive"),
        ([1, 1], [2, 2], "increase"),
    ],
)
def test_bad_trainings_are_refused(seconds, ratio, message):
    with pytest.raises(ValueError, match=message):
        Training(np.array(seconds, float), np.ones(len(seconds)), np.array(ratio, float))


@pytest.mark.parametrize("learners", [{}, {"a": []}, {str(number): [training([1], [2])] for number in range(8)}])
def test_what_cannot_be_told_apart_is_refused(learners):
    with pytest.raises(ValueError, match="can be told apart"):
        time_to_quality(learners, 1.25)
