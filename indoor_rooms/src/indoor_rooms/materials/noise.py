"""Seamless noise for textures, made by filtering white noise in the frequency domain."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import fft

Field: TypeAlias = NDArray[np.floating]


def noise(
    size: int | tuple[int, int],
    seed: int,
    lowest: float = 2.0,
    highest: float = 128.0,
    slope: float = 1.2,
    stretch: tuple[float, float] = (1.0, 1.0),
) -> Field:
    """Tileable random field of mean 0 and standard deviation 1.

    Args:
        size: pixels, or (rows, columns).
        seed: same seed, same field.
        lowest: coarsest detail, waves per tile.
        highest: finest detail, waves per tile.
        slope: how fast amplitude falls with frequency: 0 white, 1 rough, 2 soft clouds.
        stretch: how much longer features are along (rows, columns).
    """
    rows, columns = (size, size) if isinstance(size, int) else size
    white = np.random.default_rng(seed).standard_normal((rows, columns), dtype=np.float32)
    wave_rows = fft.fftfreq(rows, 1 / rows)[:, None] * stretch[0]
    wave_columns = fft.rfftfreq(columns, 1 / columns)[None] * stretch[1]
    frequency = np.sqrt(wave_rows**2 + wave_columns**2)
    gain = np.where(
        (frequency >= lowest * 0.5) & (frequency <= highest), np.maximum(frequency, lowest) ** -slope, 0.0
    )
    gain[0, 0] = 0.0
    field = fft.irfft2(fft.rfft2(white) * gain.astype(np.float32), s=(rows, columns))
    return (field / max(float(field.std()), 1e-9)).astype(np.float32)


def blend(low: tuple[float, float, float], high: tuple[float, float, float], amount: Field) -> NDArray[np.float32]:
    """Mixes two colours: `low` where amount is 0, `high` where it is 1 (clipped); (H, W) to (H, W, 3)."""
    weight = np.clip(amount, 0.0, 1.0).astype(np.float32)[..., None]
    start, span = np.asarray(low, np.float32), np.subtract(high, low, dtype=np.float32)
    return start + weight * span


def paint(image: NDArray[np.floating], colour: tuple[float, float, float], cover: Field) -> NDArray[np.float32]:
    """Lays a colour over an image, opaque where `cover` (H, W) is 1."""
    weight = np.clip(cover, 0.0, 1.0).astype(np.float32)[..., None]
    base = np.asarray(image, np.float32)
    return base + weight * (np.asarray(colour, np.float32) - base)


def finish(image: NDArray[np.floating]) -> NDArray[np.float32]:
    """Clips to 0..1 and makes the texture read-only, since cached textures are shared."""
    texture = np.ascontiguousarray(np.clip(image, 0.0, 1.0), dtype=np.float32)
    texture.setflags(write=False)
    return texture
