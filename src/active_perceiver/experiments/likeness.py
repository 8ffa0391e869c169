"""How alike a picture must be to those of a known target for an agent to take it for one of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from active_perceiver.experiments.sightings import Sightings
from active_perceiver.policies.restless import unit_vectors
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.vision.cache import SceneFeatures


def known_similarity(sightings: Sequence[Sightings], strangers: Sequence[NDArray[np.float32]]) -> float:
    """The cosine similarity of codes from which on a picture counts as one of a known target.

    It lies between what the most unlike picture of any target is to its nearest other picture, and what the most
    alike picture of something else is to one of a target; nearer to the latter, for a picture that was not trained
    with is less like the others than they are like each other.

    Args:
        sightings: in each scene.
        strangers: for each scene the (N, C) codes of pictures of what else is in it.
    """
    least, most = 1.0, -1.0
    for seen, others in zip(sightings, strangers, strict=True):
        known = unit_vectors(seen.target_codes[:, : seen.trained])
        for number, codes in enumerate(known):
            likeness = codes @ codes.T
            np.fill_diagonal(likeness, -1.0)
            least = min(least, float(likeness.max(axis=1).min())) if len(codes) > 1 else least
            other_targets = np.delete(known, number, axis=0).reshape(-1, codes.shape[1])
            unlike = np.concatenate([other_targets, unit_vectors(others)])
            most = max(most, float((unlike @ codes.T).max(initial=-1.0)))
    # Where nothing else is known, or it cannot be told apart, only what is nearly the same counts.
    return most + (least - most) / 3 if -1.0 < most < least else 0.97 * least


def strangers_codes(
    sightings: Sequence[Sightings], features: Sequence[SceneFeatures], recogniser: Recogniser
) -> list[NDArray[np.float32]]:
    """What pictures of the other things in each scene are like: those to train with, of targets not looked for.

    Args:
        sightings: in each scene.
        features: of the scenes.
        recogniser: of the sightings.

    Returns:
        For each scene the (N, C) codes.
    """
    codes = []
    for seen, its_features in zip(sightings, features, strict=True):
        others = np.delete(np.arange(len(seen.scene.targets)), seen.targets)
        maps = [its_features.target_maps[other, : seen.scene.targets[other].trained] for other in others]
        codes.append(recogniser.encode_target(np.concatenate([its_features.target_maps[0, :0], *maps])))
    return codes
