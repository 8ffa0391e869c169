"""Cross-validation by place (the paper, section IV-A): detections by recognisers that were never there."""

from __future__ import annotations

import json
import time
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.recognition.calibration import evaluate_pairs, measure, queries, sigmoid
from active_perceiver.recognition.metrics import RecognitionMetrics
from active_perceiver.recognition.network import RecogniserNetwork
from active_perceiver.recognition.pairs import Annotations, Split
from active_perceiver.recognition.recogniser import RecogniserError
from active_perceiver.recognition.train import RecogniserConfig, prepared, train_recogniser, using_threads
from active_perceiver.scenes.scene import Scene
from active_perceiver.utils.files import replacing
from active_perceiver.utils.progress import ProgressCallback, part_of, quiet
from active_perceiver.vision.cache import SceneFeatures


@dataclass(frozen=True, eq=False)
class CrossValidated:
    """What k recognisers, each trained on k - 1 folds of a scene's places, see in the views of the remaining fold.

    Each fold's calibration and threshold were fitted to the views that it judges here, as `train_recogniser` fits
    them to what it holds out: two numbers for the calibration and one for the threshold, shared by all targets. The
    weights have not seen these views.

    Attributes:
        scores: (S, T, K) float32 presence probabilities, asked for with each of K pictures of each of T targets.
        boxes: (S, T, K, 4) float32 where the target would be: centre x, centre y, width, height as fractions of the
            image.
        folds: (S,) int64, 0 .. k - 1: the fold of each view, the one that judged it.
        thresholds: (k,) float64, of each fold: presence probability from which on a detection counts.
        metrics: like those of `TrainedRecogniser`, over the views of all folds together; recall and false positive
            rate are those of `seen`, and the threshold is the mean over the views.
        seconds: wall time of all trainings and detections.
    """

    scores: NDArray[np.float32]
    boxes: NDArray[np.float32]
    folds: NDArray[np.int64]
    thresholds: NDArray[np.float64]
    metrics: Mapping[str, RecognitionMetrics]
    seconds: float

    def __post_init__(self) -> None:
        """Raises RecogniserError if the arrays do not fit together or hold impossible numbers."""
        types = {"scores": np.float32, "boxes": np.float32, "folds": np.int64, "thresholds": np.float64}
        for name, kind in types.items():
            array = getattr(self, name)
            if array.dtype != kind or not np.isfinite(array).all():
                raise RecogniserError(f"{name} must be finite numbers of type {np.dtype(kind)}")
        shape = self.scores.shape
        ranks = (len(shape), self.thresholds.ndim)
        if ranks != (3, 1) or (self.boxes.shape, self.folds.shape) != ((*shape, 4), shape[:1]):
            raise RecogniserError(
                f"scores {shape}, boxes {self.boxes.shape}, folds {self.folds.shape} and thresholds "
                f"{self.thresholds.shape} do not fit together"
            )
        if np.unique(self.folds).tolist() != list(range(len(self.thresholds))):
            raise RecogniserError(f"each of the {len(self.thresholds)} folds needs views, and each view one of them")
        if any(((array < 0.0) | (array > 1.0)).any() for array in (self.scores, self.thresholds)):
            raise RecogniserError("scores and thresholds are probabilities between 0 and 1")

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(S, T, K): whether the score reaches the threshold of the fold that judged the view."""
        return self.scores >= self.thresholds[self.folds][:, None, None]

    def save(self, path: Path | str) -> None:
        """Write everything to one .npz file, which appears whole or not at all."""
        metrics = json.dumps({name: asdict(measured) for name, measured in self.metrics.items()})
        arrays = {name: getattr(self, name) for name in ("scores", "boxes", "folds", "thresholds", "seconds")}
        with replacing(Path(path)) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, metrics=metrics, **arrays)

    @classmethod
    def load(cls, path: Path | str) -> CrossValidated:
        """Read what `save` wrote.

        Raises:
            RecogniserError: if the file is missing, damaged or something else.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                metrics = {name: _metrics_from(plain) for name, plain in json.loads(file["metrics"].item()).items()}
                arrays = {name: file[name] for name in ("scores", "boxes", "folds", "thresholds")}
                return cls(**arrays, metrics=metrics, seconds=float(file["seconds"]))
        except FileNotFoundError:
            raise RecogniserError(f"there is no {path}; cross-validate the recogniser first") from None
        # What a damaged archive makes numpy, zipfile, zlib and json say; a plain array has no names (IndexError) and
        # is no context (TypeError).
        except (
            OSError, EOFError, ValueError, LookupError, TypeError, AttributeError, NotImplementedError, zlib.error,
            zipfile.BadZipFile,
        ) as error:  # fmt: skip
            raise RecogniserError(
                f"{path} does not hold the detections of a cross-validation ({error}); delete it, it is made anew"
            ) from None


def cross_validate(
    scene: Scene,
    features: SceneFeatures,
    config: RecogniserConfig,
    folds: int = 5,
    progress: ProgressCallback = quiet,
) -> CrossValidated:
    """Judge every view of a scene by a recogniser that was trained without any view of its place.

    The places are dealt to folds of equal size, or one more. For each fold a recogniser is trained on the views of
    all others, with the pictures to train with, and then asks the fold's views for every target with every picture.

    Args:
        scene: with boxes and target pictures.
        features: of the scene.
        config: how each recogniser is trained. Its `held_out_places` means nothing here; its `seed` draws the folds
            too.
        folds: k, how many, 2 or more.
        progress: called after every update of any fold with the number of updates so far, the number of all, and a
            running mean of the fold's loss.

    Raises:
        RecogniserError: if there are fewer places than folds, the features are of another scene, or no target is
            visible in what a fold is trained on.
    """
    started = time.monotonic()
    fold_of_view = _deal(scene.positions, folds, config.seed)
    scores = np.empty((*features.view_maps.shape[:1], *features.target_maps.shape[:2]), np.float32)
    boxes = np.empty((*scores.shape, 4), np.float32)
    thresholds = np.empty(folds)
    for fold in range(folds):
        held_out = fold_of_view == fold
        trained = train_recogniser(
            [scene], [features], config, part_of(progress, fold * config.steps, folds * config.steps), [held_out]
        )
        with using_threads(config.threads):
            scores[held_out], boxes[held_out] = _detect(trained.network, features, held_out)
        thresholds[fold] = trained.threshold
    unmeasured = CrossValidated(scores, boxes, fold_of_view, thresholds, {}, 0.0)
    metrics = _measure_all(scene, unmeasured, config)
    return replace(unmeasured, metrics=metrics, seconds=time.monotonic() - started)


def _deal(places: NDArray[np.integer], folds: int, seed: int) -> NDArray[np.int64]:
    """The fold of each view; all views of a place, (S,) of them, are in one."""
    known, place_of_view = np.unique(places, return_inverse=True)
    if folds < 2:
        raise RecogniserError(f"cross-validation needs 2 folds or more, got {folds}: one to judge, the rest to learn")
    if len(known) < folds:
        raise RecogniserError(
            f"the scene has {len(known)} places, too few for {folds} folds; use at most one fold a place, or a "
            "larger scene"
        )
    return np.random.default_rng(seed).permutation(np.arange(len(known)) % folds)[place_of_view]


def _detect(
    network: RecogniserNetwork, features: SceneFeatures, views: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Like `detect_table` in some of the views; not through ONNX, the making of which takes longer than a look."""
    targets = features.target_maps
    asked = prepared(network.prepare_target, targets.reshape(-1, *targets.shape[2:]))
    logits, boxes = evaluate_pairs(network, prepared(network.prepare, features.view_maps[views]), asked)
    shape = (len(logits), *targets.shape[:2])
    return sigmoid(logits).reshape(shape), boxes.reshape(*shape, 4)


def _measure_all(scene: Scene, judged: CrossValidated, config: RecogniserConfig) -> dict[str, RecognitionMetrics]:
    """The metrics of all folds' views together."""
    data = Annotations.of([scene], config.smallest_area)
    everywhere = np.ones(len(scene), bool)
    split = Split.holding_out(data, ~everywhere, config.held_out_targets)
    threshold = float(judged.thresholds[judged.folds].mean())
    certain = judged.seen.astype(np.float32)
    metrics = {}
    for name, (targets, pictures) in queries(data, split).items():
        boxes = judged.boxes[:, targets, pictures]
        # Once for what depends on the order of the scores, once for what each fold makes of them.
        ranked, decided = (
            measure(scores[:, targets, pictures], boxes, data, everywhere, targets, threshold)
            for scores in (judged.scores, certain)
        )
        metrics[name] = _with_rates(ranked, decided)
    return metrics


def _with_rates(ranked: RecognitionMetrics, decided: RecognitionMetrics) -> RecognitionMetrics:
    return replace(
        ranked,
        recall=decided.recall,
        false_positive_rate=decided.false_positive_rate,
        per_target={name: _with_rates(part, decided.per_target[name]) for name, part in ranked.per_target.items()},
    )


def _metrics_from(plain: Mapping[str, Any]) -> RecognitionMetrics:
    parts = {name: _metrics_from(part) for name, part in plain["per_target"].items()}
    return RecognitionMetrics(**{**plain, "per_target": parts})
