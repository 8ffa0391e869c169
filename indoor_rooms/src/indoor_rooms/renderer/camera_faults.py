"""What a robot's cheap camera does to a picture: exposure and colour that change from view to view, blur, noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from indoor_rooms.errors import RoomError

# The most that still leaves a picture of something.
LARGEST = {"exposure": 3.0, "white_balance": 0.5, "vignette": 1.0, "blur": 20.0, "noise": 1.0}


class CameraFaultError(RoomError, ValueError):
    """A fault that no camera has."""


@dataclass(frozen=True)
class CameraFaults:
    """How good a camera is; the defaults are those of a webcam in a room. All 0 is a perfect one.

    Attributes:
        exposure: each picture is up to so many stops too bright or too dark.
        white_balance: in each picture red and blue are off by up to this fraction of themselves.
        vignette: by this fraction the corners are darker than the middle.
        blur: standard deviation of the blur in pixels.
        noise: standard deviation of the noise where the picture is white, as a fraction of white; elsewhere it
            follows the square root of the light, as the noise of photons does.
    """

    exposure: float = 0.35
    white_balance: float = 0.07
    vignette: float = 0.12
    blur: float = 0.6
    noise: float = 0.02

    def __post_init__(self) -> None:
        for field in fields(self):
            value, largest = getattr(self, field.name), LARGEST[field.name]
            if not 0 <= value <= largest:
                raise CameraFaultError(f"the camera's {field.name} must be in 0..{largest:g}, got {value}")


def with_faults(image: NDArray[np.uint8], faults: CameraFaults, rng: np.random.Generator) -> NDArray[np.uint8]:
    """The picture that a camera with faults would have taken.

    Args:
        image: (H, W, 3) uint8 sRGB.
        faults: of the camera.
        rng: exposure, white balance and noise are drawn from it.

    Returns:
        (H, W, 3) uint8; equal to `image` if all faults are 0.
    """
    gain = 2.0 ** rng.uniform(-faults.exposure, faults.exposure)
    red, blue = 1 + rng.uniform(-faults.white_balance, faults.white_balance, 2)
    # Light adds up and is counted in linear values; sRGB is what a file holds.
    light = _to_linear(image) * np.array([gain * red, gain, gain * blue], np.float32)
    light *= 1 - faults.vignette * _distance_squared(*image.shape[:2])[..., None]
    if faults.blur > 0:
        light = gaussian_filter(light, (faults.blur, faults.blur, 0), mode="nearest")
    noise = rng.standard_normal(image.shape, np.float32)
    light += np.float32(faults.noise) * np.sqrt(np.maximum(light, 0)) * noise
    return _to_srgb(light)


def view_rng(seed: int, pose: Sequence[float]) -> np.random.Generator:
    """What is drawn for a view follows from its (4,) pose, not from how many were made before it."""
    values = [round(float(value) * 10_000) % 2**32 for value in pose]
    return np.random.default_rng([seed, *values])


def _distance_squared(height: int, width: int) -> NDArray[np.float32]:
    """Of each pixel from the picture's middle, 1 in the corners; (H, W)."""
    down, across = (np.linspace(-1, 1, count, dtype=np.float32) for count in (height, width))
    return np.asarray((down[:, None] ** 2 + across[None] ** 2) / 2, np.float32)


def _to_linear(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    value = np.arange(256) / 255
    table = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return table.astype(np.float32)[image]


def _to_srgb(light: NDArray[np.float32]) -> NDArray[np.uint8]:
    clipped = np.clip(light, 0, 1)
    encoded = np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)
    return np.asarray(encoded * 255 + 0.5, np.uint8)
