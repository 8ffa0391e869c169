"""How alike a picture must be to those of a known target for an agent to take it for one of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from active_perceiver.evaluation.detections import DetectionTable
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.utils.linalg import unit_vectors
from active_perceiver.vision.cache import SceneFeatures


def match_threshold(detections: Sequence[DetectionTable], distractors: Sequence[NDArray[np.float32]]) -> float:
    """The cosine similarity of codes from which on a picture counts as one of a known target.

    It lies between what the most unlike picture of any target is to its nearest other picture, and what the most
    alike picture of something else is to one of a target; nearer to the latter, for a picture that was not trained
    with is less like the others than they are like each other.

    Args:
        detections: in each scene.
        distractors: for each scene the (N, C) codes of pictures of what else is in it.
    """
    least, most = 1.0, -1.0
    for seen, others in zip(detections, distractors, strict=True):
        known = unit_vectors(seen.target_embeddings[:, : seen.trained])
        for number, embeddings in enumerate(known):
            likeness = embeddings @ embeddings.T
            np.fill_diagonal(likeness, -1.0)
            least = min(least, float(likeness.max(axis=1).min())) if len(embeddings) > 1 else least
            other_targets = np.delete(known, number, axis=0).reshape(-1, embeddings.shape[1])
            unlike = np.concatenate([other_targets, unit_vectors(others)])
            most = max(most, float((unlike @ embeddings.T).max(initial=-1.0)))
    # Where nothing else is known, or it cannot be told apart, only what is nearly the same counts.
    return most + (least - most) / 3 if -1.0 < most < least else 0.97 * least


def distractor_embeddings(
    detections: Sequence[DetectionTable], features: Sequence[SceneFeatures], recogniser: Recogniser
) -> list[NDArray[np.float32]]:
    """What pictures of the other things in each scene are like: those to train with, of targets not looked for.

    Args:
        detections: in each scene.
        features: of the scenes.
        recogniser: of the sightings.

    Returns:
        For each scene the (N, C) codes.
    """
    embeddings = []
    for seen, its_features in zip(detections, features, strict=True):
        others = np.delete(np.arange(len(seen.scene.targets)), seen.targets)
        maps = [its_features.target_maps[other, : seen.scene.targets[other].trained] for other in others]
        embeddings.append(recogniser.encode_target(np.concatenate([its_features.target_maps[0, :0], *maps])))
    return embeddings
