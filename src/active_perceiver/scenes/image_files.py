"""The one place that opens encoded images: a list of formats, and limits that the head must keep to.

Pillow reads some fifty formats; one of them, EPS, is a program that it gives to Ghostscript. What comes from cameras,
telephones, web pages and labelling tools is read, nothing else. Of an animation or a file of several pages the first
picture is taken, and the others are never looked at.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from PIL import ExifTags, Image, UnidentifiedImageError, features
from PIL.TiffImagePlugin import TiffImageFile

from active_perceiver.errors import UserError

FORMATS = ("JPEG", "PNG", "WEBP", "BMP", "TIFF", "GIF", "PPM")
"""Read by every Pillow; AVIF and HEIF (of iPhones) as well where the libraries for them are there."""
MAX_PIXELS = 64_000_000
"""The largest cameras of telephones make 50 million by default; with transparency they take 1.4 GB while decoded."""
MAX_SIDE = 32_768
"""No camera makes longer sides, panoramas neither; a line of 100 000 000 pixels is a mistake or meant to do harm."""

_HEIF_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")
_AVIF_BRANDS = (b"avif", b"avis")


class ImageError(UserError, ValueError):
    """An image that cannot be read; the message says which and what to do."""


@dataclass(frozen=True)
class Upright:
    """Size of an image file with its EXIF rotation applied.

    Attributes:
        width: in pixels.
        height: in pixels.
        turned: whether the file's pixels lie otherwise.
    """

    width: int
    height: int
    turned: bool


@contextmanager
def open_image(source: bytes | Path, name: str) -> Iterator[Image.Image]:
    """An image of which only the head was read; what goes wrong in the block ends in a sentence as well.

    Args:
        source: an encoded image, or its file.
        name: what to call it in an error.

    Raises:
        ImageError: if it is broken, has too many pixels or is of a format that is not read.
    """
    formats: tuple[str, ...] = FORMATS
    try:
        formats = _formats(source, name)
        with Image.open(io.BytesIO(source) if isinstance(source, bytes) else source, formats=formats) as image:
            _check_size(image.width, image.height, name)
            yield image
    except ImageError:
        raise
    except UnidentifiedImageError:
        if formats != FORMATS:
            raise ImageError(
                f"{name} begins as {formats[0]} does, but is broken or truncated; save it as JPEG or PNG"
            ) from None
        raise ImageError(
            f"{name} is not an image that is read ({', '.join(FORMATS)}); save it as JPEG, PNG or WebP"
        ) from None
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise ImageError(f"{name} has more than {MAX_PIXELS / 1e6:.0f} million pixels; scale it down first") from None
    except MemoryError:
        raise ImageError(f"{name} does not fit into memory; scale it down first") from None
    # What Pillow raises for files that are damaged somewhere in the middle depends on where.
    except (OSError, SyntaxError, ValueError, struct.error) as error:
        raise ImageError(f"{name} is broken or truncated ({error}); save it again as JPEG or PNG") from None


def upright(source: bytes | Path, name: str = "") -> Upright:
    """Look at the head of an image.

    Args:
        source: an encoded image, or its file.
        name: what to call it in an error; a file by its path if not given.

    Raises:
        ImageError: see `open_image`.
    """
    with open_image(source, name or (str(source) if isinstance(source, Path) else "image")) as image:
        orientation = image.getexif().get(ExifTags.Base.Orientation, 1)
        width, height = image.size
        if isinstance(image, TiffImageFile):  # since some version its size is the upright one
            width, height = image.tag_v2[ExifTags.Base.ImageWidth], image.tag_v2[ExifTags.Base.ImageLength]
    if orientation in (5, 6, 7, 8):
        width, height = height, width
    return Upright(width, height, orientation in (2, 3, 4, 5, 6, 7, 8))


def _check_size(width: int, height: int, name: str) -> None:
    if width * height > MAX_PIXELS or max(width, height) > MAX_SIDE:
        raise ImageError(
            f"{name} has {width} x {height} pixels; {MAX_PIXELS / 1e6:.0f} million are read, and {MAX_SIDE} along a "
            "side: scale it down first"
        )


def _formats(source: bytes | Path, name: str) -> tuple[str, ...]:
    """The formats that Pillow is to try, by how the data begins: a file's name says little."""
    if isinstance(source, bytes):
        head = source[:64]
    else:
        with source.open("rb") as file:
            head = file.read(64)
    if head[4:8] != b"ftyp":
        return FORMATS
    brands = {head[8:12], *(head[place : place + 4] for place in range(16, len(head), 4))}
    if brands.intersection(_AVIF_BRANDS):
        if not features.check("avif"):
            raise ImageError(f"{name} is an AVIF image, which this Pillow cannot read; save it as JPEG, PNG or WebP")
        return ("AVIF",)
    if brands.intersection(_HEIF_BRANDS):
        try:
            from pillow_heif import register_heif_opener
        except ImportError:
            raise ImageError(
                f"{name} is a HEIC image, as iPhones make them, whatever its name says: pip install pillow-heif, or "
                "save it as JPEG"
            ) from None
        register_heif_opener()
        return ("HEIF",)
    return FORMATS
