"""Scene, Target and what they refuse."""

import dataclasses

import numpy as np
import pytest

from active_perceiver.scenes import Scene, SceneError, Target
from helpers.toy import toy_scene


def changed(scene: Scene, field: str, where, value) -> dict:
    array = getattr(scene, field).copy()
    array[where] = value
    return {field: array}


def seen_state(scene: Scene) -> int:
    return int(np.flatnonzero(scene.areas[:, 0])[0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s: changed(s, "poses", (3, 1), np.nan), "1 poses are not finite"),
        (lambda s: changed(s, "transitions", (0, 0), len(s)), "lead outside"),
        (lambda s: changed(s, "transitions", (0, 0), -1), "lead outside"),
        (lambda s: changed(s, "boxes", (seen_state(s), 0, 2), np.nan), "either all NaN"),
        (lambda s: changed(s, "boxes", (seen_state(s), 0), [150, 150, 40, 40]), "must lie in 0..1"),
        (lambda s: changed(s, "boxes", (seen_state(s), 0), [0.5, 0.5, 0.0, 0.1]), "positive size"),
        (lambda s: changed(s, "boxes", (seen_state(s), 0), [0.05, 0.5, 0.2, 0.1]), "must lie in 0..1"),
        (lambda s: {"boxes": s.boxes[:, :2]}, "boxes has shape"),
        (lambda s: {"poses": s.poses[:-1]}, "poses has shape"),
        (lambda s: {"transitions": s.transitions[:, :6]}, "transitions has shape"),
        (lambda s: {"targets": ()}, "boxes has shape"),
        (lambda s: {"views": ()}, "no views"),
        (lambda s: {"targets": (s.targets[0],) * 3}, "names a target twice"),
    ],
)
def test_unsound_scenes_are_refused(scene, change, message):
    with pytest.raises(SceneError, match=message):
        dataclasses.replace(scene, **change(scene))


@pytest.mark.parametrize(
    ("name", "pictures", "held_out"),
    [
        ("", (b"x",), 0), ("a/b", (b"x",), 0), ("mug", (), 0), ("mug", (b"x", b"y"), 2), ("mug", (b"x", b"y"), -1),
    ],
)  # fmt: skip
def test_unsound_targets_are_refused(name, pictures, held_out):
    with pytest.raises(SceneError):
        Target(name, pictures, held_out=held_out)


def test_the_last_pictures_are_held_out():
    assert Target("mug", (b"x", b"y", b"z"), held_out=2).trained == 1
    assert Target("mug", (b"x",)).trained == 1


def test_areas_are_width_times_height_and_zero_where_unseen(scene):
    unseen = np.isnan(scene.boxes[..., 0])
    assert (scene.areas[unseen] == 0).all()
    np.testing.assert_allclose(scene.areas[~unseen], scene.boxes[~unseen][:, 2:].prod(1))


def test_positions_number_the_places(scene):
    assert len(np.unique(scene.positions)) == 16
    for place in range(16):
        assert len(np.unique(scene.poses[scene.positions == place, :2], axis=0)) == 1


def test_views_decode_and_content_hash_follows_them(scene):
    assert scene.view(0).shape == (48, 48, 3)
    assert scene.content_hash == toy_scene().content_hash
    assert scene.content_hash != toy_scene(seed=1).content_hash


def test_target_index_names_the_known_ones(scene):
    assert scene.target_index("ball1") == 1
    with pytest.raises(SceneError, match="ball0, ball1, ball2"):
        scene.target_index("mug")
