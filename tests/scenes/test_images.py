"""Pictures as users have them: every mode, turned, broken."""

import io

import numpy as np
import pytest
from PIL import Image

from active_perceiver.scenes import ImageError, decode_image, read_image
from active_perceiver.scenes.images import TRANSPARENT_BACKGROUND, encode_image, square_image


def encoded(image: Image.Image, kind: str = "PNG", **options) -> bytes:
    out = io.BytesIO()
    image.save(out, kind, **options)
    return out.getvalue()


@pytest.fixture
def picture() -> Image.Image:
    pixels = np.full((20, 30, 3), 200, np.uint8)
    pixels[:10, :10] = (250, 10, 20)
    return Image.fromarray(pixels)


def test_transparency_is_laid_on_grey(picture):
    picture.putalpha(0)
    assert (decode_image(encoded(picture)) == TRANSPARENT_BACKGROUND).all()


@pytest.mark.parametrize("mode", ["L", "P", "1", "CMYK", "LA", "I;16"])
def test_every_mode_becomes_rgb(picture, mode):
    image = picture.convert("L").convert("I;16") if mode == "I;16" else picture.convert(mode)
    kind = "JPEG" if mode == "CMYK" else "PNG"
    decoded = decode_image(encoded(image, kind))
    assert decoded.shape == (20, 30, 3)
    assert decoded.dtype == np.uint8


def test_sixteen_bit_greys_keep_their_brightness():
    deep = Image.fromarray(np.full((4, 4), 40000, np.uint16))
    assert abs(int(decode_image(encoded(deep))[0, 0, 0]) - 40000 // 257) <= 1


def test_exif_rotation_is_applied(picture):
    exif = Image.Exif()
    exif[274] = 6  # turn by 90 degrees clockwise to see it upright
    turned = decode_image(encoded(picture, "JPEG", exif=exif, quality=95))
    assert turned.shape == (30, 20, 3)
    assert turned[3, -3, 0] > 220
    assert turned[3, -3, 1] < 60


@pytest.mark.parametrize("data", [b"", b"not an image", None])
def test_broken_data_is_an_image_error(picture, data):
    data = encoded(picture)[:60] if data is None else data
    with pytest.raises(ImageError, match="photo"):
        decode_image(data, "photo")


def test_missing_files_and_folders_are_image_errors(tmp_path):
    with pytest.raises(ImageError, match="there is no file"):
        read_image(tmp_path / "none.png")
    with pytest.raises(ImageError, match="cannot be read"):
        read_image(tmp_path)


@pytest.mark.parametrize("shape", [(20, 30), (30, 20), (1, 500), (64, 64), (300, 300)])
def test_square_keeps_proportions_and_pads_with_the_border(shape):
    image = np.full((*shape, 3), 90, np.uint8)
    square = square_image(image, 64)
    assert square.shape == (64, 64, 3)
    assert (square == 90).all()


def test_square_keeps_a_round_thing_round():
    down, across = np.mgrid[:100, :200]
    image = np.full((100, 200, 3), 255, np.uint8)
    image[(down - 50) ** 2 + (across - 100) ** 2 < 30**2] = 0
    dark = square_image(image, 100)[..., 0] < 128
    assert abs(np.ptp(np.flatnonzero(dark.any(0))) - np.ptp(np.flatnonzero(dark.any(1)))) <= 1


@pytest.mark.parametrize("kind", ["png", "webp", "jpeg"])
def test_encode_then_decode(kind):
    image = np.random.default_rng(0).integers(100, 140, (32, 32, 3)).astype(np.uint8)
    decoded = decode_image(encode_image(image, kind))
    assert np.abs(decoded.astype(int) - image).mean() < (0.1 if kind == "png" else 12)


def test_a_large_jpeg_is_decoded_small_for_a_small_square():
    """By a whole factor and no smaller than it will be; what comes out is what decoding all of it gives."""
    down, across = np.mgrid[:240, :320] / 40
    image = (127 + 60 * np.stack([np.sin(down), np.cos(across), np.sin(down + across)], -1)).astype(np.uint8)
    data = encode_image(image, "jpeg", 95)
    shapes = {side: decode_image(data, side=side).shape for side in (400, 320, 161, 160, 100, 80, 40, 1)}
    assert shapes == {
        400: (240, 320, 3), 320: (240, 320, 3), 161: (240, 320, 3), 160: (120, 160, 3), 100: (120, 160, 3),
        80: (60, 80, 3), 40: (30, 40, 3), 1: (30, 40, 3),
    }  # fmt: skip
    whole, small = (square_image(decode_image(data, side=side), 80).astype(int) for side in (None, 80))
    assert np.abs(whole - small).mean() < 2


@pytest.mark.parametrize("size", [(640, 479), (479, 640), (641, 3), (1280, 720)])
def test_it_is_never_decoded_smaller_than_the_square_needs(size):
    data = encoded(Image.new("RGB", size), "JPEG")
    height, width, _ = decode_image(data, side=320).shape
    assert 320 <= max(height, width) < 640
    assert height / width == pytest.approx(size[1] / size[0], rel=0.02) or min(size) < 10


@pytest.mark.parametrize("kind", ["png", "webp"])
def test_other_kinds_are_decoded_whole(kind):
    assert decode_image(encode_image(np.zeros((64, 48, 3), np.uint8), kind), side=8).shape == (64, 48, 3)


def test_a_small_jpeg_is_upright_too(picture):
    exif = Image.Exif()
    exif[274] = 6
    data = encoded(picture.resize((600, 400)), "JPEG", exif=exif)
    assert decode_image(data, side=300).shape == (300, 200, 3)
