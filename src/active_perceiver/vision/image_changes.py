"""What another camera, another moment or other light makes of an image. Pure functions; what is random is drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter
from scipy.ndimage import uniform_filter1d

from active_perceiver.scenes.images import decode_image, encode_image

Pixels = NDArray[np.uint8]

# What an image file's values are raised to for them to grow as the light does; sRGB's curve is close to it.
GAMMA = 2.2

# The most that `photometric` changes: light by a factor of two, red and blue by half, noise of 25, blur of 2 pixels.
MOST_STOPS, MOST_CAST, MOST_NOISE, MOST_BLUR, MOST_MOTION = 1.0, 0.6, 25.0, 2.0, 9


def pixel_noise(image: Pixels, rng: np.random.Generator, sigma: float) -> Pixels:
    """Noise of the sensor: normal, independent for each pixel and colour, `sigma` of 255."""
    return _as_pixels(image + sigma * rng.standard_normal(image.shape, np.float32))


def blurred(image: Pixels, rng: np.random.Generator, sigma: float) -> Pixels:
    """Out of focus: a Gaussian of `sigma` pixels."""
    return np.asarray(Image.fromarray(image).filter(ImageFilter.GaussianBlur(sigma)))


def motion_blurred(image: Pixels, rng: np.random.Generator, length: int) -> Pixels:
    """Taken while the robot turns: each row is averaged over `length` pixels."""
    return _as_pixels(uniform_filter1d(image.astype(np.float32), length, axis=1, mode="nearest"))


def exposed(image: Pixels, rng: np.random.Generator, gains: tuple[float, float, float]) -> Pixels:
    """Another exposure or white balance: red, green and blue light times `gains`; what is too bright is cut."""
    return _as_pixels(image * np.power(gains, 1 / GAMMA).astype(np.float32))


def compressed(image: Pixels, rng: np.random.Generator, quality: int) -> Pixels:
    """Sent as JPEG of this quality, 1..95."""
    return decode_image(encode_image(image, "jpeg", quality))


def photometric(image: Pixels, rng: np.random.Generator) -> Pixels:
    """One image as another camera, or in other light, would have taken it; a little of everything at random.

    Args:
        image: (H, W, 3) uint8 RGB.
        rng: draws what happens, and how strongly.
    """
    if rng.random() < 0.7:
        gain, red, blue = 2.0 ** (rng.uniform(-1, 1, 3) * (MOST_STOPS, MOST_CAST, MOST_CAST))
        image = exposed(image, rng, (gain * red, gain, gain * blue))
    kind = rng.choice(("sharp", "out of focus", "moving"), p=(0.6, 0.25, 0.15))
    if kind == "out of focus":
        image = blurred(image, rng, rng.uniform(0.3, MOST_BLUR))
    elif kind == "moving":
        image = motion_blurred(image, rng, int(rng.integers(3, MOST_MOTION + 1)))
    if rng.random() < 0.5:
        image = pixel_noise(image, rng, rng.uniform(3.0, MOST_NOISE))
    if rng.random() < 0.25:
        image = compressed(image, rng, int(rng.integers(15, 60)))
    return image


def _as_pixels(values: NDArray[np.floating]) -> Pixels:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
