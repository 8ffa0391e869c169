"""From whatever an image's pixels are to 8-bit RGB, so that it still looks like itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from active_perceiver.scenes.image_files import ImageError

# Transparent pictures are laid on the light grey that bundled target pictures have as background.
TRANSPARENT_BACKGROUND = (225, 225, 225)
# Whole numbers of more than 8 bits do not say how many there are; cameras give 8, 10, 12 or all 16. The smallest that
# holds the brightest pixel is taken: a picture of 16 bits whose brightest is below 4096 would be all but black.
_WHITES = (255, 1023, 4095, 65535)


def as_rgb(image: Image.Image, name: str) -> Image.Image:
    """An image of any mode as RGB: transparency is laid on light grey, more than 8 bits are scaled.

    Args:
        image: upright.
        name: what to call it in an error.

    Raises:
        ImageError: if there is no telling what its numbers mean.
    """
    if image.mode.startswith("I"):
        image = Image.fromarray(_of_whole_numbers(np.asarray(image), name))
    elif image.mode == "F":
        image = Image.fromarray(_of_fractions(np.asarray(image), name))
    if image.mode in ("LAB", "HSV"):
        raise ImageError(f"{name} has colours of kind {image.mode}; save it as RGB")
    if image.has_transparency_data:
        image = image if image.mode == "RGBA" else image.convert("RGBA")
        ground = Image.new("RGBA", image.size, (*TRANSPARENT_BACKGROUND, 255))
        image = Image.alpha_composite(ground, image)
    return image if image.mode == "RGB" else image.convert("RGB")


def _of_whole_numbers(values: NDArray[np.integer], name: str) -> NDArray[np.uint8]:
    lowest, highest = int(values.min()), int(values.max())
    if lowest < 0 or highest > _WHITES[-1]:
        raise ImageError(
            f"{name} holds numbers from {lowest} to {highest}, not 0 to {_WHITES[-1]}; save it with 8 bits"
        )
    white = next(white for white in _WHITES if highest <= white)
    return _scaled(values, 255.0 / white)


def _of_fractions(values: NDArray[np.floating], name: str) -> NDArray[np.uint8]:
    lowest, highest = float(values.min()), float(values.max())
    # What is a little above 1 is a fraction that was sharpened, but what then is 2, or 200?
    if lowest < 0 or not (highest <= 1 or 2 < highest <= 255):
        raise ImageError(
            f"{name} holds numbers from {lowest:g} to {highest:g}, neither 0 to 1 nor 0 to 255; save it with 8 bits"
        )
    return _scaled(values, 255.0 if highest <= 1 else 1.0)


def _scaled(values: NDArray[np.number], factor: float) -> NDArray[np.uint8]:
    return np.rint(values * np.float32(factor)).clip(0, 255).astype(np.uint8)
