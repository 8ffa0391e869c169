"""Colours and materials that make one room differ from another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from indoor_rooms.materials import textures
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import cloth, plastic, wood

Choice = TypeVar("Choice")
WoodTones = tuple[str, str]
OAK: WoodTones = ("#b08250", "#d9b482")
PALE_OAK: WoodTones = ("#c4a27a", "#e6ceac")
BEECH: WoodTones = ("#c79a66", "#ecca98")
WALNUT: WoodTones = ("#5f4029", "#93694a")
CHERRY: WoodTones = ("#8a4f2c", "#bd7c4c")
TEAK: WoodTones = ("#8f6238", "#bf8c58")
EBONY: WoodTones = ("#3a2d26", "#5f4d42")

WOODS = (OAK, PALE_OAK, BEECH, WALNUT, CHERRY, TEAK, EBONY)
FLOORS: tuple[str | WoodTones, ...] = (
    OAK, PALE_OAK, WALNUT, CHERRY, ("#a9794c", "#cfa274"), ("#9c938a", "#c4bcb2"), "#d8d0c2", "#b9b4ac", "#c98f6a",
)  # fmt: skip
LACQUERS = ("#f2f0ea", "#b4c4b0", "#5f7f96", "#37474f", "#d9d3c6", "#8fa6b5", "#7d8f5a", "#a04a3c", "#e0d2b0")
WALLS = ("#f3ede0", "#eef1ee", "#e4ecf0", "#f6f1e4", "#efe0cc", "#dfe6da", "#f0e4e0", "#d9dde2", "#e9e4d4", "#cfd8d4")
ACCENTS = ("#d2603f", "#3f7f86", "#e0a33f", "#b5533c", "#4d7a6a", "#38506b", "#8a5a7a", "#c98a9a", "#6a7f4a")
FABRICS = ("#8fa9b8", "#d9c9ae", "#c26a4f", "#6d7468", "#4a5a72", "#a9a39a", "#7a8f82", "#b58a5a", "#5a4a4a")
RUGS = (
    ("#ece4d2", "#5b7f95", "#c97b4a"), ("#e6dccb", "#a4503f", "#3f5f73"), ("#dfe3e2", "#38506b", "#e0a33f"),
    ("#efe6d4", "#7d8f5a", "#b5533c"), ("#e9dfcc", "#8a5a3c", "#4d7a6a"), ("#7f3a34", "#d9b98a", "#2f3f52"),
    ("#3f4f5c", "#c9c4b8", "#b58a5a"),
)  # fmt: skip
STONES = ("marble", "granite", "slate", "sand")
FRIDGES = (None, None, "#f2f2f0", "#c3dcd6", "#f3ead2", "#2f3438", "#b5412f")
TILES = ("#f4f2ec", "#e3ece8", "#f6f5f1", "#cfdcdc", "#e9d9c4", "#8fa9a4", "#d9b48a", "#5f7f8f")


@dataclass(frozen=True)
class Theme:
    """A room's colours; a string is a paint's hex colour, a pair the dark and light tone of wood.

    Attributes:
        walls: paint.
        feature: another colour for one wall, or None.
        floor: tones of planks, or a colour of tiles.
        wood: tones of table tops, boards and frames.
        cases: cabinets and other large furniture.
        seats: chairs' frames.
        fabric: upholstery.
        accent: what shall be noticed: lampshade, towel, curtains.
        rug: ground, lines and accent.
        seed: of grain and noise.
    """

    walls: str
    feature: str | None
    floor: str | WoodTones
    wood: WoodTones
    cases: str | WoodTones
    seats: str | WoodTones
    fabric: str
    accent: str
    rug: tuple[str, str, str]
    seed: int

    @property
    def timber(self) -> Material:
        """Varnished wood of table tops and boards."""
        return wood(*self.wood, self.seed, 0.35)

    @property
    def casing(self) -> Material:
        """Lacquer or wood of large furniture."""
        return finish_of(self.cases, self.seed)

    @property
    def frames(self) -> Material:
        """Lacquer or wood of chairs."""
        return finish_of(self.seats, self.seed)


def pick_one(rng: np.random.Generator, choices: Sequence[Choice]) -> Choice:
    """One of some things."""
    return choices[int(rng.integers(len(choices)))]


def theme_of(rng: np.random.Generator) -> Theme:
    """Colours that go together: wood of furniture that differs from the floor's, few strong colours."""
    floor = pick_one(rng, FLOORS)
    tones = pick_one(rng, [tone for tone in WOODS if tone != floor])
    cases: str | WoodTones = pick_one(rng, LACQUERS) if rng.random() < 0.6 else tones
    seats: str | WoodTones = (
        pick_one(rng, ("#f1efe9", "#37474f", "#f2efe8", "#2f3236")) if rng.random() < 0.4 else tones
    )
    accent = pick_one(rng, ACCENTS)
    feature = pick_one(rng, ("#a9bdb4", "#c9b49a", "#8fa0ae", "#b98f78", "#5f7480", "#9aa58a", accent))
    return Theme(
        walls=pick_one(rng, WALLS),
        feature=feature if rng.random() < 0.35 else None,
        floor=floor,
        wood=tones,
        cases=cases,
        seats=seats,
        fabric=pick_one(rng, FABRICS),
        accent=accent,
        rug=pick_one(rng, RUGS),
        # Few of them: a texture that several rooms share is made once.
        seed=int(rng.integers(6)),
    )


def finish_of(look: str | WoodTones, seed: int, gloss: float = 0.25) -> Material:
    """Lacquer of a colour, or wood of two tones."""
    return plastic(look, 0.36) if isinstance(look, str) else wood(*look, seed, gloss)


def counter_of(look: str | WoodTones, seed: int) -> Material:
    """A worktop: polished stone (one of `STONES`), or oiled wood."""
    if not isinstance(look, str):
        return wood(*look, seed, 0.35)
    stone = {
        "marble": lambda: textures.marble(seed=seed),
        "granite": lambda: textures.granite("#6a6662", "#aaa49c", seed),
        "slate": lambda: textures.granite("#4d5356", "#7d8487", seed),
        "sand": lambda: textures.granite("#b0a48e", "#d6cbb4", seed),
    }[look]()
    return Material((1.0, 1.0, 1.0), stone, roughness=0.2, coat=0.35)


def floor_of(look: str | WoodTones, seed: int) -> Material:
    """A floor of planks, or of stone tiles."""
    if isinstance(look, str):
        return Material((1.0, 1.0, 1.0), textures.tiles(look, "#a9a296", seed, 4, 4, False, 0.035), roughness=0.3)
    return Material((1.0, 1.0, 1.0), textures.planks(*look, seed), roughness=0.36, coat=0.2)


def paint_of(colour: str) -> Material:
    """A painted wall."""
    return Material((1.0, 1.0, 1.0), textures.plaster(colour), roughness=0.9, specular=0.15)


def upholstery_of(colour: str, rng: np.random.Generator) -> Material:
    """Woven cloth, or leather."""
    if rng.random() < 0.7:
        return cloth(colour)
    return Material((1.0, 1.0, 1.0), textures.leather(colour), roughness=0.45, coat=0.1)


def curtain_of(colour: str) -> Material:
    """Thin cloth of curtains."""
    return Material(from_hex(colour), roughness=0.95, specular=0.05)
