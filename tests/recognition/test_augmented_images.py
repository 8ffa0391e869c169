from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.ndimage import uniform_filter

from active_perceiver.recognition.augmented_images import changed_picture, changed_view, picture_from_view, window
from active_perceiver.recognition.metrics import box_iou


def painted(box, colour=(255, 0, 0), side=100):
    """Grey with one box painted."""
    image = np.full((side, side, 3), 90, np.uint8)
    x, y, width, height = np.asarray(box) * side
    image[round(y - height / 2) : round(y + height / 2), round(x - width / 2) : round(x + width / 2)] = colour
    return image


def box_of_red(image):
    """Where red is more than the rest, as a box; single pixels of noise are no red."""
    red = uniform_filter(image[..., 0].astype(float) - image[..., 1:].max(axis=2), 5)
    rows, columns = np.nonzero(red > red.max() / 2)
    low, high = np.array([columns.min(), rows.min()]), np.array([columns.max(), rows.max()]) + 1
    return np.concatenate([(low + high) / 2, high - low]) / len(image)


def test_a_window_inside_is_that_part():
    image = np.random.default_rng(0).integers(0, 256, (40, 40, 3), dtype=np.uint8)
    assert (window(image, 5, 7, 20, 20, mirrored=False) == image[7:27, 5:25]).all()
    assert (window(image, 5, 7, 20, 20, mirrored=True) == image[7:27, 5:25][:, ::-1]).all()


@pytest.mark.parametrize(("left", "top"), [(-10, 0), (0, -10), (30, 0), (0, 30), (-3.2, 33.7)])
def test_beyond_the_image_its_edge_goes_on(left, top):
    image = np.full((40, 40, 3), 7, np.uint8)
    assert (window(image, left, top, 20, 16, mirrored=False) == 7).all()


@given(st.integers(0, 2**32 - 1))
@example(24623)  # much noise
def test_boxes_move_with_what_is_in_them(seed):
    box = np.array([0.55, 0.4, 0.3, 0.2])
    image, boxes, kept = changed_view(
        painted(box), np.stack([box, np.full(4, np.nan)]), 96, np.random.default_rng(seed)
    )
    assert image.shape == (96, 96, 3)
    assert image.dtype == np.uint8
    assert np.isnan(boxes[1]).all()
    assert np.isnan(kept[1])
    assert 0.0 <= kept[0] <= 1.0
    assert ((boxes[0, :2] - boxes[0, 2:] / 2 > -1e-6) & (boxes[0, :2] + boxes[0, 2:] / 2 < 1 + 1e-6)).all()
    if kept[0] > 0.3:
        assert box_iou(boxes[0], box_of_red(image)) > 0.7


def test_what_is_left_of_a_box_is_measured():
    inside, corner = np.array([0.5, 0.5, 0.1, 0.1]), np.array([0.01, 0.01, 0.02, 0.02])
    image = np.zeros((64, 64, 3), np.uint8)
    kept = np.array(
        [changed_view(image, np.stack([inside, corner]), 64, np.random.default_rng(seed))[2] for seed in range(60)]
    )
    assert kept[:, 0] == pytest.approx(1.0)  # the middle is always in it
    assert (kept[:, 1] == 0).any()  # the corner is not


def test_target_pictures_keep_the_object_in_the_middle():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        x, y, *_ = box_of_red(changed_picture(painted([0.5, 0.5, 0.4, 0.4]), 64, rng))
        assert abs(x - 0.5) < 0.3
        assert abs(y - 0.5) < 0.3
        box = np.array([0.2, 0.7, 0.2, 0.1])
        x, y, width, height = box_of_red(picture_from_view(painted(box), box, 64, rng))
        assert abs(x - 0.5) < 0.25
        assert abs(y - 0.5) < 0.25
        assert width / height == pytest.approx(2.0, rel=0.25)
        assert 1 / 2.4 < width < 1 / 1.1


def test_an_object_at_the_edge_can_be_cut_out():
    box = np.array([0.98, 0.5, 0.04, 0.3])
    assert picture_from_view(painted(box), box, 64, np.random.default_rng(0)).shape == (64, 64, 3)
