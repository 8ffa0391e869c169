"""Colours and materials that make one kitchen differ from another."""

from __future__ import annotations

from dataclasses import dataclass

from active_perceiver.rooms import textures
from active_perceiver.rooms.materials import Material
from active_perceiver.rooms.surfaces import glazed, plastic, wood

WoodTones = tuple[str, str]
OAK: WoodTones = ("#b08250", "#d9b482")
BEECH: WoodTones = ("#c79a66", "#ecca98")
WALNUT: WoodTones = ("#5f4029", "#93694a")
CHERRY: WoodTones = ("#8a4f2c", "#bd7c4c")


@dataclass(frozen=True)
class Theme:
    """A kitchen's colours; a string is a paint's hex colour, a pair the dark and light tone of wood.

    Attributes:
        cabinets: fronts of the fitted kitchen.
        counter: "marble", "granite", "slate" or tones of wood.
        walls: paint.
        tiles: of the splashback.
        floor: tones of planks, or paint-like tile colour.
        table: tones of table and sideboard top.
        chairs: wood or lacquer.
        sideboard: wood or lacquer.
        fridge: enamel colour, or None for steel.
        rug: ground, lines and accent.
        accent: towel and lampshade.
        cushion: seat pads.
    """

    cabinets: str | WoodTones
    counter: str | WoodTones
    walls: str
    tiles: str
    floor: str | WoodTones
    table: WoodTones
    chairs: str | WoodTones
    sideboard: str | WoodTones
    fridge: str | None
    rug: tuple[str, str, str]
    accent: str
    cushion: str


THEMES = (
    Theme(
        "#b4c4b0", "marble", "#f3ede0", "#f4f2ec", OAK, OAK, "#f2efe8", BEECH, None,
        ("#ece4d2", "#5b7f95", "#c97b4a"), "#d2603f", "#8fa9b8",
    ),
    Theme(
        BEECH, "slate", "#eef1ee", "#e3ece8", ("#a9794c", "#cfa274"), WALNUT, WALNUT, "#f1efe9", "#c3dcd6",
        ("#e6dccb", "#a4503f", "#3f5f73"), "#3f7f86", "#d9c9ae",
    ),
    Theme(
        "#f2f0ea", OAK, "#e4ecf0", "#f6f5f1", ("#c4a27a", "#e6ceac"), BEECH, BEECH, "#8fa6b5", None,
        ("#dfe3e2", "#38506b", "#e0a33f"), "#e0a33f", "#c26a4f",
    ),
    Theme(
        "#5f7f96", "marble", "#f6f1e4", "#f2efe6", "#d8d0c2", CHERRY, CHERRY, CHERRY, "#f3ead2",
        ("#efe6d4", "#7d8f5a", "#b5533c"), "#b5533c", "#e3d6bd",
    ),
    Theme(
        CHERRY, "granite", "#f4efe2", "#ece7da", ("#9a6c44", "#c4946a"), BEECH, "#37474f", "#eee8da", None,
        ("#e9dfcc", "#8a5a3c", "#4d7a6a"), "#4d7a6a", "#c9b79a",
    ),
)  # fmt: skip


def finish_of(look: str | WoodTones, seed: int, gloss: float = 0.25) -> Material:
    """Lacquer of a colour, or wood of two tones."""
    return plastic(look, 0.36) if isinstance(look, str) else wood(*look, seed, gloss)


def counter_of(look: str | WoodTones, seed: int) -> Material:
    """A worktop: polished stone, or oiled wood."""
    if not isinstance(look, str):
        return wood(*look, seed, 0.35)
    stone = {
        "marble": lambda: textures.marble(seed=seed),
        "granite": lambda: textures.granite("#6a6662", "#aaa49c", seed),
        "slate": lambda: textures.granite("#4d5356", "#7d8487", seed),
    }[look]()
    return Material((1.0, 1.0, 1.0), stone, roughness=0.2, coat=0.35)


def floor_of(look: str | WoodTones, seed: int) -> Material:
    """A floor of planks, or of stone tiles."""
    if isinstance(look, str):
        return Material((1.0, 1.0, 1.0), textures.tiles(look, "#a9a296", seed, 4, 4, False, 0.035), roughness=0.3)
    return Material((1.0, 1.0, 1.0), textures.planks(*look, seed), roughness=0.36, coat=0.2)


def shade_of(theme: Theme) -> Material:
    """The pendant lamp's shade."""
    return glazed(theme.accent, 0.35)
