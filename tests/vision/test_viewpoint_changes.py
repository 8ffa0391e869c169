"""Images as from a pose near by: against a room that is rendered from there."""

import numpy as np
import pytest

from active_perceiver.vision.viewpoint_changes import from_nearby, turned
from box_room import box_room
from indoor_rooms.renderer.camera import render
from indoor_rooms.renderer.lighting import bake

PLACE, SIZE, FOV = (1.5, 1.5, 1.2), 64, 75.0


@pytest.fixture(scope="module")
def baked():
    return bake(box_room(), 8, 1, 0)


def seen(baked, heading=90.0, tilt=0.0):
    return render(baked, PLACE, heading, tilt, SIZE, FOV).image


@pytest.mark.parametrize(("turn", "tilt"), [(8, 0), (-8, 0), (0, 6), (0, -6), (5, 4)])
def test_a_turned_image_is_what_the_turned_camera_sees(baked, turn, tilt):
    made = turned(seen(baked), turn, tilt, 0, 1, FOV)
    # Turning first and tilting then is not tilting and then turning; for small angles it nearly is.
    expected = seen(baked, 90.0 + turn, tilt)
    middle = slice(14, -14)
    off = np.abs(made[middle, middle].astype(int) - expected[middle, middle]).mean()
    unturned = np.abs(seen(baked)[middle, middle].astype(int) - expected[middle, middle]).mean()
    assert off < 4
    assert off < unturned / 2


def test_nothing_changed_is_the_image_itself(baked):
    np.testing.assert_array_equal(turned(seen(baked), 0, 0, 0, 1, FOV), seen(baked))


def test_zoom_is_about_the_middle():
    image = np.zeros((40, 40, 3), np.uint8)
    image[15:25, 15:25] = 255
    assert turned(image, 0, 0, 0, 2.0, FOV)[:, :, 0].mean() == pytest.approx(4 * image[:, :, 0].mean(), rel=0.15)


def test_a_roll_turns_the_picture():
    image = np.zeros((40, 40, 3), np.uint8)
    image[:20] = 200
    rolled = turned(image, 0, 0, 90, 1, FOV)
    assert (rolled[5:-5, :15, 0] != rolled[5:-5, -15:, 0]).all()


def test_near_by_is_near_by_and_follows_from_the_seed(baked):
    image = seen(baked)
    made = [from_nearby(image, np.random.default_rng(seed), 10.0, FOV) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(made[0], made[1])
    assert (made[0] != made[2]).any()
    assert all(one.shape == image.shape and one.dtype == np.uint8 for one in made)
