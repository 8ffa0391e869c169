"""Figures: what is drawn is where it should be."""

import dataclasses

import numpy as np
import pytest
from PIL import Image

from active_perceiver.figures import page
from active_perceiver.figures.annotate import draw_detection
from active_perceiver.figures.contact_sheet import contact_sheet
from active_perceiver.figures.floor import figure_image, figure_png, trajectory_figure
from active_perceiver.recognition.recogniser import Detection
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


def test_a_contact_sheet_shows_views_and_targets(scene):
    sheet = contact_sheet(scene)
    assert sheet.dtype == np.uint8
    assert sheet.shape[0] > 1000
    assert np.unique(sheet.reshape(-1, 3), axis=0).shape[0] > 1000
    np.testing.assert_array_equal(sheet, contact_sheet(scene))


def test_a_page_is_self_contained_and_escapes_text(tmp_path):
    path = tmp_path / "report.html"
    figure = page.picture(b"\x89PNG", ".png", 'a "mug" & more')
    page.write_page(path, "<Search>", "lead", [page.row([figure]), page.table(["a", "b"], [["<x>", 1]])])
    text = path.read_text()
    assert "<title>&lt;Search&gt;</title>" in text
    assert "&lt;x&gt;" in text
    assert "<x>" not in text
    assert 'src="data:image/png;base64,' in text
    assert 'src="http' not in text


def test_colours_survive_png(tmp_path):
    path = tmp_path / "x.png"
    Image.fromarray(draw_detection(np.zeros((8, 8, 3), np.uint8), None, "", 8)).save(path)
    assert np.asarray(Image.open(path)).max() == 0
