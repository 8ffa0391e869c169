"""What an agent sees everywhere in a scene: its detections in all views, for all targets and their pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.progress import progress_bar
from active_perceiver.recognition.recogniser import Recogniser, detect_table
from active_perceiver.scenes import Scene
from active_perceiver.search.observations import Observations
from active_perceiver.vision.cache import SceneFeatures


@dataclass(frozen=True, eq=False)
class Sightings:
    """The detections of one recogniser in one scene, with the features they came from.

    Attributes:
        scene: where.
        targets: (T,) indices of the scene's targets that were looked for.
        view_features: (S, D) float32.
        target_features: (T, K, D) float32.
        target_codes: (T, K, C) float32, the recogniser's codes of the pictures.
        scores: (S, T, K) presence probabilities, asked for with each of K pictures.
        boxes: (S, T, K, 4) where the target would be.
    """

    scene: Scene
    targets: NDArray[np.int64]
    view_features: NDArray[np.float32]
    target_features: NDArray[np.float32]
    target_codes: NDArray[np.float32]
    scores: NDArray[np.float32]
    boxes: NDArray[np.float32]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the targets."""
        return tuple(self.scene.target_names[index] for index in self.targets)

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


def see_everywhere(
    scene: Scene, features: SceneFeatures, recogniser: Recogniser, names: Sequence[str] = ()
) -> Sightings:
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
    with progress_bar(f"looking in {scene.name}") as report:
        scores, boxes = detect_table(recogniser, features, targets, report)
    codes = np.stack([recogniser.encode_target(features.target_maps[target]) for target in targets])
    pictures = features.target_features[targets]
    return Sightings(scene, targets, features.view_features, pictures, codes, scores, boxes)


def picture_split(pictures: int, held_out: int) -> tuple[list[int], list[int]]:
    """Numbers of the pictures that training uses, and of the last ones, which it never sees."""
    return list(range(pictures - held_out)), list(range(pictures - held_out, pictures))
