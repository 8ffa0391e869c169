"""Photographs and pictures of targets as files: upright, as squares."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from active_perceiver.scenes.image_files import ImageError, Upright, upright
from active_perceiver.scenes.images import decode_image, encode_image, image_suffix, square_image

IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff", ".heic", ".heif")
"""Files taken for images. Those that cannot be read end in an error that says so, rather than being left out."""
# Pictures of targets larger than that are made smaller; no backbone looks at more.
_LARGEST_PICTURE = 640


def square_view(path: Path, photograph: Upright, size: int) -> bytes:
    """A photograph as an encoded square of `size` pixels, padded in the middle; one that is that already is kept.

    Raises:
        ImageError: if it is not a readable image.
    """
    data = path.read_bytes()
    image = decode_image(data, str(path), side=size)
    if (photograph.width, photograph.height) == (size, size) and not photograph.turned and _storable(data):
        return data
    return encode_image(square_image(image, size))


def read_target(paths: Sequence[Path]) -> tuple[bytes, ...]:
    """Pictures of a target, encoded and not larger than needed; small ones are kept as they are.

    Raises:
        ImageError: if one is not a readable image.
    """
    return tuple(_picture(path) for path in paths)


def _picture(path: Path) -> bytes:
    seen, data = upright(path), path.read_bytes()
    image = decode_image(data, str(path))
    largest = max(seen.width, seen.height)
    if largest > _LARGEST_PICTURE:
        scale = _LARGEST_PICTURE / largest
        size = max(1, round(seen.width * scale)), max(1, round(seen.height * scale))
        image = np.asarray(Image.fromarray(image).resize(size, Image.Resampling.LANCZOS, reducing_gap=3.0))
    elif not seen.turned and _storable(data):
        return data
    return encode_image(image)


def _storable(data: bytes) -> bool:
    """Whether a scene file can hold these bytes."""
    try:
        image_suffix(data)
    except ImageError:
        return False
    return True
