"""What an agent sees everywhere in a scene: its detections in all views, for all targets and their pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.observations import Observations
from active_perceiver.recognition.recogniser import Recogniser, detect_table
from active_perceiver.scenes import Scene, Target
from active_perceiver.utils.prefetch import prefetch_batches
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet
from active_perceiver.vision.backbone import BATCH, Backbone, pooled
from active_perceiver.vision.cache import SceneFeatures


@dataclass(frozen=True, eq=False)
class DetectionTable:
    """The detections of one recogniser in one scene, with the features they came from.

    Attributes:
        scene: where.
        targets: (T,) indices of the scene's targets that were looked for.
        trained: the first so many of the K pictures may be trained with, the others never are.
        view_features: (S, D) float32.
        target_features: (T, K, D) float32.
        target_embeddings: (T, K, C) float32, the recogniser's codes of the pictures.
        scores: (S, T, K) presence probabilities, asked for with each of K pictures.
        boxes: (S, T, K, 4) where the target would be.
    """

    scene: Scene
    targets: NDArray[np.int64]
    trained: int
    view_features: NDArray[np.float32]
    target_features: NDArray[np.float32]
    target_embeddings: NDArray[np.float32]
    scores: NDArray[np.float32]
    boxes: NDArray[np.float32]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the targets."""
        return tuple(self.scene.target_names[index] for index in self.targets)

    @property
    def trained_pictures(self) -> list[int]:
        """Numbers of the pictures that training uses."""
        return list(range(self.trained))

    @property
    def held_out_pictures(self) -> list[int]:
        """Numbers of the pictures that training never sees; none if the scene holds none out."""
        return list(range(self.trained, self.scores.shape[2]))

    def observations(self, threshold: float, pictures: Sequence[int]) -> Observations:
        """What a policy is shown when searches use these pictures."""
        chosen = list(pictures)
        return Observations.from_detections(
            self.view_features,
            self.target_features[:, chosen],
            self.scores[:, :, chosen],
            self.boxes[:, :, chosen],
            threshold,
        )


def detect_all_views(
    scene: Scene, features: SceneFeatures, recogniser: Recogniser, names: Sequence[str] = ()
) -> DetectionTable:
    """Look for targets in all views of a scene, with a progress bar.

    Args:
        scene: where.
        features: of that scene.
        recogniser: looks.
        names: of the targets; all of the scene's if empty.

    Raises:
        SceneError: if the scene has no such target.
    """
    targets = np.array([scene.target_index(name) for name in names or scene.target_names])
    pictures, trained = even_pictures([scene.targets[target] for target in targets])
    wanted = (targets[:, None], pictures)
    chosen = replace(
        features,
        target_maps=features.target_maps[wanted],
        target_features=features.target_features[wanted],
        picture_counts=np.full(len(targets), pictures.shape[1]),
    )
    with progress_bar(f"looking in {scene.name}") as report:
        scores, boxes = detect_table(recogniser, chosen, progress=report)
    embeddings = np.stack([recogniser.encode_target(maps) for maps in chosen.target_maps])
    return DetectionTable(
        scene, targets, trained, features.view_features, chosen.target_features, embeddings, scores, boxes
    )


def detect_images(
    images: Iterable[NDArray[np.uint8]],
    count: int,
    backbone: Backbone,
    recogniser: Recogniser,
    embeddings: NDArray[np.float32],
    progress: ProgressCallback = quiet,
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Look for targets in images that are in no cache, as `ActivePerceiver.act` does.

    Args:
        images: `count` of them, (H, W, 3) uint8 RGB.
        count: N, how many.
        backbone: the recogniser's.
        recogniser: looks.
        embeddings: (T, K, C) of the pictures that targets are asked for with.
        progress: called with the number of images done and of all.

    Returns:
        (N, D) float32 features, (N, T, K) float32 presence probabilities, (N, T, K, 4) float32 boxes.
    """
    features = np.empty((count, backbone.channels), np.float32)
    scores = np.empty((count, *embeddings.shape[:2]), np.float32)
    boxes = np.empty((*scores.shape, 4), np.float32)
    flat, done = embeddings.reshape(-1, embeddings.shape[2]), 0
    for batch in prefetch_batches(images, BATCH):
        maps = backbone.maps(batch)
        features[done : done + len(maps)] = pooled(maps)
        for number, one in enumerate(maps, done):  # all pictures with one view are enough at a time
            probabilities, places = recogniser.detect_many(one[None], flat)
            scores[number], boxes[number] = probabilities.reshape(scores.shape[1:]), places.reshape(boxes.shape[1:])
        done += len(maps)
        progress(done, count)
    return features, scores, boxes


def even_pictures(targets: Sequence[Target]) -> tuple[NDArray[np.int64], int]:
    """Numbers of pictures of some targets such that all have equally many of each side of the split.

    Where a target has more pictures to train with, or more that are held out, than another, its further ones of that
    side are left out; none changes sides.

    Returns:
        (T, K) numbers of each target's pictures, and how many of the K, the first ones, may be trained with.
    """
    trained = min(target.trained for target in targets)
    held_out = min(target.held_out for target in targets)
    rows = [[*range(trained), *range(target.trained, target.trained + held_out)] for target in targets]
    return np.array(rows, np.int64), trained
