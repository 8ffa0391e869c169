"""From a room to a scene: free positions, boxes, studio pictures, parallel work, the file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from active_perceiver.capture.rendered import capture_scene as capture_module
from active_perceiver.capture.rendered.capture_scene import boxes_from_mask, capture
from active_perceiver.capture.rendered.config import DEFAULT_CONFIGS, CaptureConfig, CaptureError
from active_perceiver.parallel.process_pool import ProcessExecutor
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Scene
from active_perceiver.scenes.lattice import islands, lattice_poses, lattice_transitions
from box_room import DEPTH, TABLE, WIDTH, box_room
from indoor_rooms.free_space import free_positions, without_collisions
from indoor_rooms.renderer.camera import render
from indoor_rooms.renderer.lighting import bake
from indoor_rooms.studio.studio_pictures import TargetError, studio_pictures

SMALL = CaptureConfig(spacing=1.5, image_size=48, bake_rays=8, bounces=1, tilts=(-30.0, 0.0))


def outline_points(polygon: np.ndarray, count: int = 200) -> np.ndarray:
    share = np.linspace(0, 1, count)[:, None, None]
    return (polygon + share * (np.roll(polygon, -1, axis=0) - polygon)).reshape(-1, 2)


def test_free_positions_keep_their_distance() -> None:
    positions = free_positions(box_room(), spacing=0.3, radius=0.25)
    outline = outline_points(TABLE)
    assert np.linalg.norm(positions[:, None] - outline[None], axis=-1).min() >= 0.25 - 1e-6
    assert positions.min() >= 0.25 - 1e-6
    assert (positions <= np.array([WIDTH, DEPTH]) - 0.25 + 1e-6).all()
    poses = np.hstack([positions, np.zeros((len(positions), 2))])
    assert islands(lattice_transitions(poses, EIGHT_ACTIONS, 0.3)).max() == 0
    # Nothing free was forgotten: the lattice fills the rest of the room.
    assert len(positions) * 0.3**2 > 0.7 * ((WIDTH - 0.5) * (DEPTH - 0.5) - 1.1**2)


def test_thin_obstacles_between_positions_block_the_move() -> None:
    poses = lattice_poses(np.array([[0.5, 0.5], [1.0, 0.5]]), (0.0, 90.0, 180.0, 270.0), (0.0,))
    transitions = lattice_transitions(poses, EIGHT_ACTIONS, 0.5)
    leg = np.array([[0.74, 0.49], [0.76, 0.49], [0.76, 0.51], [0.74, 0.51]])
    blocked = without_collisions(poses, transitions, [leg], 0.2)
    moved = (poses[transitions, :2] != poses[:, None, :2]).any(-1)
    assert moved.sum() == 8
    assert not (poses[blocked, :2] != poses[:, None, :2]).any()
    np.testing.assert_array_equal(without_collisions(poses, transitions, [leg + 5], 0.2), transitions)


@pytest.mark.parametrize("places", [1, 7, 27])
def test_a_number_of_places_around_the_middle_is_kept(places: int) -> None:
    everywhere = free_positions(box_room(), 0.3, 0.2)
    positions = free_positions(box_room(), 0.3, 0.2, places)
    assert len(positions) == places
    assert {tuple(place) for place in positions} <= {tuple(place) for place in everywhere}
    poses = np.hstack([positions, np.zeros((places, 2))])
    assert islands(lattice_transitions(poses, EIGHT_ACTIONS, 0.3)).max() == 0
    distance = np.linalg.norm(everywhere - everywhere.mean(axis=0), axis=1)
    nearest = everywhere[distance.argmin()]
    assert (positions == nearest).all(axis=1).any()
    # A compact patch: hardly wider than a disc of as many places.
    assert np.linalg.norm(positions - nearest, axis=1).max() < 0.3 * (1.2 * np.sqrt(places / np.pi) + 2)


def test_places_do_not_reach_through_a_fence() -> None:
    fence = np.array([[2.0, 0.0], [2.02, 0.0], [2.02, 2.3], [2.0, 2.3]])
    room = replace(box_room(), obstacles=(("fence", fence),))
    positions = free_positions(room, 0.3, 0.05, 20)
    poses = np.hstack([positions, np.zeros((20, 2))])
    moves = without_collisions(poses, lattice_transitions(poses, EIGHT_ACTIONS, 0.3), [fence], 0.05)
    assert islands(moves).max() == 0


@pytest.mark.parametrize(
    "wrong",
    [
        {"spacing": float("nan")}, {"spacing": 0.0}, {"places": 0}, {"tilts": ()}, {"tilts": (0.0, -30.0)},
        {"tilts": (-30.0, 0.0, 10.0)}, {"tilts": (float("nan"),)}, {"image_size": 0}, {"fov": 180.0}, {"samples": 3},
        {"bake_rays": 0}, {"bounces": -1}, {"webp_quality": 101}, {"actions": ()}, {"robot_radius": -1.0},
        {"actions": (EIGHT_ACTIONS[0],) * 2}, {"camera_height": float("inf")},
    ],
)  # fmt: skip
def test_wrong_settings_are_named(wrong: dict[str, Any]) -> None:
    with pytest.raises(CaptureError, match=f"^{next(iter(wrong))} must "):
        CaptureConfig(**wrong)


def test_a_turtlebot_drives_through_the_conference_room() -> None:
    settings = DEFAULT_CONFIGS["conference_room"]
    assert settings.actions == TURTLEBOT_ACTIONS
    assert settings.places is not None
    assert settings.places * 4 * len(settings.tilts) == 216
    assert settings.faults is not None


def test_boxes_bound_the_masks() -> None:
    mask = np.full((100, 200), -1, np.int32)
    mask[10:30, 50:150] = 3
    mask[0, :9] = 4  # nine pixels, fewer than 0.05 %
    mask[99, 190:] = 5
    boxes = boxes_from_mask(mask, [3, 4, 5, 6])
    np.testing.assert_allclose(boxes[0], [0.5, 0.2, 0.5, 0.2])
    assert np.isnan(boxes[[1, 3]]).all()
    np.testing.assert_allclose(boxes[2], [0.975, 0.995, 0.05, 0.01], atol=1e-6)


@pytest.fixture(scope="module")
def scenes() -> tuple[Scene, Scene]:
    """The same room by one worker and by two."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(capture_module, "SETUPS", 1)
        patch.setattr(capture_module, "HELD_OUT", 1)
        one, two = (capture(box_room(), SMALL, seed=5, executor=ProcessExecutor(workers)) for workers in (1, 2))
    return one, two


@pytest.mark.xdist_group("captured")
def test_scene_is_the_same_for_any_number_of_workers(scenes: tuple[Scene, Scene]) -> None:
    one, two = scenes
    assert one.views == two.views
    assert one.targets == two.targets
    np.testing.assert_array_equal(one.boxes, two.boxes)


@pytest.mark.xdist_group("captured")
def test_scene_shows_the_room(scenes: tuple[Scene, Scene]) -> None:
    scene = scenes[0]
    assert len(scene) % 8 == 0
    assert scene.actions == EIGHT_ACTIONS
    assert (scene.transitions != np.arange(len(scene))[:, None]).any(axis=0).all()
    assert scene.floor_plan is not None
    baked = bake(box_room(), SMALL.bake_rays, SMALL.bounces, seed=5)
    state = int(np.nanargmax(scene.areas[:, 0]))
    x, y, heading, tilt = scene.poses[state].tolist()
    view = render(baked, (x, y, SMALL.camera_height), heading, tilt, 48)
    np.testing.assert_array_equal(scene.boxes[state], boxes_from_mask(view.mask, [baked.object_names.index("box")]))
    # WebP is lossy, but it is the same picture.
    assert np.abs(scene.view(state).astype(int) - view.image).mean() < 6
    assert scene.targets[0].category == "carton"
    assert scene.targets[0].held_out == 1
    assert scene.targets[0].picture().shape == (48, 48, 3)


def test_studio_picture_shows_the_object_large_on_a_light_background() -> None:
    pictures = studio_pictures(box_room(), "box", setup=0, seed=1, image_size=64)
    for picture in pictures:
        red = picture[..., 0].astype(int) - picture[..., 1] > 40
        rows, columns = np.nonzero(red)
        extent = max(np.ptp(rows), np.ptp(columns)) + 1
        assert 0.5 < extent / 64 < 0.75
        assert picture[0].mean() > 120
        assert np.ptp(picture[0].mean(axis=0)) < 40
    assert (pictures[0] != pictures[1]).any()


def test_unknown_targets_are_named() -> None:
    with pytest.raises(TargetError, match="'teapot'"):
        studio_pictures(box_room(), "teapot", 0, 0)
    with pytest.raises(TargetError, match="'teapot'"):
        capture(replace(box_room(), targets={"teapot": "pot"}), SMALL)
    with pytest.raises(TargetError, match="no targets"):
        capture(replace(box_room(), targets={}), SMALL)
