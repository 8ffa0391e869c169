"""Repeating patterns of cloth, wrapping and glaze, woven cane, and the coverings of balls and globes."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from indoor_rooms.materials.material import from_hex
from indoor_rooms.materials.noise import Field, finish, noise, paint
from indoor_rooms.materials.prints import to_texture
from indoor_rooms.materials.textures import Texture

PATTERNS = ("stripes", "dots", "zigzag", "diamonds", "checks", "leaves", "triangles", "blocks")


def _halved(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Every two by two pixels averaged: figures drawn twice too large get smooth edges."""
    height, width, _ = image.shape
    return image.reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))


@cache
def pattern(kind: str, ground: str, first: str, second: str, repeats: int = 4, weave: float = 0.05) -> Texture:
    """A two-colour pattern on a ground; tiles.

    Args:
        kind: one of `PATTERNS`.
        ground: hex colour.
        first: hex colour of the figures.
        second: hex colour of every other figure.
        repeats: figures across the tile; even.
        weave: how strongly threads show; 0 for print on paper or glaze.
    """
    size = 192
    steps = (np.arange(2 * size, dtype=np.float32) + 0.5) / (2 * size)
    u, v = np.meshgrid(steps * repeats, (1 - steps) * repeats)
    a, b = u % 1 - 0.5, v % 1 - 0.5
    odd = (np.floor(u) + np.floor(v)) % 2 > 0.5
    cover: NDArray[np.bool_]
    if kind == "stripes":
        cover, odd = np.abs(a) < 0.27, np.floor(u) % 2 > 0.5
    elif kind == "dots":
        cover = np.hypot(a, b) < 0.30
    elif kind == "zigzag":
        cover = np.abs((v + np.abs(a)) % 1 - 0.5) < 0.22
        odd = np.floor(v + np.abs(a)) % 2 > 0.5
    elif kind == "diamonds":
        cover = np.abs(np.abs(a) + np.abs(b) - 0.30) < 0.13
    elif kind == "checks":
        cover, odd = (np.abs(a) < 0.25) | (np.abs(b) < 0.25), (np.abs(a) < 0.25) & (np.abs(b) < 0.25)
    elif kind == "leaves":
        across = np.where(odd, a + b, a - b) / 1.414
        along = np.where(odd, a - b, a + b) / 1.414
        cover = (across / 0.17) ** 2 + (along / 0.44) ** 2 < 1
        cover &= np.abs(across) > 0.018
    elif kind == "triangles":
        cover = np.abs(a) < 0.5 * (0.42 - b)
    else:
        cover, odd = np.ones_like(odd), np.floor(u) % 2 != np.floor(v) % 2
        cover = odd | (np.floor(u) % 2 > 0.5)
    image = np.broadcast_to(np.asarray(from_hex(ground), np.float32), (2 * size, 2 * size, 3))
    image = paint(image, from_hex(first), cover.astype(np.float32))
    image = _halved(paint(image, from_hex(second), (cover & odd).astype(np.float32)))
    threads = noise(size, 7, 20, 96, 0.2, (1.0, 6.0)) + noise(size, 8, 20, 96, 0.2, (6.0, 1.0))
    return finish(image * (1 + weave * threads)[..., None])


@cache
def cane(dark: str, light: str, bands: str) -> Texture:
    """Woven cane: strips over and under one another, with a coloured band. Tiles along u."""
    size = 192
    steps = (np.arange(size, dtype=np.float32) + 0.5) / size
    u, v = np.meshgrid(steps * 12, (1 - steps) * 16)
    over = (np.floor(u) + np.floor(v)) % 2 > 0.5
    along = np.where(over, u % 1, v % 1) - 0.5
    across = np.where(over, v % 1, u % 1) - 0.5
    height = (1 - 2.4 * along**2) * (1 - 2.0 * across**2)
    low, high = np.asarray(from_hex(dark), np.float32), np.asarray(from_hex(light), np.float32)
    image = low + height[..., None] * (high - low)
    band = (over & (np.abs(v - 11) < 2)).astype(np.float32)
    image = paint(image, from_hex(bands), 0.75 * band)
    return finish(image * (1 + 0.06 * noise(size, 3, 6, 90, 0.4))[..., None])


def _directions(width: int, height: int) -> tuple[Field, Field, Field, Field]:
    """Unit vectors (x, y, z) and longitudes of a sphere's texture: u around it, v from pole to pole."""
    longitude, latitude = np.meshgrid(
        (np.arange(width) + 0.5) / width * 2 * np.pi, np.pi / 2 - (np.arange(height) + 0.5) / height * np.pi
    )
    return np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude), longitude


@cache
def football(patch: str, ground: str = "#f4f3ee") -> Texture:
    """A football: twelve coloured pentagons between white hexagons. Covers a sphere once."""
    x, y, z, _ = _directions(768, 384)
    golden = (1 + np.sqrt(5)) / 2
    signs = [(p, q * golden) for p in (-1, 1) for q in (-1, 1)]
    fives = np.array([v for p, q in signs for v in ((0, p, q), (p, q, 0), (q, 0, p))])
    ones = [(p, q, r) for p in (-1, 1) for q in (-1, 1) for r in (-1, 1)]
    thirds = [(p / golden, q) for p, q in signs]
    sixes = np.array([*ones, *(v for p, q in thirds for v in ((0, q, p), (q, p, 0), (p, 0, q)))])
    points = np.stack([x, y, z], axis=-1)
    # The pentagons lie a little farther out, which makes their cells smaller.
    near_five = (points @ (fives / np.linalg.norm(fives, axis=1, keepdims=True)).T).max(axis=-1) - 0.012
    near_six = np.sort(points @ (sixes / np.linalg.norm(sixes, axis=1, keepdims=True)).T, axis=-1)
    image = np.broadcast_to(np.asarray(from_hex(ground), np.float32), (*x.shape, 3))
    seam = (near_six[..., -1] - near_six[..., -2] < 0.022) & (near_six[..., -1] > near_five)
    image = paint(image, from_hex("#55585c"), seam.astype(np.float32))
    return finish(_halved(paint(image, from_hex(patch), (near_five > near_six[..., -1]).astype(np.float32))))


@cache
def basketball(leather: str, seam: str = "#1f1c1a") -> Texture:
    """A basketball: eight panels. Covers a sphere once."""
    x, y, z, _ = _directions(768, 384)
    lines = np.minimum(np.abs(x), np.abs(z)) < 0.022
    lines |= np.abs(np.abs(y) - 0.42 - 0.34 * x**2) < 0.026
    image = np.asarray(from_hex(leather)) * (1 + 0.08 * noise((384, 768), 4, 60, 300, 0.0))[..., None]
    return finish(_halved(paint(image, from_hex(seam), lines.astype(np.float32))))


@cache
def beach_ball(colours: tuple[str, ...]) -> Texture:
    """Segments of several colours from pole to pole, with white caps. Covers a sphere once."""
    _, _, z, longitude = _directions(768, 384)
    segment = (longitude / (2 * np.pi) * len(colours)).astype(int) % len(colours)
    image = np.array([from_hex(colour) for colour in colours], np.float32)[segment]
    return finish(_halved(paint(image, from_hex("#f4f4f0"), (np.abs(z) > 0.96).astype(np.float32))))


# Longitude and latitude of a few corners of each continent: enough to be known at arm's length.
_CONTINENTS = (
    (
        (-166, 66),
        (-125, 70),
        (-82, 70),
        (-60, 52),
        (-80, 28),
        (-97, 20),
        (-84, 9),
        (-106, 22),
        (-124, 42),
        (-152, 59),
    ),
    ((-80, 8), (-60, 8), (-35, -7), (-42, -23), (-64, -42), (-70, -54), (-74, -40), (-70, -18), (-81, -4)),
    ((-9, 37), (3, 43), (15, 39), (28, 41), (40, 47), (62, 62), (40, 67), (22, 71), (6, 60), (-3, 48)),
    ((-6, 35), (10, 37), (32, 31), (43, 12), (51, 11), (40, -10), (33, -26), (20, -35), (12, -17), (9, 4), (-16, 14)),
    (
        (36, 36),
        (58, 24),
        (44, 13),
        (77, 8),
        (92, 22),
        (104, 2),
        (109, 20),
        (122, 31),
        (141, 52),
        (178, 67),
        (105, 77),
    ),
    ((36, 36), (105, 77), (68, 73), (58, 62), (40, 47)),
    ((114, -22), (131, -12), (143, -11), (153, -28), (146, -39), (131, -32), (115, -34)),
    ((-52, 60), (-22, 70), (-32, 83), (-62, 82)),
    ((-180, -90), (-180, -72), (-60, -66), (0, -71), (90, -66), (180, -72), (180, -90)),
    ((47, -25), (50, -16), (44, -19)),
    ((109, 1), (118, 6), (117, -3), (110, -3)),
    ((130, 31), (141, 36), (142, 45), (138, 37)),
)


@cache
def world_map(sea: str, land: str, lines: str) -> Texture:
    """A globe's map. Covers a sphere once."""
    width, height = 512, 256
    image = Image.new("RGB", (width, height), sea)
    draw = ImageDraw.Draw(image)
    for step in range(12):
        draw.line((width * step / 12, 0, width * step / 12, height), fill=lines)
        draw.line((0, height * step / 6, width, height * step / 6), fill=lines)
    for corners in _CONTINENTS:
        draw.polygon([((x + 180) / 360 * width, (90 - y) / 180 * height) for x, y in corners], fill=land)
    return to_texture(image)
