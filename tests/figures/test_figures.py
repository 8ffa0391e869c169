"""Figures: what is drawn is where it should be."""

import dataclasses

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.quiver import Quiver
from PIL import Image

from active_perceiver.figures.annotate import draw_detection
from active_perceiver.figures.contact_sheet import contact_sheet
from active_perceiver.figures.floor import (
    SearchPanel,
    draw_floor,
    figure_image,
    figure_png,
    trajectory_figure,
    trajectory_panels,
)
from active_perceiver.recognition.recogniser import Detection
from active_perceiver.scenes import FloorPlan
from active_perceiver.scenes.lattice import goal_states

BOX_COLOUR = (255, 77, 46)


@pytest.mark.parametrize("box", [(0.5, 0.5, 0.4, 0.2), (0.1, 0.1, 0.2, 0.2), (0.95, 0.95, 0.3, 0.3)])
def test_the_box_is_drawn_where_the_detection_says(box):
    drawn = draw_detection(np.full((50, 50, 3), 120, np.uint8), Detection(0.9, np.array(box)), "", 400)
    red = (np.abs(drawn.astype(int) - BOX_COLOUR) < 12).all(-1)
    columns = np.flatnonzero(red.mean(0) > 0.5 * min(box[3], 1 - box[1] + box[3] / 2))
    left = max(0, (box[0] - box[2] / 2) * 400)
    assert abs(columns[0] - left) <= 3


def test_without_a_detection_the_view_is_only_scaled():
    image = np.full((50, 50, 3), 120, np.uint8)
    assert (draw_detection(image, None, "mug", 100) == 120).all()


def test_trajectories_show_path_goals_and_start(scene):
    goals = goal_states(scene.areas)[:, 0]
    plain = figure_image(trajectory_figure(scene, []))
    drawn = figure_image(trajectory_figure(scene, [scene.poses[[0, 12, 24, 24]]], goals, "ball0"))
    assert plain.shape == drawn.shape
    start_orange = (np.abs(drawn.astype(int) - (240, 162, 2)) < 12).all(-1)
    goal_green = (np.abs(drawn.astype(int) - (42, 157, 92)) < 12).all(-1)
    assert start_orange.sum() > 20
    assert goal_green.sum() > 20
    assert not (np.abs(plain.astype(int) - (240, 162, 2)) < 12).all(-1).any()


def test_a_path_of_one_pose_and_a_scene_without_a_plan_can_be_drawn(scene):
    bare = dataclasses.replace(scene, floor_plan=None)
    assert figure_png(trajectory_figure(bare, [scene.poses[:1]])).startswith(b"\x89PNG")


def paths_of(axes):
    return [item for item in axes.collections if isinstance(item, LineCollection)]


def test_each_panel_shows_its_own_searches_and_goals(scene):
    goals = goal_states(scene.areas)
    path = scene.poses[[0, 12, 24]]
    panels = [SearchPanel(f"ball{k}", [path] * (k + 1), goals[:, k]) for k in range(3)]
    figure = trajectory_panels(scene, panels, "toy")
    assert [axes.get_title() for axes in figure.axes] == ["ball0", "ball1", "ball2"]
    assert figure.get_suptitle() == "toy"
    for k, axes in enumerate(figure.axes):
        goal_arrows, *ends = [item for item in axes.collections if isinstance(item, Quiver)]
        assert len(goal_arrows.XY) == goals[:, k].sum()
        np.testing.assert_allclose(goal_arrows.XY, scene.poses[goals[:, k], :2], atol=1e-6)
        assert len(ends) == len(paths_of(axes)) == k + 1


def test_the_same_search_drawn_several_times_can_be_told_apart(scene):
    same = [scene.poses[[0, 12, 24]]] * 6
    drawn = paths_of(trajectory_panels(scene, [SearchPanel("", same)]).axes[0])
    starts = np.array([path.get_segments()[0][0] for path in drawn])
    step = np.diff(starts, axis=0)
    assert (np.abs(step) > 0.02).all()  # both along x and along z, so on any edge of the lattice
    assert np.abs(starts - starts.mean(0)).max() < 0.2  # but still at its place
    middle = np.array([path.get_cmap()(0.5)[:3] for path in drawn])
    distance = np.linalg.norm(middle[:, None] - middle, axis=-1) + 9 * np.eye(len(middle))
    assert distance.min() > 0.2


def test_one_search_is_not_moved(scene):
    poses = scene.poses[[0, 12, 24]]
    assert not poses[:, 2].any()  # they look along z, where a path is drawn a little ahead
    (path,) = paths_of(trajectory_figure(scene, [poses]).axes[0])
    np.testing.assert_allclose(path.get_segments()[0][:, 0], poses[:2, 0], atol=1e-6)


@pytest.mark.parametrize(("count", "rows"), [(1, 1), (4, 1), (5, 2)])
def test_at_most_four_panels_stand_in_a_row(scene, count, rows):
    figure = trajectory_panels(scene, [SearchPanel(str(k), []) for k in range(count)])
    assert figure_png(figure).startswith(b"\x89PNG")
    assert len(figure.axes) == count
    assert len({round(axes.get_position().y0, 3) for axes in figure.axes}) == rows


def test_searches_that_do_not_fit_the_scene_are_refused(scene):
    with pytest.raises(ValueError, match="at least one panel"):
        trajectory_panels(scene, [])
    with pytest.raises(ValueError, match="goals are one bool for each of 192 states"):
        trajectory_panels(scene, [SearchPanel("", [], np.ones(5, bool))])
    for path in (np.zeros((0, 4)), np.zeros((3, 2)), np.zeros(4)):
        with pytest.raises(ValueError, match="a path is"):
            trajectory_panels(scene, [SearchPanel("", [path])])


def test_large_obstacles_are_named_without_their_number(scene):
    def box(x, width, depth):
        return np.array([[x, 0], [x + width, 0], [x + width, depth], [x, depth]], float)

    obstacles = (("office_chair_2", box(0, 1, 0.5)), ("shelf", box(1, 0.5, 1)), ("bin", box(1.6, 0.2, 0.2)))
    furnished = dataclasses.replace(scene, floor_plan=FloorPlan(scene.floor_plan.outline, obstacles))
    axes = trajectory_figure(furnished, []).axes[0]
    assert [(text.get_text(), text.get_rotation()) for text in axes.texts] == [("office chair", 0), ("shelf", 90)]
    axes.clear()
    draw_floor(axes, furnished, details=False)
    assert not axes.texts
    assert not axes.collections


def test_a_contact_sheet_shows_views_and_targets(scene):
    sheet = contact_sheet(scene)
    assert sheet.dtype == np.uint8
    assert sheet.shape[0] > 1000
    assert np.unique(sheet.reshape(-1, 3), axis=0).shape[0] > 1000
    np.testing.assert_array_equal(sheet, contact_sheet(scene))


def test_colours_survive_png(tmp_path):
    path = tmp_path / "x.png"
    Image.fromarray(draw_detection(np.zeros((8, 8, 3), np.uint8), None, "", 8)).save(path)
    assert np.asarray(Image.open(path)).max() == 0
