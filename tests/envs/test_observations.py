"""Observations: how they are made, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from active_perceiver.envs import Observations, SearchError, SearchTask, location_mask


@pytest.fixture
def features():
    rng = np.random.default_rng(0)
    return rng.random((20, 8), np.float32), rng.random((3, 2, 8), np.float32)


@pytest.fixture
def boxes():
    some = np.random.default_rng(1).uniform(0.2, 0.6, (20, 3, 4))
    some[::3] = np.nan
    return some


def test_ground_truth_is_the_same_for_every_picture(features, boxes):
    observations = Observations.from_boxes(*features, boxes)
    assert observations.pictures == 2
    for picture in range(2):
        np.testing.assert_array_equal(observations.masks[:, :, picture], location_mask(boxes))


def test_detections_below_the_threshold_are_not_seen(features):
    rng = np.random.default_rng(2)
    scores, boxes = rng.random((20, 3, 2)), rng.uniform(0.2, 0.6, (20, 3, 2, 4))
    scores[0, 0, 0] = 0.7
    observations = Observations.from_detections(*features, scores, boxes, threshold=0.7)
    seen = observations.masks.any(-1)
    np.testing.assert_array_equal(seen, scores >= 0.7)
    np.testing.assert_array_equal(observations.masks[0, 0, 0], location_mask(boxes[0, 0, 0]))


@pytest.mark.parametrize(
    ("field", "change", "message"),
    [
        ("view_features", lambda array: array * np.float32(np.nan), "not finite"),
        ("view_features", lambda array: array[:, :-1], "use one backbone"),
        ("view_features", lambda array: array.astype(np.float64), "expected float32"),
        ("view_features", lambda array: array[0], "need the shapes"),
        ("target_features", lambda array: array[:, :0], "at least one picture"),
        ("masks", lambda array: array[:, :1], "masks have shape"),
        ("masks", lambda array: array + np.float32(0.5), "0 or 1"),
    ],
)
def test_refuses_unsound_arrays(features, boxes, field, change, message):
    observations = Observations.from_boxes(*features, boxes)
    with pytest.raises(SearchError, match=message):
        replace(observations, **{field: change(getattr(observations, field))})


def test_refuses_boxes_that_do_not_go_with_the_scores(features):
    with pytest.raises(SearchError, match="to go with the scores"):
        Observations.from_detections(*features, np.zeros((20, 3, 2)), np.zeros((20, 3, 4)))


def test_refuses_another_task(features, boxes, scene):
    with pytest.raises(SearchError, match="do not fit"):
        Observations.from_boxes(*features, boxes).check_fits(SearchTask.from_scene(scene))
