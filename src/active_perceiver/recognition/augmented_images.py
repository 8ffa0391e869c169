"""Changed copies of views and of target pictures, so that a recogniser learns what does not matter. Pure functions.

Light, colours, sharpness and framing of an image are changed as another camera, another hour or another step of the
robot would change them. A view's own objects also serve as target pictures: that is how an object looks when it is
photographed where it stands.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from active_perceiver.scenes.images import square_image
from active_perceiver.vision.image_changes import photometric


def window(
    image: NDArray[np.uint8], left: float, top: float, side: float, size: int, *, mirrored: bool
) -> NDArray[np.uint8]:
    """A square part of an image, scaled; where it reaches beyond the image, the image's edge goes on.

    Args:
        image: (H, W, 3) uint8.
        left: of the part, in pixels; may be negative.
        top: of the part, in pixels; may be negative.
        side: of the part, in pixels.
        size: side of the result in pixels.
        mirrored: whether left and right are exchanged.

    Returns:
        (size, size, 3) uint8.
    """
    beyond = max(-left, -top, left + side - image.shape[1], top + side - image.shape[0])
    margin = math.ceil(beyond) + 1 if beyond > 0 else 0
    if margin:
        image = np.pad(image, ((margin, margin), (margin, margin), (0, 0)), mode="edge")
    box = (left + margin, top + margin, left + margin + side, top + margin + side)
    part = np.asarray(Image.fromarray(image).resize((size, size), Image.Resampling.BICUBIC, box))
    return np.ascontiguousarray(part[:, ::-1]) if mirrored else part


def changed_view(
    image: NDArray[np.uint8], boxes: NDArray[np.floating], size: int, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.float32]]:
    """A view as from a little nearer, in other light, mirrored half of the time.

    Args:
        image: (H, W, 3) uint8 RGB.
        boxes: (T, 4) of the targets, as fractions of the square that the image is fitted into; NaN if not visible.
        size: side of the result in pixels.
        rng: draws the changes.

    Returns:
        (size, size, 3) uint8; (T, 4) float32 boxes in it, cut at its edges; (T,) float32: how much of each target's
        box is in it, 0..1. NaN for targets that are not visible; a box of which nothing is in it is empty.
    """
    side = rng.uniform(0.75, 1.0)
    corner = rng.uniform(0.0, 1.0 - side, 2)
    mirrored = rng.random() < 0.5
    whole = square_image(image, size)
    left, top = corner * size
    part = window(whole, left, top, side * size, size, mirrored=mirrored)
    low, high = (np.clip((boxes[:, :2] + sign * boxes[:, 2:] / 2 - corner) / side, 0.0, 1.0) for sign in (-1, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        kept = (high - low).prod(axis=1) * side**2 / boxes[:, 2:].prod(axis=1)
    if mirrored:
        low[:, 0], high[:, 0] = 1.0 - high[:, 0], 1.0 - low[:, 0]
    inside = np.concatenate([(low + high) / 2, high - low], axis=1).astype(np.float32)
    return photometric(part, rng), inside, np.clip(kept, 0.0, 1.0).astype(np.float32)


def changed_picture(image: NDArray[np.uint8], size: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    """A target picture taken from nearer or from farther off, not quite centred, in other light, perhaps mirrored.

    Args:
        image: (H, W, 3) uint8 RGB.
        size: side of the result in pixels.
        rng: draws the changes.
    """
    side = size * rng.uniform(0.7, 1.5)
    left, top = size / 2 + rng.normal(0.0, 0.06 * size, 2) - side / 2
    part = window(square_image(image, size), left, top, side, size, mirrored=rng.random() < 0.5)
    return photometric(part, rng)


def picture_from_view(
    image: NDArray[np.uint8], box: NDArray[np.floating], size: int, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """A target picture cut out of a view, with what lies around the object.

    Args:
        image: (H, W, 3) uint8 RGB.
        box: (4,) of the object, as fractions of the square that the image is fitted into.
        size: side of the result in pixels.
        rng: draws how much lies around it, and the changes of light.
    """
    side = size * float(box[2:].max()) * rng.uniform(1.25, 2.2)
    left, top = box[:2] * size + rng.normal(0.0, 0.06 * side, 2) - side / 2
    part = window(square_image(image, size), left, top, side, size, mirrored=rng.random() < 0.5)
    return photometric(part, rng)
