from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from active_perceiver.recognition.pairs import ABSENT, IGNORE_INDEX, PRESENT, Annotations, PairSampler, Split
from active_perceiver.vision import scene_features
from helpers.toy import toy_scene

torch = pytest.importorskip("torch")

from active_perceiver.recognition.augmentation import AugmentationConfig, make_augmented  # noqa: E402
from active_perceiver.recognition.network import RECOGNISERS  # noqa: E402
from active_perceiver.recognition.train import NO_AUGMENTATION, RecogniserConfig, train_recogniser  # noqa: E402

CONFIG = AugmentationConfig(views=400, pictures=1, crops=3)


def material(scenes, backbone, places=0.3, targets=()):
    data = Annotations.of(scenes, 0.003)
    split = Split.of(data, places, targets, np.random.default_rng(0))
    network = RECOGNISERS["matching"]((backbone.channels, backbone.map_size, backbone.map_size)).eval()
    return data, split, network


@pytest.fixture(scope="module")
def made(scene, backbone):
    data, split, network = material([scene], backbone)
    calls: list[tuple[int, int]] = []
    augmented = make_augmented(
        [scene],
        backbone,
        network,
        data,
        split,
        CONFIG,
        np.random.default_rng(1),
        lambda *call: calls.append(call[:2]),
    )
    return data, split, network, augmented, calls


def test_only_what_is_not_held_out_is_copied(made):
    _, split, _, augmented, calls = made
    copies = round(CONFIG.views / (~split.views).sum())
    assert copies > 1
    assert np.array_equal(np.bincount(augmented.originals, minlength=len(split.views)), copies * ~split.views)
    assert len(augmented.views) == len(augmented.originals) == len(augmented.boxes) == len(augmented.states)
    total = len(augmented.originals) + augmented.counts.sum()
    assert calls == [(number, total) for number in range(1, total + 1)]


def test_states_and_boxes_agree(made):
    data, _, _, augmented, _ = made
    original = data.states[augmented.originals]
    areas = augmented.boxes[..., 2:].prod(axis=-1)
    assert (augmented.states[original == ABSENT] == ABSENT).all()
    assert (areas[augmented.states == PRESENT] >= data.smallest_area).all()
    assert (augmented.states == PRESENT).any()
    assert np.isfinite(augmented.boxes).all()


def test_a_copy_is_what_the_backbone_makes_of_it(scene, backbone):
    """Against the obvious way: without batches, one copy after the other."""
    from active_perceiver.recognition.augmented_images import changed_view

    data, split, network = material([scene], backbone)
    config = AugmentationConfig(views=1, pictures=0, crops=0)
    augmented = make_augmented([scene], backbone, network, data, split, config, np.random.default_rng(5))
    rng = np.random.default_rng(5)
    for number, row in enumerate(augmented.originals[:5]):
        image, _, _ = changed_view(scene.view(int(row)), scene.boxes[row], backbone.image_size, rng)
        with torch.inference_mode():
            expected = network.prepare(torch.from_numpy(backbone.maps([image])))[0]
        assert torch.allclose(augmented.views[number].float(), expected, atol=0.02, rtol=0.02)
    assert augmented.pictures.shape[1] == 0
    assert not augmented.counts.any()


def test_nothing_is_made_of_held_out_targets(scene, backbone):
    data, split, network = material([scene], backbone, targets=("ball1",))
    augmented = make_augmented([scene], backbone, network, data, split, CONFIG, np.random.default_rng(1))
    assert (augmented.counts == 0).tolist() == [False, True, False]


def test_several_scenes_keep_their_targets_apart(scene, backbone):
    other = replace(toy_scene(side=2, seed=1), name="other")
    data, split, network = material([scene, other], backbone)
    augmented = make_augmented([scene, other], backbone, network, data, split, CONFIG, np.random.default_rng(1))
    together, its_split = augmented.added_to(data, split)
    assert len(together.boxes) == len(its_split.views) == len(data.boxes) + len(augmented.originals)
    assert not its_split.views[len(data.boxes) :].any()
    of_first = augmented.originals < len(scene)
    mine = np.array([name.startswith(f"{scene.name}/") for name in data.names])
    assert (augmented.states[np.ix_(of_first, ~mine)] == IGNORE_INDEX).all()
    assert (augmented.states[np.ix_(~of_first, mine)] == IGNORE_INDEX).all()


def test_the_sampler_asks_with_further_pictures_too(made):
    data, split, _, augmented, _ = made
    everything = augmented.added_to(data, split)
    sampler = PairSampler(*everything, 0.7, np.random.default_rng(0), augmented.counts, 0.5)
    batch = sampler.draw(200, 2)
    most = int(data.pictures.max())
    own = batch.pictures < most
    assert 0.4 < own.mean() < 0.6
    assert (batch.pictures[own] < split.seen_pictures[batch.targets][own]).all()
    assert (batch.pictures[~own] - most < augmented.counts[batch.targets][~own]).all()
    assert (batch.views >= len(data.boxes)).any()
    only_own = PairSampler(data, split, 0.7, np.random.default_rng(0)).draw(50, 2)
    assert (only_own.pictures < split.seen_pictures[only_own.targets]).all()


def test_training_uses_it(scene, backbone):
    """The same seed gives the same weights, and others than without it."""
    features = scene_features(scene, backbone)
    config = RecogniserConfig(steps=4, views=6, threads=1, augmentation=CONFIG)
    one, two = (
        train_recogniser([scene], [features], config, backbone=backbone).network.state_dict() for _ in range(2)
    )
    assert all(torch.equal(one[name], two[name]) for name in one)
    without = replace(config, augmentation=NO_AUGMENTATION)
    other = train_recogniser([scene], [features], without, backbone=backbone).network.state_dict()
    assert not all(torch.equal(one[name], other[name]) for name in one)
