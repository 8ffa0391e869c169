"""What `scenes check` finds, each in a scene that has just that."""

import dataclasses

import numpy as np
import pytest

from active_perceiver.cli.main import main
from active_perceiver.envs.task import SearchTask
from active_perceiver.scenes import save_scene
from active_perceiver.scenes.checking import scene_issues
from active_perceiver.scenes.images import encode_image
from active_perceiver.scenes.lattice import MOVE_DIRECTION


def texts(scene, fatal=None):
    return [problem.text for problem in scene_issues(scene) if fatal is None or problem.fatal == fatal]


def test_a_sound_scene_has_no_problems(scene):
    assert texts(scene) == []


def test_blocked_everywhere_is_fatal(scene):
    still = np.tile(np.arange(len(scene), dtype=np.int32)[:, None], (1, 8))
    assert any(
        "every action is blocked" in text for text in texts(dataclasses.replace(scene, transitions=still), True)
    )


def test_islands_and_unreachable_goals_are_named(scene):
    transitions = scene.transitions.copy()
    transitions[:24] = np.arange(24)[:, None]
    found = texts(dataclasses.replace(scene, transitions=transitions))
    assert any("24 states have no way out" in text for text in found)
    assert any("islands" in text for text in found)
    assert any("no search starts there" in text for text in found)


def test_many_islands_are_a_finding_with_a_remedy_but_can_be_searched(scene, tmp_path, capsys):
    """Turning and looking is all there is: each place is an island, and those with a goal can still be searched."""
    transitions = scene.transitions.copy()
    moves = [column for column, action in enumerate(scene.actions) if action in MOVE_DIRECTION]
    transitions[:, moves] = np.arange(len(scene))[:, None]
    divided = dataclasses.replace(scene, transitions=transitions)
    (islands,) = (problem for problem in scene_issues(divided) if "islands" in problem.text)
    assert not islands.fatal
    assert islands.text.startswith("the states fall into 16 islands of 12, 12, 12, 12, 12 ... states")
    assert "moves.csv" in islands.text
    save_scene(divided, tmp_path / "divided.h5")
    assert main(["scenes", "check", str(tmp_path / "divided.h5")]) == 0
    assert "note  the states fall into 16 islands" in capsys.readouterr().out
    search = SearchTask.from_scene(divided)  # it refuses what cannot be searched
    starts = [len(search.starts(target)) for target in range(len(search.targets))]
    assert 0 < max(starts) <= 5 * 11


def test_goals_that_nothing_leads_to_are_fatal(scene):
    goal = int(scene.areas[:, 0].argmax())
    boxes = scene.boxes.copy()
    boxes[np.arange(len(scene)) != goal, 0] = np.nan
    transitions = scene.transitions.copy()
    transitions[(transitions == goal).any(1)] = np.flatnonzero((transitions == goal).any(1))[:, None]
    lone = dataclasses.replace(scene, boxes=boxes, transitions=transitions)
    assert any("no goal state of 'ball0'" in text for text in texts(lone, True))


def test_an_action_that_never_works_is_named(scene):
    transitions = scene.transitions.copy()
    transitions[:, 2] = np.arange(len(scene))
    assert any("MoveLeft is blocked" in text for text in texts(dataclasses.replace(scene, transitions=transitions)))


@pytest.mark.parametrize(("targets", "fatal"), [((1,), False), ((0, 1, 2), True)])
def test_targets_never_visible_are_fatal_only_if_none_is_left(scene, targets, fatal):
    boxes = scene.boxes.copy()
    boxes[:, targets] = np.nan
    blind = dataclasses.replace(scene, boxes=boxes)
    assert sum("never visible" in text for text in texts(blind, fatal)) == len(targets)


def test_tiny_targets_are_named(scene):
    boxes = scene.boxes.copy()
    boxes[:, 1, 2:] = np.where(np.isnan(boxes[:, 1, 2:]), np.nan, 0.01)
    assert any("'ball1' is at most 0 pixels" in text for text in texts(dataclasses.replace(scene, boxes=boxes)))


def test_copied_broken_and_odd_views_are_counted(scene):
    views = list(scene.views)
    views[5] = views[6] = views[7]
    views[9] = b"broken"
    views[10] = encode_image(np.zeros((10, 20, 3), np.uint8), "png")
    found = scene_issues(dataclasses.replace(scene, views=tuple(views)))
    assert any("2 views are exact copies" in problem.text and not problem.fatal for problem in found)
    assert any("1 views cannot be decoded" in problem.text and problem.fatal for problem in found)
    assert any("1 views are not 48 x 48" in problem.text for problem in found)
    assert found[0].fatal


def test_broken_target_pictures_are_fatal(scene):
    broken = dataclasses.replace(scene.targets[0], pictures=(b"broken",), held_out=0)
    found = texts(dataclasses.replace(scene, targets=(broken, *scene.targets[1:])), True)
    assert any("picture 0 of target 'ball0'" in text for text in found)


def test_held_out_copies_of_trained_pictures_are_named(scene):
    pictures = scene.targets[2].pictures
    leaky = dataclasses.replace(scene.targets[2], pictures=(*pictures, pictures[0]), held_out=1)
    found = texts(dataclasses.replace(scene, targets=(*scene.targets[:2], leaky)), False)
    assert any("1 pictures of 'ball2' that are held out are exact copies" in text for text in found)
