"""What is known of each view's boxes: kept in the file, refused if it contradicts them, told by `scenes check`."""

import dataclasses

import h5py
import numpy as np
import pytest

from active_perceiver.scenes import SceneError, load_scene, save_scene
from active_perceiver.scenes.checking import scene_issues
from active_perceiver.scenes.scene import LABELLED, PROPOSED, UNLABELLED


@pytest.fixture
def half(scene):
    """The first ten views are not labelled, the next twenty have proposals."""
    labels = np.full(len(scene), LABELLED, np.uint8)
    labels[:10], labels[10:30] = UNLABELLED, PROPOSED
    boxes = scene.boxes.copy()
    boxes[:10] = np.nan
    return dataclasses.replace(scene, labels=labels, boxes=boxes)


def test_they_survive_the_file_and_their_absence_too(scene, half, tmp_path):
    for number, one in enumerate((scene, half)):
        save_scene(one, tmp_path / f"{number}.h5")
    assert load_scene(tmp_path / "0.h5").labels is None
    np.testing.assert_array_equal(load_scene(tmp_path / "1.h5").labels, half.labels)


def test_check_counts_them(half):
    texts = [problem.text for problem in scene_issues(half)]
    assert any(text.startswith("10 views are not labelled") for text in texts)
    assert any(text.startswith("the boxes of 20 views were proposed") for text in texts)


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        (lambda s: np.full(len(s), 3, np.uint8), "labels must be"),
        (lambda s: np.full(len(s) - 1, LABELLED, np.uint8), "labels must be"),
        (lambda s: np.full(len(s), UNLABELLED, np.uint8), "said to be unlabelled"),
    ],
)
def test_what_contradicts_the_scene_is_refused(scene, labels, message):
    with pytest.raises(SceneError, match=message):
        dataclasses.replace(scene, labels=labels(scene))


def test_a_file_with_senseless_labels_is_refused(half, tmp_path):
    path = tmp_path / "scene.h5"
    save_scene(half, path)
    with h5py.File(path, "r+") as file:
        del file["labels"]
        file["labels"] = np.full(len(half), np.nan)
    with pytest.raises(SceneError, match="labels"):
        load_scene(path)
