"""What is under and behind an object in a phone picture: one set for training, another for held-out pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import numpy as np

from indoor_rooms.materials import textures
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import cloth, printed, wood
from indoor_rooms.materials.textures import Texture

# A material, and how often its texture repeats per metre. A function, so that importing makes no textures.
Covering: TypeAlias = tuple[Callable[[], Material], float]


@dataclass(frozen=True)
class Scenery:
    """What may be under (`grounds`) and behind (`walls`) an object."""

    grounds: tuple[Covering, ...]
    walls: tuple[Covering, ...]


def _floor(texture: Callable[[], Texture]) -> Callable[[], Material]:
    return lambda: Material((1.0, 1.0, 1.0), texture(), roughness=0.4, coat=0.15)


def _paint(colour: str) -> Callable[[], Material]:
    return lambda: Material((1.0, 1.0, 1.0), textures.plaster(colour), roughness=0.95, specular=0.1)


@cache
def wallpaper(ground: str, figure: str, across: int = 5, size: int = 256) -> Texture:
    """Papered wall: stripes with a diamond on every other one. Seamless."""
    share = (np.arange(size, dtype=np.float32) + 0.5) / size * across
    x, y = np.meshgrid(share % 1 - 0.5, share % 1 - 0.5)
    stripe = (share.astype(int) % 2 == 0)[None, :] & (np.abs(y) < 2)
    diamond = (np.abs(x) * 1.4 + np.abs(y) < 0.38) & stripe
    cover = np.where(diamond, 0.9, np.where(stripe, 0.18, 0.0))[..., None]
    return np.asarray(np.asarray(from_hex(ground)) * (1 - cover) + np.asarray(from_hex(figure)) * cover, np.float32)


TRAINING_SCENERY = Scenery(
    grounds=(
        (lambda: wood("#b08250", "#d9b482", 3), 1.2),
        (lambda: cloth("#3f7f86"), 9.0),
        (lambda: printed(textures.gingham("#b5402f"), 0.95), 2.6),
        (_floor(lambda: textures.planks("#a9794c", "#cfa274", 2)), 0.7),
        (_floor(lambda: textures.tiles("#cfc6b4", "#9b9488", 4, 4, 4, False)), 1.0),
    ),
    walls=(
        (_paint("#d9c9ae"), 1.0),
        (_paint("#9fb6a4"), 1.0),
        (lambda: printed(textures.tiles("#e9e6dd", "#b9b4aa", 1), 0.4), 1.6),
        (lambda: printed(wallpaper("#efe6d2", "#7d8f5a"), 0.9), 2.2),
    ),
)
HELD_OUT_SCENERY = Scenery(
    grounds=(
        (lambda: wood("#5f4029", "#93694a", 8), 1.2),
        (lambda: cloth("#c9a13b"), 9.0),
        (lambda: printed(textures.gingham("#34567f"), 0.95), 3.4),
        (_floor(lambda: textures.tiles("#a65f43", "#c9bda9", 6, 4, 4, False, 0.06)), 1.3),
        (_floor(lambda: textures.marble("#dcdad4", "#77797e", 5)), 1.0),
    ),
    walls=(
        (_paint("#c7d3dc"), 1.0),
        (_paint("#c98d74"), 1.0),
        (lambda: printed(wallpaper("#dfe6ea", "#4f6d8f", 7), 0.9), 2.6),
        (lambda: wood("#c4a27a", "#e6ceac", 9), 0.8),
    ),
)
