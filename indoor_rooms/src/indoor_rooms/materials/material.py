"""Surface materials and the procedural textures they use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Colour: TypeAlias = tuple[float, float, float]


def from_hex(code: str) -> Colour:
    """Linear RGB in 0..1 of a display colour such as "#c8a27a"."""
    red, green, blue = (int(code[start : start + 2], 16) / 255 for start in (1, 3, 5))
    return (_linear(red), _linear(green), _linear(blue))


def _linear(value: float) -> float:
    """One sRGB channel to linear, both 0..1."""
    return float(value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4)


@dataclass(frozen=True, eq=False)
class Material:
    """How a surface looks. Colours are linear RGB.

    Attributes:
        colour: (3,) base colour; multiplies the texture if there is one.
        texture: (H, W, 3) float32 linear RGB in 0..1, row 0 at v = 1 (top), wrapping; or None. Shared by identity.
        roughness: 0 mirror .. 1 matt.
        metalness: 0 dielectric, 1 metal (base colour tints the reflection).
        specular: strength of a dielectric's reflection, 0.5 is F0 = 0.04.
        coat: 0..1, strength of a clear coat (glaze, varnish).
        emission: radiance multiplier; more than 0 makes the surface glow with its base colour.
    """

    colour: tuple[float, float, float] = (0.8, 0.8, 0.8)
    texture: NDArray[np.float32] | None = None
    roughness: float = 0.5
    metalness: float = 0.0
    specular: float = 0.5
    coat: float = 0.0
    emission: float = 0.0
