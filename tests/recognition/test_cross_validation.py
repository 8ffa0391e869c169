from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from active_perceiver.recognition import RecogniserError, detect_table
from active_perceiver.recognition.metrics import RecognitionMetrics
from active_perceiver.recognition.pairs import PairSampler
from active_perceiver.vision import scene_features
from helpers.toy import toy_scene

torch = pytest.importorskip("torch")

from active_perceiver.recognition import train as training  # noqa: E402
from active_perceiver.recognition.cross_validation import CrossValidated, cross_validate  # noqa: E402
from active_perceiver.recognition.train import CONFIGS, train_recogniser  # noqa: E402

FOLDS = 3
SHORT = replace(CONFIGS["pooled"], steps=30, views=8, threads=1)


@pytest.fixture(scope="module")
def features(scene, backbone):
    return scene_features(scene, backbone)


@pytest.fixture(scope="module")
def judged(scene, features):
    return cross_validate(scene, features, SHORT, FOLDS)


@pytest.fixture
def saved(judged, tmp_path):
    path = tmp_path / "cache" / "toy.npz"
    judged.save(path)
    return path


def _logits(scores):
    scores = scores.astype(np.float64)
    return np.log(scores / (1.0 - scores)).ravel()


def test_places_are_dealt_evenly_and_whole(scene, judged):
    folds_of_place = [np.unique(judged.folds[scene.positions == place]) for place in range(16)]
    assert all(len(folds) == 1 for folds in folds_of_place)
    assert sorted(np.bincount(np.concatenate(folds_of_place))) == [5, 5, 6]


def test_no_recogniser_is_trained_where_it_judges(scene, features, monkeypatch):
    drawn: list[set[int]] = []

    class Spy(PairSampler):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            drawn.append(set())

        def draw(self, views, targets):
            batch = super().draw(views, targets)
            drawn[-1].update(scene.positions[batch.views].tolist())
            return batch

    monkeypatch.setattr(training, "PairSampler", Spy)
    judged = cross_validate(scene, features, SHORT, FOLDS)
    for fold, places in enumerate(drawn):
        others = set(scene.positions[judged.folds != fold].tolist())
        assert places == others  # so many draws reach every place, and none of the fold's own
    assert len(drawn) == FOLDS


def test_what_a_folds_own_views_are_said_to_show_does_not_change_what_is_seen_there(scene, features, judged):
    own = judged.folds == 1
    wrong = scene.boxes.copy()
    wrong[own] = np.roll(wrong[own], 1, axis=1)  # each target where another one is
    misled = cross_validate(replace(scene, boxes=wrong), features, SHORT, FOLDS)
    np.testing.assert_array_equal(misled.folds, judged.folds)
    np.testing.assert_array_equal(misled.boxes[own], judged.boxes[own])
    before, after = _logits(judged.scores[own]), _logits(misled.scores[own])
    scale, shift = np.polyfit(before, after, 1)  # calibration alone is fitted to these views
    np.testing.assert_allclose(after, scale * before + shift, atol=1e-3)
    assert abs(misled.boxes[~own] - judged.boxes[~own]).max(axis=(1, 2, 3)).min() > 1e-4


def test_the_scores_are_those_of_each_folds_recogniser(scene, features, judged):
    own = judged.folds == 2
    trained = train_recogniser([scene], [features], SHORT, held_out=[own])
    np.testing.assert_array_equal(trained.validation_views[0], own)
    scores, boxes = detect_table(trained.recogniser(1), features)  # through ONNX
    np.testing.assert_allclose(judged.scores[own], scores[own], atol=0.005)  # maps were prepared in half precision
    np.testing.assert_allclose(judged.boxes[own], boxes[own], atol=0.005)
    assert judged.thresholds[2] == trained.threshold


def test_metrics_are_over_all_views(scene, judged):
    assert judged.scores.shape == judged.seen.shape == (len(scene), 3, 4)
    assert judged.boxes.shape == (len(scene), 3, 4, 4)
    assert list(judged.metrics) == ["seen pictures", "unseen pictures"]
    pairs = len(scene) * 3 * 2
    for measured, pictures in zip(judged.metrics.values(), (slice(0, 2), slice(2, 4)), strict=True):
        truth = np.repeat(scene.boxes[:, :, None], 2, 2).reshape(pairs, 4)
        ours = RecognitionMetrics.of(
            judged.scores[:, :, pictures].reshape(pairs), judged.boxes[:, :, pictures].reshape(pairs, 4), truth
        )
        assert (measured.pairs, measured.positives) == (ours.pairs, ours.positives)
        assert measured.auroc == pytest.approx(ours.auroc)
        assert measured.ap50 == pytest.approx(ours.ap50)
        assert measured.mean_iou == pytest.approx(ours.mean_iou)
        there = (scene.areas >= 0.003)[:, :, None]
        absent = np.isnan(scene.boxes[:, :, :1])
        seen = judged.seen[:, :, pictures]
        assert measured.recall == pytest.approx(seen[np.broadcast_to(there, seen.shape)].mean())
        assert measured.false_positive_rate == pytest.approx(seen[np.broadcast_to(absent, seen.shape)].mean())
        one = measured.per_target["toy_0/ball1"]
        assert one.recall == pytest.approx(seen[there[:, 1, 0], 1].mean())


def test_seen_is_by_the_threshold_of_the_fold():
    scores = np.full((2, 1, 1), 0.6, np.float32)
    judged = CrossValidated(
        scores, np.zeros((2, 1, 1, 4), np.float32), np.array([1, 0]), np.array([0.7, 0.5]), {}, 1.0
    )
    assert judged.seen.ravel().tolist() == [True, False]


def test_the_same_seed_gives_the_same_and_another_another(scene, features, judged):
    again = cross_validate(scene, features, SHORT, FOLDS)
    np.testing.assert_array_equal(again.scores, judged.scores)
    np.testing.assert_array_equal(again.boxes, judged.boxes)
    assert again.metrics == judged.metrics
    other = cross_validate(scene, features, replace(SHORT, seed=1, steps=1), FOLDS)
    assert (other.folds != judged.folds).any()


def test_progress_counts_through_all_folds(scene, features):
    calls: list[tuple[int, int]] = []
    cross_validate(
        scene, features, replace(SHORT, steps=2), FOLDS, lambda step, total, note: calls.append((step, total))
    )
    assert calls == [(step, 6) for step in range(1, 7)]


def test_targets_can_be_held_out_too(scene, features):
    judged = cross_validate(scene, features, replace(SHORT, steps=2, held_out_targets=("ball1",)), FOLDS)
    assert set(judged.metrics["unknown targets"].per_target) == {"toy_0/ball1"}


def test_what_is_saved_is_loaded(judged, saved):
    again = CrossValidated.load(saved)
    for name in ("scores", "boxes", "seen", "folds", "thresholds"):
        np.testing.assert_array_equal(getattr(again, name), getattr(judged, name), strict=True)
    assert again.metrics == judged.metrics
    assert again.seconds == judged.seconds
    assert [path.name for path in saved.parent.iterdir()] == ["toy.npz"]


def test_what_is_not_defined_is_loaded_too(judged, tmp_path):
    undefined = RecognitionMetrics.of(np.zeros(1), np.zeros((1, 4)), np.full((1, 4), np.nan))
    replace(judged, metrics={"seen pictures": undefined}).save(tmp_path / "some.npz")
    again = CrossValidated.load(tmp_path / "some.npz").metrics["seen pictures"]
    assert np.isnan(again.auroc)
    assert again.pairs == 1


def test_metrics_of_before_there_was_a_calibration_error_are_loaded(judged, saved):
    with np.load(saved) as file:
        arrays = dict(file)
    metrics = json.loads(arrays.pop("metrics").item())
    for measured in metrics.values():
        for one in (measured, *measured["per_target"].values()):
            del one["calibration_error"]
    np.savez_compressed(saved, metrics=json.dumps(metrics), **arrays)
    for name, measured in CrossValidated.load(saved).metrics.items():
        assert np.isnan(measured.calibration_error)
        assert measured.ap50 == judged.metrics[name].ap50


@pytest.mark.parametrize("cut", [0, 1, 100, -1, -200])
def test_cut_files(saved, cut):
    saved.write_bytes(saved.read_bytes()[:cut])
    with pytest.raises(RecogniserError, match="delete it, it is made anew"):
        CrossValidated.load(saved)


def test_damaged_files(saved):
    sound = saved.read_bytes()
    for start in range(0, len(sound), len(sound) // 60):
        saved.write_bytes(
            sound[:start] + bytes(byte ^ 0x5A for byte in sound[start : start + 8]) + sound[start + 8 :]
        )
        try:
            CrossValidated.load(saved)  # a byte that means nothing may be another
        except RecogniserError as error:
            assert "delete it, it is made anew" in str(error)  # noqa: PT017


@pytest.mark.parametrize(
    "change",
    [
        {"scores": np.full((192, 3, 4), np.nan, np.float32)},
        {"scores": np.full((192, 3, 4), 1.5, np.float32)},
        {"scores": np.zeros((192, 3, 4))},
        {"scores": np.zeros((192, 3), np.float32)},
        {"boxes": np.zeros((192, 3, 4, 3), np.float32)},
        {"boxes": np.full((192, 3, 4, 4), np.inf, np.float32)},
        {"folds": np.zeros(192, np.int64)},
        {"folds": np.arange(191) % 3},
        {"folds": np.arange(192) % 4},
        {"folds": np.array(["a"] * 192)},
        {"thresholds": np.zeros((3, 1))},
        {"thresholds": np.array([0.5, np.nan, 0.5])},
        {"thresholds": np.array([0.5, -1.0, 0.5])},
        {"metrics": np.array("{")},
        {"metrics": np.array("[]")},
        {"metrics": np.array('{"seen pictures": {"per_target": {}}}')},
        {"metrics": np.array(3)},
        {"seconds": np.array("long")},
        {"seconds": None},
        {"scores": np.array([{}], object)},
    ],
)
def test_files_that_hold_something_else(saved, change):
    with np.load(saved) as file:
        arrays = {**file, **change}
    np.savez(saved, **{name: array for name, array in arrays.items() if array is not None}, allow_pickle=True)
    with pytest.raises(RecogniserError, match="delete it, it is made anew"):
        CrossValidated.load(saved)


def test_files_of_another_kind(tmp_path):
    with pytest.raises(RecogniserError, match="cross-validate the recogniser first"):
        CrossValidated.load(tmp_path / "none.npz")
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(RecogniserError, match="delete it, it is made anew"):
        CrossValidated.load(tmp_path / "array.npy")


def test_bad_input(scene, features):
    with pytest.raises(RecogniserError, match="needs 2 folds or more, got 1"):
        cross_validate(scene, features, SHORT, 1)
    with pytest.raises(RecogniserError, match="has 16 places, too few for 17 folds; use at most one fold a place"):
        cross_validate(scene, features, SHORT, 17)
    with pytest.raises(RecogniserError, match="of another scene"):
        cross_validate(toy_scene(side=2), features, SHORT, 2)
    with pytest.raises(RecogniserError, match="no target is large enough"):
        cross_validate(replace(scene, boxes=np.full_like(scene.boxes, np.nan)), features, SHORT, 2)


def test_bad_views_to_hold_out(scene, features):
    everywhere = np.ones(len(scene), bool)
    one_view = np.arange(len(scene)) == 0
    for held_out, message in (
        ([everywhere], "leave some places to train on"),
        ([one_view], "hold out all of them or none"),
        ([everywhere[1:]], "one mask a scene"),
        ([everywhere, everywhere], "one mask a scene"),
    ):
        with pytest.raises(RecogniserError, match=message):
            train_recogniser([scene], [features], SHORT, held_out=held_out)
