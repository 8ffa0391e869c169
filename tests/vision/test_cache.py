from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from active_perceiver.errors import UserError
from active_perceiver.scenes import Scene
from active_perceiver.vision import pooled, scene_features
from active_perceiver.vision.cache import SceneFeatures
from helpers.toy import toy_scene


@pytest.fixture
def tiny() -> Scene:
    return toy_scene(side=1, targets=2)


@pytest.fixture
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("ACTIVE_PERCEIVER_CACHE", str(tmp_path))
    return tmp_path


def never(*_):
    pytest.fail("features were computed again")


def test_content(tiny, backbone, own_cache):
    features = scene_features(tiny, backbone)
    expected = backbone.maps([tiny.view(5)])
    np.testing.assert_allclose(features.view_maps[5], expected[0], atol=1e-2)
    np.testing.assert_allclose(features.view_features[5], pooled(expected)[0], atol=1e-3)
    picture = backbone.maps([tiny.targets[1].picture(3)])
    np.testing.assert_allclose(features.target_maps[1, 3], picture[0], atol=1e-2)
    assert features.target_features.shape == (2, 4, 672)
    assert (features.view_maps.dtype, features.view_features.dtype) == (np.float16, np.float32)
    assert isinstance(features.view_maps, np.memmap)
    assert not features.view_maps.flags.writeable
    assert features.backbone == backbone.fingerprint


def test_second_time_from_the_cache(tiny, backbone, own_cache, monkeypatch):
    calls = []
    first = scene_features(tiny, backbone, lambda done, total: calls.append((done, total)))
    assert calls[-1] == (12 + 8, 12 + 8)
    assert calls == sorted(calls)
    monkeypatch.setattr(type(backbone), "maps", never)
    assert same(scene_features(tiny, backbone, never), first)


def test_another_scene_and_changed_pictures_are_other_entries(tiny, backbone, own_cache):
    first = scene_features(tiny, backbone)
    swapped = replace(tiny, targets=(replace(tiny.targets[0], pictures=tiny.targets[1].pictures), tiny.targets[1]))
    other = scene_features(swapped, backbone)
    np.testing.assert_array_equal(other.view_maps, first.view_maps)
    np.testing.assert_array_equal(other.target_maps[0], first.target_maps[1])


@pytest.mark.parametrize("damage", ["cut", "empty", "rubbish", "pickle", "shape"])
@pytest.mark.parametrize("part", ["maps", "averages"])
def test_damaged_files_are_made_again(tiny, backbone, own_cache, damage, part):
    first = scene_features(tiny, backbone)
    for path in list(own_cache.rglob(f"*-{part}-*.npy")):
        content = path.read_bytes()
        path.unlink()  # `first` is mapped onto the old file
        if damage == "pickle":
            np.save(path, np.array([{}], object), allow_pickle=True)
        elif damage == "shape":
            np.save(path, np.zeros((3, 2), np.float32))
        else:
            path.write_bytes({"cut": content[:-1], "empty": b"", "rubbish": b"no array" * 9}[damage])
    assert same(scene_features(tiny, backbone), first)


def test_an_interrupted_computation_leaves_nothing(tiny, backbone, own_cache):
    def interrupt(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        scene_features(tiny, backbone, interrupt)
    assert not [path for path in own_cache.rglob("*") if path.is_file()]


def test_targets_with_fewer_pictures_repeat_them(tiny, backbone, own_cache):
    uneven = replace(tiny, targets=(replace(tiny.targets[0], pictures=tiny.targets[0].pictures[:3]), tiny.targets[1]))
    features = scene_features(uneven, backbone)
    assert features.picture_counts.tolist() == [3, 4]
    np.testing.assert_array_equal(features.target_maps[0, 3], features.target_maps[0, 0])
    np.testing.assert_array_equal(features.target_maps, scene_features(uneven, backbone).target_maps)


def test_a_cache_that_cannot_be_written(tiny, backbone, own_cache):
    (own_cache / "features").write_text("a file where a folder should be")
    with pytest.raises(UserError, match="ACTIVE_PERCEIVER_CACHE"):
        scene_features(tiny, backbone)


def same(one: SceneFeatures, other: SceneFeatures) -> bool:
    names = ("view_maps", "view_features", "target_maps", "target_features")
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in names)
