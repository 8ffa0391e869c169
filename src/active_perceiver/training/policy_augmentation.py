"""What an agent sees with a worse camera, in other light or a little off the lattice, to train its policy on as well.

A policy knows a room's views by heart, and a little noise or blur, or a robot that stands a hand's breadth aside,
makes them other views. Having been shown a few changed copies of them too, it takes them for what they are
(docs/benchmarks/robustness.md, docs/benchmarks/robot.md).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.observations import Observations
from active_perceiver.evaluation.detections import DetectionTable, detect_images
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.utils.progress import progress_bar
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.image_changes import photometric
from active_perceiver.vision.viewpoint_changes import from_nearby


def changed_view(image: NDArray[np.uint8], rng: np.random.Generator, degrees: float, fov: float) -> NDArray[np.uint8]:
    """A view as another camera in other light and from near by would show it.

    Args:
        image: (H, W, 3) uint8 RGB.
        rng: draws what is changed.
        degrees: the camera looks up to so much aside, see `from_nearby`; 0 to stay on the lattice.
        fov: field of view in degrees.
    """
    return photometric(from_nearby(image, rng, degrees, fov) if degrees else image, rng)


def changed_observations(
    seen: DetectionTable,
    backbone: Backbone,
    recogniser: Recogniser,
    threshold: float,
    copies: int,
    degrees: float,
    seed: int,
) -> tuple[Observations, ...]:
    """What a policy is shown in a scene each view of which is changed, see `changed_view`.

    Args:
        seen: the recogniser's tables of the scene as it is; searches use its pictures to train with.
        backbone: the recogniser's.
        recogniser: looks at the changed views.
        threshold: presence probability from which on a detection counts.
        copies: how many times all views are changed, and looked at, anew.
        degrees: see `changed_view`.
        seed: draws the changes.
    """
    scene, trained = seen.scene, seen.trained_pictures
    result = []
    for number in range(copies):
        images = (
            changed_view(scene.view(state), np.random.default_rng([seed, number, state]), degrees, scene.fov)
            for state in range(len(scene))
        )
        with progress_bar(f"changed views of {scene.name}") as report:
            features, scores, boxes = detect_images(
                images, len(scene), backbone, recogniser, seen.target_embeddings[:, trained], report
            )
        targets = seen.target_features[:, trained]
        result.append(Observations.from_detections(features, targets, scores, boxes, threshold))
    return tuple(result)
