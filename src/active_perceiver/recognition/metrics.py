"""How good a recogniser is: AUROC, average precision at IoU 0.5, mean IoU, calibration. Plain numpy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Objects that cover less of the image than this are too small to judge: they count neither as there nor as absent.
SMALLEST_AREA = 0.003
# Bins of equal width in which probabilities are compared with how often they are right.
CALIBRATION_BINS = 10


def box_iou(one: NDArray[np.floating], other: NDArray[np.floating]) -> NDArray[np.float64]:
    """Intersection over union of boxes.

    Args:
        one: (..., 4) centre x, centre y, width, height.
        other: (..., 4), broadcast against `one`.

    Returns:
        (...) float64 in 0..1; NaN where a box is NaN, 0 where both are empty.
    """
    one, other = np.asarray(one, np.float64), np.asarray(other, np.float64)
    low = np.maximum(one[..., :2] - one[..., 2:] / 2, other[..., :2] - other[..., 2:] / 2)
    high = np.minimum(one[..., :2] + one[..., 2:] / 2, other[..., :2] + other[..., 2:] / 2)
    shared = np.clip(high - low, 0.0, None).prod(-1)
    union = one[..., 2:].prod(-1) + other[..., 2:].prod(-1) - shared
    return shared / np.where(union == 0.0, 1.0, union)


def auroc(scores: NDArray[np.floating], present: NDArray[np.bool_]) -> float:
    """Area under the ROC curve: how often a positive scores above a negative; ties count half.

    Args:
        scores: (N,) any numbers that grow with confidence.
        present: (N,) truth.

    Returns:
        0..1; NaN if there are no positives or no negatives.
    """
    from scipy.stats import rankdata  # takes long to import, and a robot never needs it

    positives = int(present.sum())
    negatives = len(present) - positives
    if positives == 0 or negatives == 0:
        return float("nan")
    rank_sum = rankdata(scores)[present].sum()
    return float((rank_sum - positives * (positives + 1) / 2) / (positives * negatives))


def average_precision(scores: NDArray[np.floating], hits: NDArray[np.bool_], positives: int) -> float:
    """Area under the interpolated precision-recall curve, as in PASCAL VOC 2010 and COCO (at one IoU).

    Args:
        scores: (N,) one a detection.
        hits: (N,) whether the detection is right: the object is there and the boxes overlap enough.
        positives: number of objects that could be found.

    Returns:
        0..1; NaN if there is nothing to find.
    """
    if positives == 0:
        return float("nan")
    hit = hits[np.argsort(-scores, kind="stable")]
    precision = np.cumsum(hit) / np.arange(1, len(hit) + 1)
    best_from_here_on = np.maximum.accumulate(precision[::-1])[::-1]
    return float(best_from_here_on[hit].sum() / positives)


def calibration_error(probabilities: NDArray[np.floating], present: NDArray[np.bool_]) -> float:
    """How far probabilities are from how often they are right: the expected calibration error.

    Guo et al., "On Calibration of Modern Neural Networks", ICML 2017, https://arxiv.org/abs/1706.04599, equation 3,
    for the probability that the object is there: in each bin of equal width the mean probability less the fraction of
    positives, without its sign, averaged over all.

    Args:
        probabilities: (N,) 0..1.
        present: (N,) truth.

    Returns:
        0..1; NaN if there are none.
    """
    if not len(probabilities):
        return float("nan")
    bins = np.clip((probabilities * CALIBRATION_BINS).astype(np.int64), 0, CALIBRATION_BINS - 1)
    # A bin's difference of means times its share of all is the difference of its sums over the number of all.
    excess = np.bincount(bins, probabilities.astype(np.float64) - present, CALIBRATION_BINS)
    return float(np.abs(excess).sum() / len(probabilities))


@dataclass(frozen=True)
class RecognitionMetrics:
    """Quality of a recogniser over pairs of a view and a target picture.

    Attributes:
        pairs: number of pairs judged; objects that are visible but too small are left out.
        positives: how many of them show the target.
        auroc: how often a view with the target scores above one without.
        ap50: average precision of boxes at IoU 0.5.
        mean_iou: over the positives, whatever their score.
        threshold: score from which on a detection counts, for the two rates below.
        recall: fraction of the positives that score at least the threshold.
        false_positive_rate: fraction of the negatives that do.
        calibration_error: of the scores as probabilities, see `calibration_error`; NaN in what was saved before there
            was one.
        per_target: the same for each target by name.
    """

    pairs: int
    positives: int
    auroc: float
    ap50: float
    mean_iou: float
    threshold: float
    recall: float
    false_positive_rate: float
    calibration_error: float = float("nan")
    per_target: Mapping[str, RecognitionMetrics] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        scores: NDArray[np.floating],
        boxes: NDArray[np.floating],
        truth: NDArray[np.floating],
        threshold: float = 0.5,
        targets: NDArray[np.str_] | None = None,
        smallest_area: float = SMALLEST_AREA,
    ) -> RecognitionMetrics:
        """Judge detections.

        Args:
            scores: (N,) presence probabilities.
            boxes: (N, 4) detected boxes.
            truth: (N, 4) true boxes, NaN where the target is not visible.
            threshold: score from which on a detection counts.
            targets: (N,) names, to judge each target on its own as well.
            smallest_area: smaller visible objects are left out, a fraction of the image.

        Raises:
            ValueError: if shapes do not agree or a score is not finite.
        """
        if scores.ndim != 1 or boxes.shape != (len(scores), 4) or truth.shape != boxes.shape:
            raise ValueError(
                f"scores {scores.shape}, boxes {boxes.shape} and truth {truth.shape} do not fit together"
            )
        if not np.isfinite(scores).all():
            raise ValueError("scores must be finite numbers")
        area = truth[:, 2] * truth[:, 3]
        judged = np.isnan(area) | (area >= smallest_area)
        present = judged & ~np.isnan(area)
        overlap = np.where(present, box_iou(boxes, truth), 0.0)
        names = [] if targets is None else np.unique(targets).tolist()
        per_target = {
            name: cls.of(
                scores[targets == name],
                boxes[targets == name],
                truth[targets == name],
                threshold,
                None,
                smallest_area,
            )
            for name in names
        }
        scores, present, overlap = scores[judged], present[judged], overlap[judged]
        return cls(
            pairs=len(scores),
            positives=int(present.sum()),
            auroc=auroc(scores, present),
            ap50=average_precision(scores, present & (overlap >= 0.5), int(present.sum())),
            mean_iou=_mean(overlap[present]),
            threshold=threshold,
            recall=_mean(scores[present] >= threshold),
            false_positive_rate=_mean(scores[~present] >= threshold),
            calibration_error=calibration_error(scores, present),
            per_target=per_target,
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain data for a JSON file; what is not defined is None."""
        return {name: _plain(value) for name, value in vars(self).items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: metrics.as_dict() for name, metrics in value.items()}
    return None if np.isnan(value) else value


def _mean(values: NDArray[Any]) -> float:
    return float(values.mean()) if len(values) else float("nan")


def choose_threshold(scores: NDArray[np.floating], present: NDArray[np.bool_], most_false: float) -> float:
    """The lowest threshold in 0.05..0.95 at which at most a fraction of the negatives counts as seen.

    Args:
        scores: (N,) presence probabilities.
        present: (N,) truth.
        most_false: allowed fraction of negatives at or above the threshold, 0..1.

    Returns:
        A multiple of 0.05; 0.95 if no lower one will do, 0.5 if there are no negatives to tell by.
    """
    negatives = scores[~present]
    if not len(negatives):
        return 0.5
    steps = np.arange(1, 20) / 20
    enough = [(negatives >= step).mean() <= most_false for step in steps]
    return float(steps[enough.index(True)]) if any(enough) else 0.95
