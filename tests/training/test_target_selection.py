"""Which targets are searched for where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from active_perceiver.errors import UserError
from active_perceiver.scenes import bundled_names, open_scene
from active_perceiver.scenes.bundled import TARGETS_OF_RECORD
from active_perceiver.training.target_selection import check_recogniser_scenes, check_targets, searched_targets
from helpers.toy import toy_scene


def test_names_choose_targets() -> None:
    scene = replace(toy_scene(), name="kitchen_1")
    first, second, *_ = scene.target_names
    assert set(searched_targets(scene, ())) <= set(scene.target_names)
    assert searched_targets(scene, [second, first]) == (second, first)
    assert searched_targets(scene, [f"kitchen_1/{first}", f"kitchen_2/{second}"]) == (first,)
    assert searched_targets(scene, [first, f"kitchen_1/{first}"]) == (first,)
    assert searched_targets(scene, ["record"]) == TARGETS_OF_RECORD["kitchen_1"]
    assert searched_targets(replace(scene, name="mine"), ["record"]) == ()


def test_bundled_scenes_have_their_targets_of_record() -> None:
    assert set(TARGETS_OF_RECORD) == set(bundled_names())
    rooms = [name for name in TARGETS_OF_RECORD if name != "conference_room"]
    assert len({target for name in rooms for target in TARGETS_OF_RECORD[name]}) == 16
    for name, targets in TARGETS_OF_RECORD.items():
        assert set(targets) <= set(open_scene(name).target_names)


def test_what_no_scene_has_is_explained() -> None:
    scene = toy_scene()
    check_targets([scene], ())
    check_targets([scene], scene.target_names)
    with pytest.raises(UserError, match="no scene has the target unicorn; there are"):
        check_targets([scene], ["unicorn"])
    with pytest.raises(UserError, match="only bundled scenes have targets of record"):
        check_targets([replace(scene, name="mine")], ["record"])
    other = replace(scene, name="other")
    with pytest.raises(UserError, match="scene 'other' has none of the targets"):
        check_targets([scene, other], [f"{scene.name}/{scene.target_names[0]}"])


def test_what_the_recogniser_does_not_know_is_told() -> None:
    scene = toy_scene()
    first, *others = scene.target_names
    assert check_recogniser_scenes([scene], [toy_scene(1)], ()) == []
    hidden = scene.boxes.copy()
    hidden[:, 0] = np.nan
    # To be listed is not enough: it must be in a photograph.
    (note,) = check_recogniser_scenes([scene], [replace(scene, boxes=hidden)], ())
    assert note.startswith(f"the recogniser is not trained on {first}, which {scene.name} is searched for")
    assert check_recogniser_scenes([scene], [replace(scene, boxes=hidden)], others) == []


def test_pictures_held_out_are_not_trained_with_elsewhere() -> None:
    scene = toy_scene()
    swapped = tuple(replace(target, pictures=target.pictures[::-1]) for target in scene.targets)
    with pytest.raises(UserError, match=f"pictures of '{scene.target_names[0]}' that scene '{scene.name}' holds out"):
        check_recogniser_scenes([scene], [replace(scene, targets=swapped)], ())
