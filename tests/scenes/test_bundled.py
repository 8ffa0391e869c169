"""The shipped scenes are sound, complete, small, and what the code makes."""

import numpy as np
import pytest

from active_perceiver.rooms import make_room
from active_perceiver.rooms.free_space import free_positions
from active_perceiver.scenes import EIGHT_ACTIONS, bundled_names, open_scene
from active_perceiver.scenes.bundled import scene_path
from active_perceiver.scenes.checking import scene_problems
from active_perceiver.scenes.lattice import goal_states, islands, steps_to_goal


@pytest.fixture(scope="module", params=bundled_names())
def bundled(request):
    return open_scene(request.param)


def test_together_they_are_under_30_megabytes():
    assert sum(scene_path(name).stat().st_size for name in bundled_names()) < 30e6


def test_it_is_sound_and_bears_its_file_s_name(bundled):
    assert scene_problems(bundled) == []
    assert bundled.name in bundled_names()


def test_every_target_can_be_reached_from_everywhere(bundled):
    assert islands(bundled.transitions).max() == 0
    goals = goal_states(bundled.areas)
    for target in range(len(bundled.targets)):
        assert (steps_to_goal(bundled.transitions, goals[:, target]) >= 0).all()


def test_the_kitchen_is_as_promised():
    kitchen = open_scene("kitchen_1")
    assert kitchen.actions == EIGHT_ACTIONS
    assert (kitchen.image_size, kitchen.fov) == (300, 75.0)
    assert len(np.unique(kitchen.positions)) >= 50
    assert np.unique(kitchen.poses[:, 2]).tolist() == [0, 90, 180, 270]
    assert np.unique(kitchen.poses[:, 3]).tolist() == [-30, 0, 30]
    assert len(kitchen.targets) >= 12
    assert all(len(target.pictures) == 8 for target in kitchen.targets)
    assert {"mug", "plate", "bread", "apple"} <= set(kitchen.target_names)
    for target in kitchen.targets:
        pictures = [target.picture(index) for index in range(8)]
        assert all(picture.shape == (300, 300, 3) for picture in pictures)
        assert len({picture.tobytes() for picture in pictures}) == 8


def test_the_kitchen_s_places_and_targets_are_those_of_the_room_it_was_rendered_from():
    kitchen, room = open_scene("kitchen_1"), make_room("kitchen", 1)
    assert tuple(room.targets) == kitchen.target_names
    places = np.unique(kitchen.poses[:, :2], axis=0)
    np.testing.assert_allclose(places, np.unique(free_positions(room), axis=0), atol=1e-5)
    np.testing.assert_allclose(kitchen.floor_plan.outline.max(axis=0), room.size[:2])
