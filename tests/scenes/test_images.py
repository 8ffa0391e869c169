"""Pictures as users have them: every mode, turned, broken."""

import io
import struct
import sys
import time
import zlib
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from PIL import Image, features

from active_perceiver.scenes import ImageError, decode_image, images, read_image
from active_perceiver.scenes.image_files import Upright, upright
from active_perceiver.scenes.image_modes import TRANSPARENT_BACKGROUND, as_rgb
from active_perceiver.scenes.images import encode_image, square_image


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


# ---- formats and limits


def test_other_formats_are_not_even_tried(picture, tmp_path, monkeypatch):
    """EPS is a program, and Pillow would have Ghostscript run it."""
    monkeypatch.setattr("PIL.EpsImagePlugin.EpsImageFile.load", lambda *_: pytest.fail("Ghostscript was called"))
    path = tmp_path / "mug.jpg"
    picture.save(path, "EPS")
    for source in (path.read_bytes(), encoded(picture, "ICO"), encoded(picture, "PCX"), encoded(picture, "TGA")):
        path.write_bytes(source)
        with pytest.raises(ImageError, match=r"mug\.jpg is not an image that is read \(JPEG, PNG"):
            read_image(path)
        with pytest.raises(ImageError, match=r"mug\.jpg is not an image that is read"):
            upright(path)


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP", "BMP", "TIFF", "GIF", "PPM", "AVIF"])
def test_each_format_that_is_read_is_told_by_its_content(kind, picture, tmp_path):
    if kind == "AVIF" and not features.check("avif"):
        pytest.skip("this Pillow has no AVIF")
    path = tmp_path / "photo.jpg"
    picture.save(path, kind)
    assert np.abs(read_image(path).astype(int) - np.asarray(picture)).mean() < 12
    assert upright(path) == Upright(30, 20, False)


def heic_head() -> bytes:
    return bytes.fromhex("00000018") + b"ftypheic\0\0\0\0mif1heic" + b"\0" * 40


def test_heic_named_jpg_is_called_so(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pillow_heif", None)
    path = tmp_path / "IMG_0001.jpg"
    path.write_bytes(heic_head())
    for read in (read_image, upright):
        with pytest.raises(ImageError, match=r"IMG_0001\.jpg is a HEIC image.*pip install pillow-heif, or save"):
            read(path)


def test_heic_is_read_where_its_library_is(picture):
    pillow_heif = pytest.importorskip("pillow_heif")
    out = io.BytesIO()
    large = picture.resize((300, 200))
    pillow_heif.from_pillow(large).save(out, quality=90)
    assert np.abs(decode_image(out.getvalue()).astype(int) - np.asarray(large)).mean() < 6
    with pytest.raises(ImageError, match="photo begins as HEIF does, but is broken"):
        decode_image(heic_head(), "photo")


def png_head(width: int, height: int) -> bytes:
    """A PNG that has a head, and nothing behind it."""
    chunk = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + struct.pack(">I", 13)
        + chunk
        + struct.pack(">I", zlib.crc32(chunk))
        + b"\0\0\0\x20IDAT"
    )


@pytest.mark.filterwarnings("ignore::PIL.Image.DecompressionBombWarning")
@pytest.mark.parametrize("size", [(100_000_000, 1), (1, 40_000), (8001, 8000), (10_000, 10_000), (100_000, 100_000)])
def test_too_many_pixels_are_refused_by_the_head(size, tmp_path, monkeypatch):
    monkeypatch.setattr("PIL.ImageFile.ImageFile.load", lambda *_: pytest.fail("it was decoded"))
    path = tmp_path / "bomb.png"
    path.write_bytes(png_head(*size))
    for read in (read_image, upright):
        with pytest.raises(ImageError, match=r"bomb\.png has .* pixels.*scale it down"):
            read(path)


def test_large_images_are_decoded_one_at_a_time(picture, monkeypatch):
    inside, most = [], []

    def slow(image, name):
        inside.append(name)
        most.append(len(inside))
        time.sleep(0.02)
        inside.pop()
        return as_rgb(image, name)

    monkeypatch.setattr(images, "as_rgb", slow)
    monkeypatch.setattr(images, "_LARGE", 100)
    data = encoded(picture)
    with ThreadPoolExecutor(4) as pool:
        assert len(list(pool.map(decode_image, [data] * 8))) == 8
    assert max(most) == 1


def test_of_an_animation_the_first_picture_is_taken(picture):
    other = Image.new("RGB", picture.size)
    for kind in ("GIF", "WEBP", "PNG", "TIFF"):
        data = encoded(picture, kind, save_all=True, append_images=[other] * 20)
        assert np.abs(decode_image(data).astype(int) - np.asarray(picture)).mean() < 12, kind


# ---- pictures that should still look like themselves

GREY = np.linspace(0, 1, 20 * 30).reshape(20, 30)


@pytest.mark.parametrize("white", [255, 1023, 4095, 65535])
@pytest.mark.parametrize("kind", ["PNG", "TIFF"])
def test_greys_of_more_bits_keep_their_brightness(kind, white):
    deep = Image.fromarray(np.rint(GREY * white).astype(np.uint16))
    assert np.abs(decode_image(encoded(deep, kind))[..., 0] - GREY * 255).max() <= 1


def test_a_picture_of_16_bits_that_is_dark_stays_dark():
    dark = Image.fromarray(np.rint(GREY * 20_000).astype(np.uint16))
    assert abs(int(decode_image(encoded(dark)).max()) - 20_000 / 257) <= 1


@pytest.mark.parametrize("white", [1.0, 255.0])
def test_floats_keep_their_brightness(white):
    data = encoded(Image.fromarray((GREY * white).astype(np.float32)), "TIFF")
    assert np.abs(decode_image(data)[..., 0] - GREY * 255).max() <= 1


@pytest.mark.parametrize(
    "values",
    [GREY - 0.5, GREY * 1.5, GREY * 5000, np.where(GREY > 0.5, np.nan, GREY), np.where(GREY > 0.5, np.inf, GREY)],
)
def test_floats_that_could_mean_anything_are_refused(values):
    with pytest.raises(ImageError, match=r"photo holds numbers from .* neither 0 to 1 nor 0 to 255; save"):
        decode_image(encoded(Image.fromarray(values.astype(np.float32)), "TIFF"), "photo")


@pytest.mark.parametrize("values", [[[-1, 5]], [[0, 70_000]]])
def test_whole_numbers_of_more_than_16_bits_are_refused(values):
    with pytest.raises(ImageError, match="photo holds numbers from"):
        decode_image(encoded(Image.fromarray(np.array(values, np.int32)), "TIFF"), "photo")


def test_cmyk_keeps_its_colours(picture):
    data = encoded(picture.convert("CMYK"), "JPEG", quality=95)
    assert np.abs(decode_image(data)[12:, 12:].astype(int) - 200).mean() < 6
    assert np.abs(decode_image(data)[2:8, 2:8].astype(int) - (250, 10, 20)).mean() < 12


def test_colours_that_are_no_rgb_are_refused(picture):
    lab = Image.new("LAB", (8, 8))
    with pytest.raises(ImageError, match="photo has colours of kind LAB; save it as RGB"):
        decode_image(encoded(lab, "TIFF"), "photo")


@pytest.mark.parametrize("mode", ["RGBA", "LA", "P"])
def test_what_is_half_transparent_is_half_background(mode):
    clear = Image.new("RGBA", (8, 8), (0, 0, 0, 128))
    data = encoded(clear.convert("LA") if mode == "LA" else clear.quantize(4) if mode == "P" else clear)
    assert np.abs(decode_image(data).astype(int) - TRANSPARENT_BACKGROUND[0] // 2).max() <= 2


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP", "TIFF"])
def test_exif_turns_every_format(kind, picture):
    exif = Image.Exif()
    exif[274] = 8
    data = encoded(picture, kind, exif=exif)
    assert decode_image(data).shape == (30, 20, 3)
    assert upright(data) == Upright(20, 30, True)


def test_large_images_of_other_kinds_are_made_smaller_for_a_small_square(monkeypatch):
    monkeypatch.setattr(images, "_LARGE", 100)
    down, across = np.mgrid[:200, :320] / 40
    image = (127 + 60 * np.stack([np.sin(down), np.cos(across), np.sin(down + across)], -1)).astype(np.uint8)
    exif = Image.Exif()
    exif[274] = 6
    data = encoded(Image.fromarray(image), "PNG", exif=exif)
    shapes = {side: decode_image(data, side=side).shape for side in (400, 320, 161, 160, 80, 1)}
    assert shapes == {
        400: (320, 200, 3), 320: (320, 200, 3), 161: (320, 200, 3), 160: (160, 100, 3), 80: (80, 50, 3), 1: (1, 1, 3),
    }  # fmt: skip
    whole = square_image(decode_image(data), 80).astype(int)
    assert np.abs(square_image(decode_image(data, side=80), 80) - whole).mean() < 2
    for picture in (Image.fromarray(image[..., 0] * np.uint16(257)), Image.fromarray(image).quantize(64)):
        assert decode_image(encoded(picture), side=80).shape == (200, 320, 3)
