"""Procedural textures of surfaces: wood, stone, tiles, cloth, carpet, metal, skins and crusts.

Each returns (H, W, 3) float32 linear RGB in 0..1, row 0 at v = 1, the same for the same arguments, and is cached:
calling twice gives the same array, so that rooms share it. All tile seamlessly unless their docstring says otherwise.
"""

from __future__ import annotations

from functools import cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.materials.material import from_hex
from indoor_rooms.materials.noise import Field, blend, finish, noise, paint

Texture: TypeAlias = NDArray[np.float32]


def _coordinates(size: int) -> tuple[Field, Field]:
    """The u (rising to the right) and v (rising upwards) of the pixels' centres, both (size, size)."""
    steps = (np.arange(size, dtype=np.float32) + 0.5) / size
    u, down = np.meshgrid(steps, steps)
    return u, 1 - down


def _grain(size: int, seed: int, rings: int = 7) -> Field:
    """Wood grain along u, about 0..1."""
    _, v = _coordinates(size)
    bend = noise(size, seed, 1, 6, 1.6, (1.0, 3.5))
    streaks = noise(size, seed + 1, 8, 220, 0.7, (1.0, 22.0))
    shade = noise(size, seed + 2, 1, 10, 1.3, (1.0, 5.0))
    growth = np.sin(2 * np.pi * (rings * v + 0.55 * bend))
    return 0.5 + 0.13 * growth + 0.12 * streaks + 0.10 * shade


@cache
def wood(dark: str, light: str, seed: int = 0, size: int = 512) -> Texture:
    """Wood with its grain along u; `dark` and `light` are hex colours of the grain."""
    image = blend(from_hex(dark), from_hex(light), _grain(size, seed))
    pores = noise(size, seed + 3, 30, 240, 0.2, (1.0, 26.0))
    return finish(image * (1 - 0.22 * np.clip(pores - 1.4, 0, 1))[..., None])


@cache
def planks(dark: str, light: str, seed: int = 0, rows: int = 8, size: int = 1024) -> Texture:
    """A plank floor, planks along u, `rows` of them across; each plank has its own shade and piece of grain."""
    rng = np.random.default_rng(seed)
    grain = np.concatenate([_grain(size // 2, seed)] * 2, axis=1)
    height = size // rows
    image = np.empty((size, size, 3), dtype=np.float32)
    for row in range(rows):
        start = int(rng.integers(size))
        ends = (start, (start + size // 2 + int(rng.integers(-size // 8, size // 8))) % size)
        columns = (np.arange(size) - ends[0]) % size
        second = columns >= (ends[1] - ends[0]) % size
        line = np.empty((height, size), dtype=np.float32)
        for chosen in (~second, second):
            top = int(rng.integers(size // 2 - height))
            tone = rng.normal(0.0, 0.10)
            line[:, chosen] = np.roll(grain[top : top + height], int(rng.integers(size)), axis=1)[:, chosen] + tone
        band = blend(from_hex(dark), from_hex(light), line)
        edge = np.minimum(np.arange(height), np.arange(height)[::-1]) + 0.5
        gap = np.clip(1.6 - edge / 1.2, 0, 1)[:, None]
        joint = np.minimum(columns, np.abs(columns - (ends[1] - ends[0]) % size))
        gap = np.maximum(gap, np.clip(1.6 - joint / 1.2, 0, 1)[None])
        image[row * height : (row + 1) * height] = band * (1 - 0.55 * gap)[..., None]
    return finish(image)


@cache
def tiles(
    colour: str,
    grout: str,
    seed: int = 0,
    across: int = 4,
    down: int = 8,
    staggered: bool = True,
    variation: float = 0.03,
    size: int = 512,
) -> Texture:
    """Wall or floor tiles with grout; `down` must be even if they are staggered like bricks."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[0:size, 0:size]
    tile_height, tile_width = size / down, size / across
    row = (rows / tile_height).astype(int) % down
    shifted = columns + (row % 2) * (tile_width / 2) * staggered
    column = (shifted / tile_width).astype(int) % across
    tone = 1 + variation * rng.standard_normal((down, across))
    image = np.asarray(from_hex(colour)) * (tone[row, column] + 0.012 * noise(size, seed, 3, 60))[..., None]
    y, x = rows % tile_height, shifted % tile_width
    edge = np.minimum(np.minimum(y, tile_height - y), np.minimum(x, tile_width - x))
    # A soft bright rim inside the joint reads as the tile's rounded edge.
    image = image * (1 + 0.05 * np.exp(-(((edge - 5.0) / 2.0) ** 2)))[..., None]
    return finish(paint(image.astype(np.float32), from_hex(grout), np.clip((3.2 - edge) / 1.4, 0, 1)))


@cache
def marble(stone: str = "#ecebe7", vein: str = "#8d8f94", seed: int = 0, size: int = 512) -> Texture:
    """Polished marble with thin winding veins."""
    clouds = noise(size, seed, 1, 40, 1.7)
    other = noise(size, seed + 1, 1, 90, 1.5)
    veins = np.exp(-np.abs(clouds + 0.35 * other) * 22) * np.clip(0.5 + 0.4 * noise(size, seed + 2, 1, 5, 1), 0, 1)
    fine = np.exp(-np.abs(other - 0.4 * clouds) * 30) * 0.30
    image = blend(from_hex(stone), from_hex(vein), 0.75 * veins + fine + 0.05 * (clouds + 1))
    return finish(image * (1 + 0.012 * noise(size, seed + 3, 60, 250, 0))[..., None])


@cache
def granite(dark: str = "#4a4846", light: str = "#9b9690", seed: int = 0, size: int = 512) -> Texture:
    """Speckled granite."""
    grains = noise(size, seed, 24, 200, 0.5)
    image = blend(from_hex(dark), from_hex(light), 0.5 + 0.25 * grains + 0.08 * noise(size, seed + 1, 3, 20))
    image = paint(image, from_hex("#d8d2c6"), np.clip((noise(size, seed + 2, 30, 160, 0.5) - 1.5) * 4, 0, 1))
    return finish(paint(image, from_hex("#201f20"), np.clip((noise(size, seed + 3, 30, 160, 0.5) - 1.7) * 4, 0, 1)))


@cache
def plaster(colour: str, seed: int = 0, roughness: float = 0.012, size: int = 256) -> Texture:
    """A painted wall: one colour, hardly uneven."""
    uneven = noise(size, seed, 1, 12, 1.2) + 0.7 * noise(size, seed + 1, 20, 120, 0.3)
    return finish(np.asarray(from_hex(colour), dtype=np.float32) * (1 + roughness * uneven)[..., None])


@cache
def linen(colour: str, seed: int = 0, size: int = 256) -> Texture:
    """Plain woven cloth."""
    rows, columns = np.mgrid[0:size, 0:size]
    weave = np.sin(2 * np.pi * columns / 4) * np.sin(2 * np.pi * rows / 4)
    threads = noise(size, seed, 10, 100, 0.4, (1, 12)) + noise(size, seed + 1, 10, 100, 0.4, (12, 1))
    return finish(np.asarray(from_hex(colour)) * (0.95 + 0.05 * weave + 0.05 * threads)[..., None])


@cache
def gingham(colour: str, ground: str = "#f4f1ea", checks: int = 8, seed: int = 0, size: int = 256) -> Texture:
    """Checked cloth: two crossing sets of stripes."""
    u, v = _coordinates(size)
    cover = 0.5 * ((u * checks) % 1 < 0.5) + 0.5 * ((v * checks) % 1 < 0.5)
    image = blend(from_hex(ground), from_hex(colour), cover.astype(np.float32))
    return finish(image * (1 + 0.03 * noise(size, seed, 20, 120, 0.2))[..., None])


@cache
def rug(ground: str, lines: str, accent: str, seed: int = 0, size: int = 512) -> Texture:
    """A woven rug with borders and a diamond pattern; covers the whole rug once, and does not tile."""
    u, v = _coordinates(size)
    border = np.minimum(np.minimum(u, 1 - u) * 1.5, np.minimum(v, 1 - v))
    diamond = np.abs(((u * 6) % 1) - 0.5) + np.abs(((v * 4) % 1) - 0.5)
    image = np.broadcast_to(np.asarray(from_hex(ground), dtype=np.float32), (size, size, 3))
    inner = border > 0.12
    image = paint(image, from_hex(lines), (inner & (np.abs(diamond - 0.40) < 0.045)).astype(np.float32))
    image = paint(image, from_hex(accent), (inner & (diamond < 0.14)).astype(np.float32))
    image = paint(image, from_hex(accent), ((border > 0.04) & (border < 0.085)).astype(np.float32))
    image = paint(image, from_hex(lines), (np.abs(border - 0.105) < 0.008).astype(np.float32))
    fibres = noise(size, seed, 60, 256, 0.0, (1, 4)) * 0.07 + noise(size, seed + 1, 1, 8) * 0.03
    return finish(image * (1 + fibres)[..., None])


@cache
def carpet(colour: str, seed: int = 0, flecks: float = 0.10, size: int = 512) -> Texture:
    """A short-piled carpet; `flecks` is how much its tufts differ."""
    tufts = noise(size, seed, 60, 256, 0.0)
    worn = noise(size, seed + 1, 1, 6, 1.2)
    image = np.asarray(from_hex(colour), dtype=np.float32) * (1 + flecks * tufts + 0.025 * worn)[..., None]
    return finish(image)


@cache
def carpet_tiles(colour: str, seed: int = 0, across: int = 4, size: int = 1024) -> Texture:
    """An office floor of `across` x `across` carpet tiles whose pile runs by turns one way and the other."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[0:size, 0:size]
    row, column = rows * across // size, columns * across // size
    turned = ((row + column) % 2 == 0)[..., None]
    lines, other = noise(size, seed, 30, 200, 0.2, (1.0, 9.0)), noise(size, seed + 1, 30, 200, 0.2, (9.0, 1.0))
    tone = 1 + 0.035 * rng.standard_normal((across, across))[row, column]
    pile = np.where(turned, lines[..., None], other[..., None])
    edge = np.minimum(rows % (size // across), columns % (size // across))
    image = np.asarray(from_hex(colour)) * tone[..., None] * (1 + 0.09 * pile) * (1 - 0.18 * (edge < 2))[..., None]
    return finish(image)


@cache
def leather(colour: str, seed: int = 0, size: int = 512) -> Texture:
    """Leather: a fine grain of creases, paler where it is worn."""
    creases = np.abs(noise(size, seed, 30, 160, 0.6))
    worn = noise(size, seed + 1, 1, 8, 1.3)
    image = np.asarray(from_hex(colour)) * (0.92 + 0.10 * np.clip(creases, 0, 1.2) + 0.05 * worn)[..., None]
    return finish(image)


@cache
def cork(seed: int = 0, size: int = 512) -> Texture:
    """A pinboard's cork: grains of several browns."""
    grains = noise(size, seed, 20, 110, 0.6)
    image = blend(from_hex("#8f6236"), from_hex("#d6aa72"), 0.5 + 0.24 * grains)
    return finish(paint(image, from_hex("#5a3a1e"), np.clip((noise(size, seed + 1, 25, 90, 0.4) - 1.8) * 3, 0, 1)))


@cache
def brushed_metal(colour: str = "#c9cbcc", seed: int = 0, strength: float = 0.035, size: int = 256) -> Texture:
    """Metal brushed along u."""
    lines = noise(size, seed, 12, 128, 0.3, (1.0, 40.0))
    return finish(np.asarray(from_hex(colour)) * (1 + strength * lines)[..., None])


@cache
def bread_crust(seed: int = 0, size: int = 512) -> Texture:
    """A loaf's crust: u along the loaf, v around it from its underside over the top (v = 0.5) and back.

    Darker on top, floury, with pale slanting cuts. Tiles along v only.
    """
    u, v = _coordinates(size)
    top = np.exp(-(((v - 0.5) / 0.24) ** 2))
    image = blend(from_hex("#e2b06a"), from_hex("#a5602a"), 0.10 + 0.70 * top + 0.14 * noise(size, seed, 3, 60, 1.0))
    slant = (u * 4.0 + (v - 0.5) * 2.2 + 0.02 * noise(size, seed + 1, 4, 40)) % 1.0
    cut = np.exp(-(((slant - 0.5) / 0.085) ** 2)) * (np.abs(v - 0.5) < 0.17) * (np.abs(u - 0.5) < 0.40)
    rim = np.exp(-(((np.abs(slant - 0.5) - 0.13) / 0.035) ** 2)) * (np.abs(v - 0.5) < 0.17) * (np.abs(u - 0.5) < 0.40)
    image = paint(image, from_hex("#6b3612"), (0.6 * rim).astype(np.float32))
    image = paint(
        image, from_hex("#f0d6a0"), (0.95 * cut + 0.05 * noise(size, seed + 2, 30, 200, 0)).astype(np.float32)
    )
    flour = np.clip(noise(size, seed + 3, 4, 220, 0.7) - 1.2, 0, 1) * top
    return finish(paint(image, from_hex("#f6ead2"), 0.55 * flour))


@cache
def apple_skin(deep: str, pale: str, seed: int = 0, size: int = 256) -> Texture:
    """An apple's skin: u around, v from the blossom end to the stalk. Tiles along u only."""
    _, v = _coordinates(size)
    streaks = noise(size, seed, 4, 60, 0.8, (9.0, 1.0))
    cheek = noise(size, seed + 1, 1, 3, 1.0)
    ends = np.clip((v - 0.74) * 4, 0, 1) + np.clip((0.12 - v) * 5, 0, 1)
    image = blend(from_hex(deep), from_hex(pale), 0.16 + 0.15 * streaks + 0.16 * cheek + 0.55 * ends)
    return finish(
        paint(image, from_hex("#f3dfae"), 0.7 * np.clip((noise(size, seed + 2, 40, 110, 0) - 2.3) * 3, 0, 1))
    )


@cache
def citrus_peel(colour: str, stalk: str = "#6a7a2c", seed: int = 0, size: int = 256) -> Texture:
    """A citrus fruit's dimpled peel with a green button at its stalk end (v = 1). Tiles along u only."""
    _, v = _coordinates(size)
    image = np.asarray(from_hex(colour)) * (1 + 0.05 * noise(size, seed, 40, 110, 0))[..., None]
    image = image * (1 + 0.05 * noise(size, seed + 1, 1, 5))[..., None]
    return finish(paint(image.astype(np.float32), from_hex(stalk), np.clip((v - 0.955) * 60, 0, 1)))


@cache
def banana_skin(ripe: str = "#f2ca3a", seed: int = 0, size: int = 256) -> Texture:
    """A banana's skin: u around, v from the stalk to the brown tip. Tiles along u only."""
    u, v = _coordinates(size)
    image = blend(from_hex(ripe), from_hex("#e0a92c"), 0.25 + 0.2 * noise(size, seed, 2, 30, 1.0, (3.0, 1.0)))
    image = image * (1 - 0.16 * np.exp(-((((u * 5) % 1 - 0.5) / 0.09) ** 2)))[..., None]
    green = np.clip(1 - (1 - v) / 0.22, 0, 1)
    image = paint(image.astype(np.float32), from_hex("#a9b03c"), 0.7 * green)
    image = paint(image, from_hex("#4a3016"), np.clip((0.045 - v) * 60, 0, 1) + np.clip((v - 0.965) * 60, 0, 1))
    spots = np.clip((noise(size, seed + 1, 10, 60, 0.5, (2.5, 1.0)) - 1.9) * 3, 0, 1)
    return finish(paint(image, from_hex("#7a5118"), 0.6 * spots))
