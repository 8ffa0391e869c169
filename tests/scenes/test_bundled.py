"""The shipped scenes are sound, complete, small, and what the code makes."""

import numpy as np
import pytest

from active_perceiver.capture.rendered.config import DEFAULT_CONFIGS, CaptureConfig
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, bundled_names, open_scene
from active_perceiver.scenes.bundled import TARGETS_OF_RECORD, scene_path
from active_perceiver.scenes.checking import scene_issues
from active_perceiver.scenes.lattice import goal_states, islands, steps_to_goal
from indoor_rooms.free_space import free_positions
from made_rooms import made_room, together

# Of which room each scene was made.
ROOMS = {
    "kitchen_1": ("kitchen", 1),
    "kitchen_2": ("kitchen", 2),
    "living_room_1": ("living_room", 1),
    "living_room_2": ("living_room", 2),
    "conference_room": ("conference_room", 4),
}


@pytest.fixture(scope="module", params=[pytest.param(name, marks=together(room[0])) for name, room in ROOMS.items()])
def bundled(request):
    return open_scene(request.param)


def test_there_are_five_and_together_they_are_under_30_megabytes():
    assert set(bundled_names()) == set(ROOMS)
    assert sum(scene_path(name).stat().st_size for name in bundled_names()) < 30e6


def test_it_is_sound_and_bears_its_file_s_name(bundled):
    assert not any(problem.fatal for problem in scene_issues(bundled))
    assert bundled.name in bundled_names()


def test_every_target_of_record_is_large_enough_somewhere(bundled):
    for name in TARGETS_OF_RECORD[bundled.name]:
        assert bundled.areas[:, bundled.target_index(name)].max() > 0.003


def test_every_target_can_be_reached_from_everywhere(bundled):
    assert islands(bundled.transitions).max() == 0
    goals = goal_states(bundled.areas)
    for target in np.flatnonzero(goals.any(axis=0)):
        assert (steps_to_goal(bundled.transitions, goals[:, target]) >= 0).all()


def test_it_is_as_promised(bundled):
    robot = bundled.name == "conference_room"
    assert bundled.actions == (TURTLEBOT_ACTIONS if robot else EIGHT_ACTIONS)
    assert (bundled.image_size, bundled.fov) == (300, 70.0 if robot else 75.0)
    places = len(np.unique(bundled.positions))
    assert places == 27 if robot else places >= 50
    assert np.unique(bundled.poses[:, 2]).tolist() == [0, 90, 180, 270]
    assert np.unique(bundled.poses[:, 3]).tolist() == ([-25, 0] if robot else [-30, 0, 30])
    assert len(bundled) == places * (8 if robot else 12)
    assert len(bundled.targets) >= 20


def test_target_pictures_are_split_and_all_different(bundled):
    for target in bundled.targets:
        assert (len(target.pictures), target.held_out) == (12, 4)
        pictures = [target.picture(index) for index in range(12)]
        assert all(picture.shape == (300, 300, 3) for picture in pictures)
        assert len({picture.tobytes() for picture in pictures}) == 12


def test_its_places_and_targets_are_those_of_the_room_it_was_rendered_from(bundled):
    layout, seed = ROOMS[bundled.name]
    room, settings = made_room(layout, seed), DEFAULT_CONFIGS.get(layout, CaptureConfig())
    assert tuple(room.targets) == bundled.target_names
    places = np.unique(bundled.poses[:, :2], axis=0)
    expected = free_positions(room, settings.spacing, settings.robot_radius, settings.places)
    np.testing.assert_allclose(places, np.unique(expected, axis=0), atol=1e-5)
    np.testing.assert_allclose(bundled.floor_plan.outline.max(axis=0), room.size[:2])
