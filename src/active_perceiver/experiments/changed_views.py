"""What an agent sees when its camera or the light is worse, to train its policy on as well.

A policy knows a room's views by heart, and a little noise or blur makes them other views. Having been shown a few
changed copies of them too, it takes them for what they are (docs/benchmarks/robustness.md).
"""

from __future__ import annotations

import numpy as np

from active_perceiver.experiments.sightings import Sightings, look_at
from active_perceiver.progress import progress_bar
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.search.observations import Observations
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.image_changes import photometric


def changed_observations(
    seen: Sightings, backbone: Backbone, recogniser: Recogniser, threshold: float, copies: int, seed: int
) -> tuple[Observations, ...]:
    """What a policy is shown in a scene each view of which is photometrically changed, see `photometric`.

    Args:
        seen: the recogniser's tables of the scene as it is; searches use its pictures to train with.
        backbone: the recogniser's.
        recogniser: looks at the changed views.
        threshold: presence probability from which on a detection counts.
        copies: how many times all views are changed, and looked at, anew.
        seed: draws the changes.
    """
    scene, trained = seen.scene, seen.trained_pictures
    result = []
    for number in range(copies):
        images = (
            photometric(scene.view(state), np.random.default_rng([seed, number, state]))
            for state in range(len(scene))
        )
        with progress_bar(f"changed views of {scene.name}") as report:
            features, scores, boxes = look_at(
                images, len(scene), backbone, recogniser, seen.target_codes[:, trained], report
            )
        targets = seen.target_features[:, trained]
        result.append(Observations.from_detections(features, targets, scores, boxes, threshold))
    return tuple(result)
