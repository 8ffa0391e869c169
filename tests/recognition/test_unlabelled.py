"""Views that nobody has labelled are not taken for views without the target."""

from dataclasses import replace

import numpy as np
import pytest

from active_perceiver.recognition.pairs import IGNORE_INDEX, Annotations, PairSampler, Split
from active_perceiver.recognition.recogniser import RecogniserError
from active_perceiver.scenes.scene import LABELLED, PROPOSED, UNLABELLED
from active_perceiver.vision import scene_features

torch = pytest.importorskip("torch")

from active_perceiver.recognition.augmentation import AugmentationConfig  # noqa: E402
from active_perceiver.recognition.train import RecogniserConfig, train_recogniser  # noqa: E402

SHORT = RecogniserConfig(steps=4, views=8, threads=1, augmentation=AugmentationConfig(views=48, pictures=0, crops=0))


def with_states(scene, states):
    boxes = scene.boxes.copy()
    boxes[states == UNLABELLED] = np.nan
    return replace(scene, labels=states.astype(np.uint8), boxes=boxes)


@pytest.fixture(scope="module")
def half(scene):
    """Whole places are unlabelled, and single views of the others."""
    states = np.where(scene.positions % 2 == 0, LABELLED, UNLABELLED)
    states[::7] = UNLABELLED
    states[1] = PROPOSED
    return with_states(scene, states)


def test_they_are_not_judged_and_the_others_are_as_ever(scene, half):
    ours, all_labelled = Annotations.of([half], 0.003), Annotations.of([scene], 0.003)
    unlabelled = half.labels == UNLABELLED
    assert (ours.states[unlabelled] == IGNORE_INDEX).all()
    np.testing.assert_array_equal(ours.states[~unlabelled], all_labelled.states[~unlabelled])


def test_places_are_held_out_where_something_can_be_judged(half):
    data = Annotations.of([half], 0.003)
    for seed in range(20):
        split = Split.of(data, 0.25, (), np.random.default_rng(seed))
        assert len(np.unique(half.positions[split.views])) == 2  # of the eight with labels
        assert (half.positions[split.views] % 2 == 0).all()


def test_no_batch_asks_about_them(half):
    data = Annotations.of([half], 0.003)
    split = Split.of(data, 0.25, (), np.random.default_rng(0))
    sampler = PairSampler(data, split, 0.5, np.random.default_rng(1))
    views = np.concatenate([sampler.draw(16, 3).views for _ in range(30)])
    assert (half.labels[views] != UNLABELLED).all()


def test_what_comes_out_does_not_depend_on_how_many_are_unlabelled_too(scene, half, backbone, monkeypatch):
    """Only labelled views are copied, and the metrics are of labelled views."""
    from active_perceiver.recognition import augmentation

    copied = []
    real = augmentation.changed_view
    monkeypatch.setattr(augmentation, "changed_view", lambda image, *rest: copied.append(image) or real(image, *rest))
    result = train_recogniser([half], [scene_features(half, backbone)], SHORT, backbone=backbone)
    labelled = {half.view(view).tobytes() for view in np.flatnonzero(half.labels != UNLABELLED)}
    assert copied
    assert all(image.tobytes() in labelled for image in copied)
    held_out = result.validation_views[0]
    judged = held_out & (half.labels != UNLABELLED)
    assert result.metrics["seen pictures"].pairs <= judged.sum() * 3 * 2


def test_without_any_label_there_is_nothing_to_learn_from(scene, backbone):
    bare = with_states(scene, np.full(len(scene), UNLABELLED))
    with pytest.raises(RecogniserError, match="no target is large enough"):
        train_recogniser([bare], [scene_features(bare, backbone)], SHORT, backbone=backbone)


def test_one_labelled_place_is_enough_to_begin(scene, backbone):
    visible = [place for place in range(16) if scene.areas[scene.positions == place].max() >= 0.003]
    states = np.where(scene.positions == visible[0], LABELLED, UNLABELLED)
    result = train_recogniser([with_states(scene, states)], [scene_features(scene, backbone)], SHORT)
    assert not result.validation_views[0].any()
