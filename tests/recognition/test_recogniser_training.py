from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from active_perceiver.recognition import RecogniserError, detect_table
from active_perceiver.recognition.metrics import RecognitionMetrics
from active_perceiver.recognition.pairs import ABSENT, IGNORE_INDEX, PRESENT, Annotations, PairSampler, Split
from active_perceiver.vision import scene_features
from helpers.toy import toy_scene

torch = pytest.importorskip("torch")

from active_perceiver.recognition.calibration import _spread, platt_scaling  # noqa: E402
from active_perceiver.recognition.train import CONFIGS, RecogniserConfig, train_recogniser  # noqa: E402

STEPS = 150
SHORT = RecogniserConfig(steps=STEPS, views=8, learning_rate=4e-3, threads=1)


@pytest.fixture(scope="module")
def features(scene, backbone):
    return scene_features(scene, backbone)


@pytest.fixture(scope="module")
def trained(scene, features):
    calls: list[tuple[int, int, str]] = []
    result = train_recogniser([scene], [features], SHORT, lambda *call: calls.append(call))
    assert [call[:2] for call in calls] == [(step, STEPS) for step in range(1, STEPS + 1)]
    assert float(calls[-1][2].removeprefix("loss ")) < float(calls[0][2].removeprefix("loss "))
    return result


def test_matching_learns(trained):
    assert trained.metrics["seen pictures"].auroc > 0.9
    assert trained.metrics["unseen pictures"].auroc > 0.9
    assert set(trained.metrics["seen pictures"].per_target) == {"toy_0/ball0", "toy_0/ball1", "toy_0/ball2"}


def test_pooled_learns(scene, features):
    config = replace(CONFIGS["pooled"], steps=150, threads=1)
    assert train_recogniser([scene], [features], config).metrics["seen pictures"].auroc > 0.65


def test_the_papers_optimiser_runs(scene, features):
    config = replace(CONFIGS["pooled"], steps=3, optimiser="sgd", threads=1)
    assert np.isfinite(train_recogniser([scene], [features], config).metrics["seen pictures"].auroc)


def test_training_is_deterministic(scene, features, trained):
    torch.manual_seed(12345)  # what the caller did before must not matter
    short = replace(SHORT, steps=4)
    one, two = (train_recogniser([scene], [features], short).network.state_dict() for _ in range(2))
    assert all(torch.equal(one[name], two[name]) for name in one)
    other = train_recogniser([scene], [features], replace(short, seed=1)).network.state_dict()
    assert not all(torch.equal(one[name], other[name]) for name in one)


def test_the_callers_random_numbers_and_threads_are_left_alone(scene, features):
    torch.manual_seed(7)
    before, threads = torch.random.get_rng_state(), torch.get_num_threads()
    train_recogniser([scene], [features], replace(SHORT, steps=1))
    assert torch.equal(torch.random.get_rng_state(), before)
    assert torch.get_num_threads() == threads


def test_the_metrics_are_those_of_what_is_saved(scene, features, trained, tmp_path):
    trained.save(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["recogniser.onnx", "recogniser.safetensors"]
    held_out = trained.validation_views[0]
    scores, boxes = detect_table(trained.recogniser(1), features)
    pairs = held_out.sum() * 3 * 2
    again = RecognitionMetrics.of(
        scores[held_out, :, :2].reshape(pairs),
        boxes[held_out, :, :2].reshape(pairs, 4),
        np.repeat(scene.boxes[held_out][:, :, None], 2, 2).reshape(pairs, 4),
        trained.threshold,
    )
    ours = trained.metrics["seen pictures"]
    assert again.pairs == ours.pairs
    assert again.auroc == pytest.approx(ours.auroc, abs=0.005)
    assert again.mean_iou == pytest.approx(ours.mean_iou, abs=0.02)


def test_held_out_targets_are_measured_apart(scene, features):
    result = train_recogniser([scene], [features], replace(SHORT, steps=2, held_out_targets=("ball1",)))
    assert set(result.metrics["unknown targets"].per_target) == {"toy_0/ball1"}
    assert "toy_0/ball1" not in result.metrics["seen pictures"].per_target


def test_two_scenes_at_once(scene, features, backbone):
    small = toy_scene(seed=5, side=2, targets=2)
    pictures = small.targets[0].pictures[:2]
    small = replace(small, targets=(replace(small.targets[0], pictures=pictures, held_out=0), small.targets[1]))
    result = train_recogniser([scene, small], [features, scene_features(small, backbone)], replace(SHORT, steps=2))
    assert [len(views) for views in result.validation_views] == [len(scene), len(small)]
    assert "toy_5/ball1" in result.metrics["unseen pictures"].per_target
    assert "toy_5/ball0" not in result.metrics["unseen pictures"].per_target  # its two pictures are all trained with


def test_pictures_that_are_held_out_never_reach_the_network(scene, features):
    """Whatever is in their place, the same network comes out of it."""
    maps = features.target_maps.copy()
    maps[:, 2:] = 7.0
    short = replace(SHORT, steps=3)
    one, two = (
        train_recogniser([scene], [some], short).network.state_dict()
        for some in (features, replace(features, target_maps=maps))
    )
    learned = [name for name in one if name.split(".")[-1] not in ("scale", "shift")]  # calibrated on held-out ones
    assert len(learned) > 5
    assert all(torch.equal(one[name], two[name]) for name in learned)


def test_without_steps_the_start_is_judged_as_it_is(scene, features, trained, backbone, monkeypatch):
    from active_perceiver.recognition import train as training

    start = deepcopy(trained.network)
    monkeypatch.setattr(training, "pretrained_network", lambda *_: deepcopy(start))
    result = train_recogniser([scene], [features], replace(SHORT, steps=0), backbone=backbone)
    learned = dict(start.named_parameters())
    assert all(torch.equal(learned[name], value) for name, value in result.network.named_parameters())
    np.testing.assert_array_equal(result.validation_views, trained.validation_views)
    for name, metrics in result.metrics.items():  # calibrated again: scores differ, their order does not
        assert metrics.auroc == pytest.approx(trained.metrics[name].auroc, abs=1e-3)
        assert metrics.mean_iou == pytest.approx(trained.metrics[name].mean_iou)
    scratch = train_recogniser([scene], [features], replace(SHORT, steps=0, start="scratch"), backbone=backbone)
    assert 0 < scratch.threshold < 1
    assert scratch.metrics["seen pictures"].ap50 < 0.5 < trained.metrics["seen pictures"].ap50


def test_what_is_judged_is_spread_over_the_pictures():
    assert [_spread(*ends) for ends in ((0, 8), (8, 12), (2, 3), (4, 4))] == [[0, 4], [8, 10], [2], []]


def test_bad_input(scene, features):
    with pytest.raises(RecogniserError, match="there are matching, pooled"):
        RecogniserConfig(kind="guessing")
    with pytest.raises(RecogniserError, match="optimiser is one of adamw, sgd"):
        RecogniserConfig(optimiser="adam")
    with pytest.raises(RecogniserError, match="at least 1"):
        RecogniserConfig(steps=-1)
    with pytest.raises(RecogniserError, match="at least 1"):
        RecogniserConfig(views=0)
    with pytest.raises(RecogniserError, match="held_out_places"):
        RecogniserConfig(held_out_places=1.0)
    with pytest.raises(RecogniserError, match="averaging"):
        RecogniserConfig(averaging=1.0)
    with pytest.raises(RecogniserError, match="own_pictures"):
        RecogniserConfig(own_pictures=1.5)
    with pytest.raises(RecogniserError, match="start is one of pretrained, scratch"):
        RecogniserConfig(start="anywhere")
    with pytest.raises(RecogniserError, match="features of each"):
        train_recogniser([scene], [], SHORT)
    with pytest.raises(RecogniserError, match="of another scene"):
        train_recogniser([toy_scene(side=1)], [features], SHORT)
    with pytest.raises(RecogniserError, match="different backbones"):
        train_recogniser([scene, scene], [features, replace(features, backbone="other")], SHORT)
    with pytest.raises(RecogniserError, match="no targets"):
        train_recogniser([scene], [features], replace(SHORT, held_out_targets=("spoon",)))
    unseen = replace(scene, boxes=np.full_like(scene.boxes, np.nan))
    with pytest.raises(RecogniserError, match="no target is large enough"):
        train_recogniser([unseen], [features], SHORT)


def test_annotations_and_split(scene):
    data = Annotations.of([scene, scene], smallest_area=0.01)
    states = len(scene)
    assert (data.states[:states, 3:] == IGNORE_INDEX).all()  # a target of another scene
    visible = ~np.isnan(scene.boxes[..., 0])
    own = data.states[:states, :3]
    assert ((own == ABSENT) == ~visible).all()
    assert ((own == PRESENT) == (scene.areas >= 0.01)).all()
    assert (own[visible & (scene.areas < 0.01)] == IGNORE_INDEX).all()
    split = Split.of(data, 0.2, ("ball2",), np.random.default_rng(0))
    places = [set(data.places[rows].tolist()) for rows in (split.views, ~split.views)]
    assert not places[0] & places[1]
    assert len(places[0]) == round(0.2 * 32)
    assert split.targets.tolist() == [False, False, True] * 2
    assert split.seen_pictures.tolist() == [2] * 6


def test_batches_hold_nothing_that_was_kept_out(scene):
    targets = tuple(replace(target, held_out=1) for target in scene.targets)
    data = Annotations.of([replace(scene, targets=targets)], smallest_area=0.003)
    split = Split.of(data, 0.3, ("ball0",), np.random.default_rng(0))
    sampler = PairSampler(data, split, 0.7, np.random.default_rng(1))
    batches = [sampler.draw(16, 2) for _ in range(20)]
    views, targets, pictures, states, boxes = (
        np.concatenate([getattr(batch, name) for batch in batches])
        for name in ("views", "targets", "pictures", "states", "boxes")
    )
    assert not split.views[views].any()
    assert not (targets == 0)[states != IGNORE_INDEX].any()
    assert set(pictures.ravel()) == {0, 1, 2}
    assert 0.6 < (states[:, 0] == PRESENT).mean() < 0.8
    present = states == PRESENT
    np.testing.assert_array_equal(boxes[present], scene.boxes[views[:, None], targets][present])
    assert np.isfinite(boxes).all()


def test_platt_scaling_makes_scores_probabilities(rng):
    truth = rng.random(20_000) < 0.2
    log_odds = rng.normal(2.0 * truth - 1.0, 1.0)  # exact log-odds: 2 x + log(0.2 / 0.8)
    scale, shift = platt_scaling((log_odds * 3 + 5).astype(np.float32), truth)
    assert scale == pytest.approx(2 / 3, rel=0.1)
    assert shift == pytest.approx(np.log(0.25) - 5 * 2 / 3, rel=0.1)
    assert platt_scaling(np.zeros(3, np.float32), np.ones(3, bool)) == (1.0, 0.0)
    separable = platt_scaling(np.array([-1.0, 1.0], np.float32), np.array([False, True]))
    assert np.isfinite(separable).all()
