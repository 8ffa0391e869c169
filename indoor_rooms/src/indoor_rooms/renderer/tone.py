"""From radiance to the picture a camera would give: denoising and tone mapping."""

from __future__ import annotations

import atexit
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.renderer.raycast import open_image_denoise

# Radiance (after exposure) that becomes white; what is brighter clips softly before it.
WHITE_POINT = 6.0
# Share of the luminance curve in highlights; the rest is the curve of each channel, which bleaches them.
KEEP_HUE = 0.5
CONTRAST = 1.3
SATURATION = 1.1
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


@lru_cache(maxsize=1)
def _denoiser_device() -> Any:
    oidn = open_image_denoise()
    device = oidn.Device(oidn.DeviceType.CPU)
    # One thread: views are made in parallel processes, and a fixed number keeps them the same everywhere.
    device.num_threads = 1
    # Without this the device outlives the module at exit, and its binding complains about leaks.
    atexit.register(_denoiser_device.cache_clear)
    return device


def remove_noise(
    radiance: NDArray[np.float32], albedo: NDArray[np.float32], normal: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Remove noise from a picture, keeping the edges of noise-free albedo and normals.

    Args:
        radiance: (H, W, 3) float32, fireflies already clamped.
        albedo: (H, W, 3) float32 in 0..1.
        normal: (H, W, 3) float32 in -1..1.
    """
    oidn = open_image_denoise()
    result = oidn.denoise(
        np.ascontiguousarray(radiance, np.float32),
        albedo=np.ascontiguousarray(albedo, np.float32),
        normal=np.ascontiguousarray(normal, np.float32),
        hdr=True,
        clean_aux=True,
        quality=oidn.Quality.Fast,
        # Chosen by the denoiser from the picture otherwise; fixed, neighbouring views get the same treatment.
        input_scale=1.0,
        device=_denoiser_device(),
    )
    return np.maximum(np.array(result, np.float32), 0)


def tone_map(radiance: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Filmic curve with soft highlights, then sRGB.

    Args:
        radiance: (H, W, 3) float32, already exposed: 0.2 is a middle grey.

    Returns:
        (H, W, 3) uint8.
    """
    luminance = np.maximum(_luminance(radiance), 1e-6)
    per_hue = radiance / luminance * _curve(luminance)
    colour = KEEP_HUE * per_hue + (1 - KEEP_HUE) * _curve(radiance)
    grey = _luminance(colour)
    colour = np.clip(grey + SATURATION * (colour - grey), 0, 1)
    encoded = np.where(colour <= 0.0031308, 12.92 * colour, 1.055 * colour ** (1 / 2.4) - 0.055)
    # A gentle S around middle grey, symmetric so that it neither brightens nor darkens.
    curved = encoded + (CONTRAST - 1) * (encoded - 0.5) * 4 * encoded * (1 - encoded)
    return (np.clip(curved, 0, 1) * 255 + 0.5).astype(np.uint8)


def _luminance(colour: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.einsum("ijk,k->ij", colour, _LUMINANCE).astype(np.float32)[..., None]


def _curve(value: NDArray[np.float32]) -> NDArray[np.float32]:
    """Reinhard's curve with a white point: nearly linear for shadows, 1 at the white point."""
    return np.asarray(value * (1 + value / WHITE_POINT**2) / (1 + value), np.float32)
