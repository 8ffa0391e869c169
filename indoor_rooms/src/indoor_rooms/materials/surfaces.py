"""Named materials, shared by objects and furniture. Textured ones are functions, so that importing costs nothing."""

from __future__ import annotations

from functools import cache

from indoor_rooms.materials import textures
from indoor_rooms.materials.material import Colour, Material, from_hex

CHROME = Material(colour=(0.86, 0.87, 0.88), roughness=0.09, metalness=1.0)
BLACK_PLASTIC = Material(colour=from_hex("#2b2b2d"), roughness=0.42)
BLACK_GLASS = Material(colour=from_hex("#17181a"), roughness=0.08, coat=0.8)
CAST_IRON = Material(colour=from_hex("#303133"), roughness=0.5)
WHITE_PAINT = Material(colour=from_hex("#f1efea"), roughness=0.35)
BRASS = Material(colour=from_hex("#d9b25c"), roughness=0.22, metalness=1.0)
PAPER = Material(colour=from_hex("#efe8d6"), roughness=0.95, specular=0.1)
STALK = Material(colour=from_hex("#5b3d1e"), roughness=0.8)


def glazed(colour: str | Colour, roughness: float = 0.16) -> Material:
    """Glazed earthenware, enamel, or anything glossy and clean."""
    linear = from_hex(colour) if isinstance(colour, str) else colour
    return Material(colour=linear, roughness=roughness, coat=0.6)


def plastic(colour: str, roughness: float = 0.38) -> Material:
    """Plastic or lacquer."""
    return Material(colour=from_hex(colour), roughness=roughness)


@cache
def steel() -> Material:
    """Brushed stainless steel."""
    return Material((1.0, 1.0, 1.0), textures.brushed_metal(), roughness=0.30, metalness=0.85)


@cache
def wood(dark: str = "#a9784a", light: str = "#d2a670", seed: int = 0, gloss: float = 0.3) -> Material:
    """Varnished wood; `gloss` 0 oiled .. 1 lacquered."""
    return Material((1.0, 1.0, 1.0), textures.wood(dark, light, seed), roughness=0.55 - 0.3 * gloss, coat=gloss)


def beech() -> Material:
    """Light wood, of boards, handles and knife blocks."""
    return wood("#b98a57", "#e0b985", 5)


def cloth(colour: str) -> Material:
    """Woven cloth."""
    return Material((1.0, 1.0, 1.0), textures.linen(colour), roughness=0.95, specular=0.1)


def printed(texture: textures.Texture, roughness: float = 0.5) -> Material:
    """Printed paper or card."""
    return Material((1.0, 1.0, 1.0), texture, roughness=roughness, specular=0.35)


def patterned(texture: textures.Texture) -> Material:
    """Cloth with a woven or printed pattern."""
    return Material((1.0, 1.0, 1.0), texture, roughness=0.95, specular=0.1)


def rubber(colour: str) -> Material:
    """Rubber, foam or leatherette."""
    return Material(from_hex(colour), roughness=0.7, specular=0.3)


def metallic(colour: str, roughness: float = 0.3) -> Material:
    """Anodised or painted metal of a colour."""
    return Material(from_hex(colour), roughness=roughness, metalness=0.8)


def display(texture: textures.Texture) -> Material:
    """A screen behind glass. It does not glow."""
    return Material((1.0, 1.0, 1.0), texture, roughness=0.2, coat=0.15)


def glossy_print(texture: textures.Texture, roughness: float = 0.2) -> Material:
    """A pattern under glaze or lacquer."""
    return Material((1.0, 1.0, 1.0), texture, roughness=roughness, coat=0.6)
