from __future__ import annotations

import contextlib
import io
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.recognition.metrics import (
    RecognitionMetrics,
    auroc,
    average_precision,
    box_iou,
    calibration_error,
    choose_threshold,
)

NOWHERE = [np.nan] * 4


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ([0.5, 0.5, 0.2, 0.2], [0.5, 0.5, 0.2, 0.2], 1.0),
        ([0.5, 0.5, 0.2, 0.2], [0.6, 0.5, 0.2, 0.2], 1 / 3),
        ([0.5, 0.5, 0.4, 0.4], [0.5, 0.5, 0.2, 0.2], 0.25),
        ([0.2, 0.2, 0.1, 0.1], [0.8, 0.8, 0.1, 0.1], 0.0),
        ([0.2, 0.2, 0.0, 0.0], [0.2, 0.2, 0.0, 0.0], 0.0),
        (NOWHERE, [0.5, 0.5, 0.2, 0.2], np.nan),
    ],
)
def test_iou(one, other, expected):
    assert box_iou(np.array(one), np.array(other)) == pytest.approx(expected, nan_ok=True)


@given(st.lists(st.tuples(st.integers(0, 6), st.booleans()), min_size=1, max_size=40))
def test_auroc_is_the_chance_that_a_positive_scores_higher(pairs):
    scores, present = np.array([s for s, _ in pairs], float), np.array([p for _, p in pairs])
    higher = [
        1.0 if positive > negative else 0.5 if positive == negative else 0.0
        for positive in scores[present]
        for negative in scores[~present]
    ]
    expected = np.mean(higher) if higher else np.nan
    assert auroc(scores, present) == pytest.approx(expected, nan_ok=True)


def test_ap50_agrees_with_pycocotools(rng):
    coco_module = pytest.importorskip("pycocotools.coco")
    from pycocotools.cocoeval import COCOeval

    count = 300
    truth = np.column_stack([rng.uniform(0.3, 0.7, (count, 2)), rng.uniform(0.1, 0.3, (count, 2))])
    boxes = truth + rng.normal(0, 0.03, truth.shape)
    boxes[:, 2:] = np.abs(boxes[:, 2:])
    present = rng.random(count) < 0.4
    truth[~present] = np.nan
    scores = rng.permutation(count) / count + 0.3 * present

    def corner(box: np.ndarray) -> list[float]:
        return [*(1000 * (box[:2] - box[2:] / 2)), *(1000 * box[2:])]

    annotations = [
        {"id": i + 1, "image_id": i, "category_id": 1, "bbox": corner(truth[i]), "iscrowd": 0,
         "area": 1e6 * truth[i, 2] * truth[i, 3]}
        for i in np.flatnonzero(present).tolist()
    ]  # fmt: skip
    detections = [
        {"image_id": i, "category_id": 1, "bbox": corner(boxes[i]), "score": float(scores[i])} for i in range(count)
    ]
    with contextlib.redirect_stdout(io.StringIO()):
        coco = coco_module.COCO()
        images = [{"id": i, "width": 1000, "height": 1000} for i in range(count)]
        coco.dataset = {"images": images, "annotations": annotations, "categories": [{"id": 1, "name": "x"}]}
        coco.createIndex()
        evaluate_pairs = COCOeval(coco, coco.loadRes(detections), "bbox")
        evaluate_pairs.params.iouThrs = np.array([0.5])
        evaluate_pairs.params.recThrs = np.linspace(0, 1, 10_001)  # COCO's 101 points are coarser than the exact area
        evaluate_pairs.evaluate()
        evaluate_pairs.accumulate()
    expected = evaluate_pairs.eval["precision"][0, :, 0, 0, 2].mean()
    assert 0.3 < expected < 0.95
    assert RecognitionMetrics.of(scores, boxes, truth).ap50 == pytest.approx(expected, abs=0.002)


def test_average_precision_by_hand():
    hits = np.array([True, False, True, False])
    assert average_precision(np.array([4.0, 3.0, 2.0, 1.0]), hits, 3) == pytest.approx((1 + 2 / 3) / 3)
    assert np.isnan(average_precision(np.array([1.0]), np.array([False]), 0))


def test_metrics_by_hand():
    truth = np.array([[0.5, 0.5, 0.2, 0.2], [0.5, 0.5, 0.2, 0.2], NOWHERE, NOWHERE, [0.5, 0.5, 0.01, 0.01]])
    boxes = np.tile([0.5, 0.5, 0.2, 0.2], (5, 1))
    boxes[1, 0] = 0.65
    scores = np.array([0.9, 0.4, 0.6, 0.1, 0.99])  # the last one is visible, but too small to judge
    metrics = RecognitionMetrics.of(scores, boxes, truth, 0.5, np.array(["a", "a", "a", "b", "b"]))
    assert (metrics.pairs, metrics.positives) == (4, 2)
    assert metrics.auroc == 0.75
    assert metrics.mean_iou == pytest.approx((1 + 1 / 7) / 2)
    assert metrics.ap50 == 0.5
    assert (metrics.recall, metrics.false_positive_rate) == (0.5, 0.5)
    assert metrics.calibration_error == pytest.approx((0.1 + 0.6 + 0.6 + 0.1) / 4)  # each in a bin of its own
    assert metrics.per_target["a"].auroc == 0.5
    plain = json.loads(json.dumps(metrics.as_dict(), allow_nan=False))
    assert plain["per_target"]["b"]["auroc"] is None
    assert plain["per_target"]["b"]["pairs"] == 1


@given(st.lists(st.tuples(st.integers(0, 40), st.booleans()), min_size=1, max_size=60))
def test_calibration_error_is_the_mean_gap_of_the_bins(pairs):
    scores, present = np.array([s / 40 for s, _ in pairs]), np.array([p for _, p in pairs])
    expected = 0.0
    for number in range(10):
        inside = [k for k, (s, _) in enumerate(pairs) if min(s // 4, 9) == number]
        if inside:
            expected += len(inside) / len(pairs) * abs(scores[inside].mean() - present[inside].mean())
    assert calibration_error(scores, present) == pytest.approx(expected)


def test_calibration_error_where_it_is_known(rng):
    probabilities = rng.random(200_000).astype(np.float32)
    assert calibration_error(probabilities, rng.random(200_000) < probabilities) < 0.01
    assert calibration_error(np.ones(4), np.array([True, False, False, True])) == 0.5
    assert np.isnan(calibration_error(np.empty(0), np.empty(0, bool)))


def test_bad_input():
    with pytest.raises(ValueError, match="do not fit"):
        RecognitionMetrics.of(np.zeros(3), np.zeros((3, 4)), np.zeros((2, 4)))
    with pytest.raises(ValueError, match="finite"):
        RecognitionMetrics.of(np.full(1, np.nan), np.zeros((1, 4)), np.zeros((1, 4)))


@pytest.mark.parametrize(
    ("negatives", "most_false", "expected"),
    [
        ([0.01, 0.02, 0.31, 0.4], 0.25, 0.35),
        ([0.01, 0.02, 0.31, 0.4], 0.0, 0.45),
        ([0.99] * 4, 0.0, 0.95),
        ([0.0] * 4, 0.0, 0.05),
        ([], 0.0, 0.5),
    ],
)
def test_threshold(negatives, most_false, expected):
    scores = np.array([*negatives, 0.9])
    assert choose_threshold(scores, scores == 0.9, most_false) == pytest.approx(expected)
