from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from active_perceiver.recognition.pairs import ABSENT, PRESENT, UNJUDGED, Annotations, PairSampler, Split
from active_perceiver.vision import scene_features
from toy import toy_scene

torch = pytest.importorskip("torch")

from active_perceiver.recognition.further import FurtherConfig, make_further  # noqa: E402
from active_perceiver.recognition.network import RECOGNISERS  # noqa: E402
from active_perceiver.recognition.training import NO_FURTHER, RecogniserConfig, train_recogniser  # noqa: E402

CONFIG = FurtherConfig(views=400, pictures=1, cut_outs=3)


def material(scenes, backbone, places=0.3, targets=()):
    data = Annotations.of(scenes, 0.003)
    split = Split.of(data, places, targets, np.random.default_rng(0))
    network = RECOGNISERS["matching"]((backbone.channels, backbone.map_size, backbone.map_size)).eval()
    return data, split, network


@pytest.fixture(scope="module")
def made(scene, backbone):
    data, split, network = material([scene], backbone)
    calls: list[tuple[int, int]] = []
    further = make_further(
        [scene], backbone, network, data, split, CONFIG, np.random.default_rng(1), lambda *call: calls.append(call)
    )
    return data, split, network, further, calls


def test_only_what_is_not_held_out_is_copied(made):
    _, split, _, further, calls = made
    copies = round(CONFIG.views / (~split.views).sum())
    assert copies > 1
    assert np.array_equal(np.bincount(further.originals, minlength=len(split.views)), copies * ~split.views)
    assert len(further.views) == len(further.originals) == len(further.boxes) == len(further.states)
    total = len(further.originals) + further.counts.sum()
    assert calls == [(number, total) for number in range(1, total + 1)]


def test_states_and_boxes_agree(made):
    data, _, _, further, _ = made
    original = data.states[further.originals]
    areas = further.boxes[..., 2:].prod(axis=-1)
    assert (further.states[original == ABSENT] == ABSENT).all()
    assert (areas[further.states == PRESENT] >= data.smallest_area).all()
    assert (further.states == PRESENT).any()
    assert np.isfinite(further.boxes).all()


def test_a_copy_is_what_the_backbone_makes_of_it(scene, backbone):
    """Against the obvious way: without batches, one copy after the other."""
    from active_perceiver.recognition.augmentation import changed_view

    data, split, network = material([scene], backbone)
    config = FurtherConfig(views=1, pictures=0, cut_outs=0)
    further = make_further([scene], backbone, network, data, split, config, np.random.default_rng(5))
    rng = np.random.default_rng(5)
    for number, row in enumerate(further.originals[:5]):
        image, _, _ = changed_view(scene.view(int(row)), scene.boxes[row], backbone.image_size, rng)
        with torch.inference_mode():
            expected = network.prepare(torch.from_numpy(backbone.maps([image])))[0]
        assert torch.allclose(further.views[number].float(), expected, atol=0.02, rtol=0.02)
    assert further.pictures.shape[1] == 0
    assert not further.counts.any()


def test_nothing_is_made_of_held_out_targets(scene, backbone):
    data, split, network = material([scene], backbone, targets=("ball1",))
    further = make_further([scene], backbone, network, data, split, CONFIG, np.random.default_rng(1))
    assert (further.counts == 0).tolist() == [False, True, False]


def test_several_scenes_keep_their_targets_apart(scene, backbone):
    other = replace(toy_scene(side=2, seed=1), name="other")
    data, split, network = material([scene, other], backbone)
    further = make_further([scene, other], backbone, network, data, split, CONFIG, np.random.default_rng(1))
    together, its_split = further.added_to(data, split)
    assert len(together.boxes) == len(its_split.views) == len(data.boxes) + len(further.originals)
    assert not its_split.views[len(data.boxes) :].any()
    of_first = further.originals < len(scene)
    mine = np.array([name.startswith(f"{scene.name}/") for name in data.names])
    assert (further.states[np.ix_(of_first, ~mine)] == UNJUDGED).all()
    assert (further.states[np.ix_(~of_first, mine)] == UNJUDGED).all()


def test_the_sampler_asks_with_further_pictures_too(made):
    data, split, _, further, _ = made
    everything = further.added_to(data, split)
    sampler = PairSampler(*everything, 0.7, np.random.default_rng(0), further.counts, 0.5)
    batch = sampler.draw(200, 2)
    most = int(data.pictures.max())
    own = batch.pictures < most
    assert 0.4 < own.mean() < 0.6
    assert (batch.pictures[own] < split.seen_pictures[batch.targets][own]).all()
    assert (batch.pictures[~own] - most < further.counts[batch.targets][~own]).all()
    assert (batch.views >= len(data.boxes)).any()
    only_own = PairSampler(data, split, 0.7, np.random.default_rng(0)).draw(50, 2)
    assert (only_own.pictures < split.seen_pictures[only_own.targets]).all()


def test_training_uses_it(scene, backbone):
    """The same seed gives the same weights, and others than without it."""
    features = scene_features(scene, backbone)
    config = RecogniserConfig(steps=4, views=6, threads=1, further=CONFIG)
    one, two = (
        train_recogniser([scene], [features], config, backbone=backbone).network.state_dict() for _ in range(2)
    )
    assert all(torch.equal(one[name], two[name]) for name in one)
    without = replace(config, further=NO_FURTHER)
    other = train_recogniser([scene], [features], without, backbone=backbone).network.state_dict()
    assert not all(torch.equal(one[name], other[name]) for name in one)
