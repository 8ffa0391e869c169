"""What may be different from training when an agent searches: the camera, the light, what lies where, the detections.

Changes of images and of detections are pure functions; what is random in them comes from a generator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.vision.image_changes import blurred, compressed, exposed, motion_blurred, pixel_noise

Image = NDArray[np.uint8]
Tables = tuple[NDArray[np.float32], NDArray[np.float32]]
ImageChange = Callable[[Image, np.random.Generator], Image]
DetectionChange = Callable[[NDArray[np.float32], NDArray[np.float32], float, np.random.Generator], Tables]


def missing(
    scores: NDArray[np.float32], boxes: NDArray[np.float32], threshold: float, rng: np.random.Generator, share: float
) -> Tables:
    """A share of the detections is not made.

    Args:
        scores: (S, T, K) presence probabilities in S views, for T targets asked for with K pictures.
        boxes: (S, T, K, 4) where they would be.
        threshold: score from which on a detection counts.
        rng: chooses the detections, each on its own.
        share: of the detections, 0..1.

    Returns:
        Scores and boxes, changed.
    """
    return np.where(rng.random(scores.shape) < share, np.float32(0), scores), boxes


def wrong(
    scores: NDArray[np.float32], boxes: NDArray[np.float32], threshold: float, rng: np.random.Generator, share: float
) -> Tables:
    """In a share of the views the target is seen where it was seen from another place, as surely and as large.

    Where a target is seen nowhere, nothing changes. Arguments and result: see `missing`.
    """
    scores, boxes = scores.copy(), boxes.copy()
    hit = rng.random(scores.shape) < share
    for target, picture in np.ndindex(scores.shape[1:]):
        seen = np.flatnonzero(scores[:, target, picture] >= threshold)
        views = np.flatnonzero(hit[:, target, picture])
        if len(seen):
            others = rng.choice(seen, len(views))
            scores[views, target, picture] = scores[others, target, picture]
            boxes[views, target, picture] = boxes[others, target, picture]
    return scores, boxes


@dataclass(frozen=True)
class Condition:
    """What is different from training; as in training where all is None.

    Attributes:
        meaning: one line for people.
        image: what happens to each view.
        detections: what happens to what the recogniser says.
        hour: the room is rendered again at this hour of the day.
        moved: the room is rendered again with this other arrangement of the things in it.
        file: the scene file of the room as it is instead.
        same_boxes: whether the room in that file has to have the same poses and boxes.
    """

    meaning: str
    image: ImageChange | None = None
    detections: DetectionChange | None = None
    hour: str | None = None
    moved: int | None = None
    file: Path | None = None
    same_boxes: bool = False


CLEAN = "as trained"

CONDITIONS: dict[str, Condition] = {
    CLEAN: Condition("nothing is different"),
    "noise 10": Condition("sensor noise, sigma 10 of 255", partial(pixel_noise, sigma=10.0)),
    "noise 25": Condition("sensor noise, sigma 25 of 255", partial(pixel_noise, sigma=25.0)),
    "blur 1": Condition("Gaussian blur, sigma 1 pixel", partial(blurred, sigma=1.0)),
    "blur 2": Condition("Gaussian blur, sigma 2 pixels", partial(blurred, sigma=2.0)),
    "motion blur 9": Condition("averaged over 9 pixels sideways", partial(motion_blurred, length=9)),
    "darker": Condition("half the light", partial(exposed, gains=(0.5, 0.5, 0.5))),
    "brighter": Condition("twice the light", partial(exposed, gains=(2.0, 2.0, 2.0))),
    "warm cast": Condition("1.3 times the red, 0.7 times the blue light", partial(exposed, gains=(1.3, 1.0, 0.7))),
    "cold cast": Condition("0.7 times the red, 1.3 times the blue light", partial(exposed, gains=(0.7, 1.0, 1.3))),
    "JPEG 20": Condition("JPEG of quality 20", partial(compressed, quality=20)),
    "noon": Condition("the room at noon", hour="noon"),
    "dusk": Condition("the room at dusk, lamps on", hour="dusk"),
    "moved 1": Condition("the same things lie elsewhere", moved=1),
    "moved 2": Condition("the same things lie elsewhere again", moved=2),
    "missing 10 %": Condition("1 of 10 detections is not made", detections=partial(missing, share=0.1)),
    "missing 30 %": Condition("3 of 10 detections are not made", detections=partial(missing, share=0.3)),
    "wrong 10 %": Condition("in 1 of 10 views a box of another place", detections=partial(wrong, share=0.1)),
    "wrong 30 %": Condition("in 3 of 10 views a box of another place", detections=partial(wrong, share=0.3)),
}
