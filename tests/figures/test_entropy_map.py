"""Entropy maps: each place's square has the mean of its states, at its place and with its size."""

import dataclasses

import numpy as np
import pytest
from matplotlib.collections import PatchCollection

from active_perceiver.figures.entropy_map import entropy_maps, lattice_spacing, mean_by_place
from active_perceiver.figures.floor import figure_image, figure_png
from helpers.toy import STEP

MOST = float(np.log(8))


def squares(axes) -> PatchCollection:
    (found,) = [item for item in axes.collections if isinstance(item, PatchCollection)]
    return found


def maps(scene, entropy, most=MOST):
    return entropy_maps(scene, {"low": [entropy]}, ["end"], most)


def test_values_are_averaged_over_headings_and_tilts(scene):
    values = np.random.default_rng(0).random(len(scene))
    order = np.random.default_rng(1).permutation(len(scene))
    places, means = mean_by_place(scene.poses[order], values[order])
    assert places.shape == (16, 2)
    for place, mean in zip(places, means, strict=True):
        here = np.linalg.norm(scene.poses[:, :2] - place, axis=1) < 0.01
        assert here.sum() == 12
        np.testing.assert_allclose(mean, values[here].mean())


def test_a_square_stands_at_each_place_with_its_value(scene):
    entropy = np.random.default_rng(0).uniform(0, MOST, len(scene))
    axes = maps(scene, entropy).axes[0]
    places, means = mean_by_place(scene.poses, entropy)
    drawn = squares(axes)
    np.testing.assert_allclose(drawn.get_array(), means)
    for path, place in zip(drawn.get_paths(), places, strict=True):
        extent = path.get_extents()
        np.testing.assert_allclose((extent.min + extent.max) / 2, place, atol=1e-6)
        assert 0.85 * STEP < extent.width < STEP
        assert extent.width == pytest.approx(extent.height)


def test_all_maps_share_one_scale_and_one_colour_bar(scene):
    def level(value):
        return np.full(len(scene), value)

    rows = {"high": [level(2.0), level(1.5), level(1.0)], "low": [level(2.0), level(0.5), level(0.0)]}
    figure = entropy_maps(scene, rows, ["start", "middle", "end"], MOST)
    *panels, bar = figure.axes
    assert len(panels) == 6
    assert bar.get_ylabel() == "mean entropy (nats)"
    assert bar.get_ylim() == pytest.approx((0, MOST))
    assert [axes.get_title() for axes in panels] == ["start", "middle", "end", "", "", ""]
    assert [text.get_text() for axes in panels for text in axes.texts] == ["high", "low"]
    for axes in panels:
        assert squares(axes).get_clim() == (0, MOST)
    assert [float(squares(axes).get_array()[0]) for axes in panels] == [2.0, 1.5, 1.0, 2.0, 0.5, 0.0]


def test_the_colours_show_and_squares_do_not_leave_the_room(scene):
    # All places are moved to a corner of a room that is smaller than their squares.
    poses = scene.poses.copy()
    poses[:, :2] -= STEP
    image = figure_image(maps(dataclasses.replace(scene, poses=poses), np.zeros(len(scene))))
    dark = (np.abs(image.astype(int) - (68, 1, 84)) < 12).all(-1)
    outline = (np.abs(image.astype(int) - (34, 48, 60)) < 12).all(-1)
    walls = np.flatnonzero(outline.mean(0) > 0.5)
    columns = np.flatnonzero(dark[:, : walls[-1]].any(0))
    assert dark.sum() > 1000
    assert columns[0] >= walls[0]


def test_without_a_plan_and_for_a_single_place_it_renders(scene):
    bare = dataclasses.replace(scene, floor_plan=None)
    assert figure_png(maps(bare, np.ones(len(scene)))).startswith(b"\x89PNG")
    assert lattice_spacing(np.zeros((1, 2))) > 0


@pytest.mark.parametrize("angle", [0, 30, 45])
def test_squares_never_overlap_even_on_a_turned_lattice(angle):
    grid = np.stack(np.meshgrid(np.arange(4), np.arange(4)), -1).reshape(-1, 2) * 0.3
    turn = np.radians(angle)
    places = grid @ np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    side = lattice_spacing(places)
    apart = np.abs(places[:, None] - places).max(-1) + np.eye(len(places))
    assert side == pytest.approx(apart.min())
    assert (side == pytest.approx(0.3)) == (angle == 0)


def test_bad_input_is_refused(scene):
    good = np.ones(len(scene))
    broken = good.copy()
    broken[5] = np.nan
    for entropy in (good[:-1], good[:, None], 1.0):
        with pytest.raises(ValueError, match="low, end: 192 entropies are needed"):
            maps(scene, entropy)
    for entropy in (broken, good * 3, -good):
        with pytest.raises(ValueError, match=r"low, end: each entropy is a number from 0 to 2\.079"):
            maps(scene, entropy)
    with pytest.raises(ValueError, match="low: 2 columns are needed, got 1"):
        entropy_maps(scene, {"low": [good]}, ["start", "end"], MOST)
    for rows, columns, most in (({}, ["end"], 1), ({"low": []}, [], 1), ({"low": [good]}, ["end"], 0)):
        with pytest.raises(ValueError, match="at least one row"):
            entropy_maps(scene, rows, columns, most)
    # A uniform policy's entropy, rounded to single precision, is at the end of the scale.
    maps(scene, np.full(len(scene), np.nextafter(np.float32(MOST), np.float32(9))))
