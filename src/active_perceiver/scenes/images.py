"""Reading and writing single images: what a user has, as the RGB array the software works on."""

from __future__ import annotations

import io
import math
import threading
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from active_perceiver.scenes.image_files import ImageError, open_image
from active_perceiver.scenes.image_modes import as_rgb

# Images of more pixels are decoded one at a time, so that a page of thumbnails cannot fill the memory.
_LARGE, _ONE_AT_A_TIME = 8_000_000, threading.Lock()
# Modes whose pixels can be averaged; numbers of a palette cannot, and Pillow cannot average 16 bits.
_REDUCIBLE = ("L", "LA", "RGB", "RGBA", "CMYK", "YCbCr")


def decode_image(data: bytes, name: str = "image", side: int | None = None) -> NDArray[np.uint8]:
    """Decode an encoded image of any mode as upright RGB.

    EXIF rotation is applied, transparency is laid on light grey, grey and palette images become RGB, more than 8
    bits are scaled to 8 by the range of the numbers; of an animation the first picture is taken.

    Args:
        data: an encoded image of one of `image_files.FORMATS`, AVIF or HEIC.
        name: what to call it in an error.
        side: of the square that `square_image` will fit it into. A JPEG at least twice as large is decoded at a
            half, a quarter or an eighth of its size, but no smaller than it will be; this is many times faster.
            Other images are made smaller, to save memory, if they have more than 8 million pixels.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ImageError: if the data is not a readable image, is too large or of another format.
    """
    with open_image(data, name) as image:
        if side is not None:
            scale = side / max(image.size)
            image.draft(None, (math.floor(image.width * scale) or 1, math.floor(image.height * scale) or 1))
        if image.width * image.height <= _LARGE:
            return _decoded(image, name)
        with _ONE_AT_A_TIME:
            return _decoded(image, name, side)


def _decoded(image: Image.Image, name: str, side: int | None = None) -> NDArray[np.uint8]:
    """The pixels, upright; if a side is given, of an image that is whole times smaller but not smaller than that."""
    ImageOps.exif_transpose(image, in_place=True)
    factor = max(image.size) // side if side is not None and image.mode in _REDUCIBLE else 1
    shown = image.reduce(factor) if factor > 1 else image
    try:
        return np.asarray(as_rgb(shown, name))
    finally:
        image.close()  # its pixels as well, before the next large one is decoded


def read_image(path: Path | str) -> NDArray[np.uint8]:
    """Read an image file as upright RGB, (H, W, 3) uint8.

    Raises:
        ImageError: if the file is missing, is a folder or is not a readable image.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise ImageError(f"there is no file {path}; give the path of a picture of the object") from None
    except OSError as error:
        raise ImageError(f"{path} cannot be read: {error.strerror}") from None
    return decode_image(data, str(path))


def encode_image(image: NDArray[np.uint8], kind: str = "webp", quality: int = 88) -> bytes:
    """Encode an (H, W, 3) uint8 RGB image as `kind` ("webp", "jpeg" or "png")."""
    out = io.BytesIO()
    options = {"webp": {"quality": quality, "method": 6}, "jpeg": {"quality": quality}, "png": {}}[kind]
    Image.fromarray(image).save(out, kind.upper(), **options)
    return out.getvalue()


def image_suffix(data: bytes) -> str:
    """The file name suffix that suits an encoded image: "webp", "jpg" or "png".

    Raises:
        ImageError: if the data is none of these.
    """
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return "webp"
    if data[:3] == b"\xff\xd8\xff":
        return "jpg"
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return "png"
    raise ImageError("the image is neither WebP nor JPEG nor PNG; save it as one of them")


def square_image(image: NDArray[np.uint8], size: int) -> NDArray[np.uint8]:
    """Fit an image into a square of `size` pixels, keeping its proportions.

    The shorter side is padded with the median colour of the image's border, so that a product picture of any
    shape stays an object on a plain background.

    Args:
        image: (H, W, 3) uint8 RGB.
        size: side of the result in pixels.

    Returns:
        (size, size, 3) uint8.
    """
    height, width = image.shape[:2]
    if (height, width) == (size, size):
        return image
    scale = size / max(height, width)
    fitted, margin = _fitted(width, height, size)
    # For making smaller, bilinear is nearly twice as fast, and what the backbone makes of the result differs less
    # than between JPEG qualities.
    filtered = Image.Resampling.BILINEAR if scale < 1 else Image.Resampling.BICUBIC
    resized = Image.fromarray(image).resize(fitted, filtered, reducing_gap=3.0)
    border = np.concatenate([image[0], image[-1], image[:, 0], image[:, -1]])
    red, green, blue = (int(value) for value in np.median(border, axis=0))
    square = Image.new("RGB", (size, size), (red, green, blue))
    square.paste(resized, margin)
    return np.asarray(square)


def boxes_in_square(boxes: NDArray[np.floating], width: int, height: int, size: int) -> NDArray[np.float32]:
    """Boxes in an image as boxes in the square that `square_image` makes of it.

    Args:
        boxes: (..., 4) centre x, centre y, width, height as fractions of the image; NaN stays NaN.
        width: of the image in pixels.
        height: of the image in pixels.
        size: side of the square in pixels.

    Returns:
        (..., 4) float32, the same as fractions of the square.
    """
    fitted, margin = (np.array(pair) for pair in _fitted(width, height, size))
    centre = (margin + boxes[..., :2] * fitted) / size
    return np.concatenate([centre, boxes[..., 2:] * fitted / size], axis=-1).astype(np.float32)


def _fitted(width: int, height: int, size: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """Width and height of an image that fits into a square, and the pixels to its left and above it there."""
    scale = size / max(height, width)
    across, down = max(1, round(width * scale)), max(1, round(height * scale))
    return (across, down), ((size - across) // 2, (size - down) // 2)
