"""Printed things: packaging labels, book covers, a painting, a clock face and the view out of the window.

Drawn with Pillow, in its built-in font, so that they look the same everywhere. (H, W, 3) float32 linear RGB, cached,
covering their surface once.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from indoor_rooms.materials.material import from_hex
from indoor_rooms.materials.noise import blend, finish, noise, paint
from indoor_rooms.materials.textures import Texture

_DISPLAY = np.arange(256) / 255
_TO_LINEAR = np.where(_DISPLAY <= 0.04045, _DISPLAY / 12.92, ((_DISPLAY + 0.055) / 1.055) ** 2.4).astype(np.float32)


def to_texture(image: Image.Image) -> Texture:
    """A drawn picture as a texture, (H, W, 3) float32 linear RGB."""
    return finish(_TO_LINEAR[np.asarray(image.convert("RGB"))])


def write(
    draw: ImageDraw.ImageDraw, centre: tuple[float, float], text: str, height: float, colour: str, width: float
) -> None:
    """Writes a line centred at a place, as large as `height` and `width` (pixels) allow."""
    font = ImageFont.load_default(size=height)
    wide = draw.textlength(text, font=font)
    if wide > width:
        font = ImageFont.load_default(size=height * width / wide)
    draw.text(centre, text, fill=colour, font=font, anchor="mm", stroke_width=max(1, int(height / 24)))


@cache
def cereal_box(brand: str, ground: str, accent: str, seed: int = 0) -> Texture:
    """The front of a cereal box: the brand over a bowl of rings."""
    width, height = 384, 560
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (width, height), ground)
    draw = ImageDraw.Draw(image)
    for ray in range(0, 360, 24):
        draw.pieslice((-260, -80, width + 260, height + 440), ray, ray + 12, fill=accent)
    draw.ellipse((20, 40, width - 20, 220), fill="#ffffff")
    draw.ellipse((28, 48, width - 28, 212), fill=ground)
    write(draw, (width / 2, 130), brand, 92, "#ffffff", width * 0.72)
    draw.ellipse((56, 300, width - 56, 400), fill="#fdf6e6")
    for _ in range(46):
        angle, distance = rng.uniform(0, 2 * np.pi), np.sqrt(rng.uniform())
        x, y = width / 2 + 118 * distance * np.cos(angle), 345 + 34 * distance * np.sin(angle)
        draw.ellipse((x - 17, y - 13, x + 17, y + 13), fill="#d28a34", outline="#8a4f16", width=2)
        draw.ellipse((x - 5, y - 4, x + 5, y + 4), fill="#fdf6e6")
    draw.chord((56, 260, width - 56, 500), 0, 180, fill="#f8f8f6", outline="#c8c8c8", width=3)
    draw.rectangle((0, height - 56, width, height), fill=ground)
    write(draw, (width / 2, height - 28), "WHOLE GRAIN  500 g", 30, "#ffffff", width * 0.8)
    return to_texture(image)


@cache
def milk_carton(brand: str, ground: str) -> Texture:
    """One side of a milk carton: white, a coloured wave, the brand."""
    width, height = 256, 512
    image = Image.new("RGB", (width, height), "#f7f8fa")
    draw = ImageDraw.Draw(image)
    wave = [(x, 350 + 26 * np.sin(x / width * 2 * np.pi)) for x in range(width + 1)]
    draw.polygon([*wave, (width, height), (0, height)], fill=ground)
    draw.rectangle((0, 0, width, 90), fill=ground)
    write(draw, (width / 2, 200), brand, 88, ground, width * 0.86)
    write(draw, (width / 2, 280), "fresh  1 l", 36, "#5a6470", width * 0.6)
    draw.ellipse((width / 2 - 34, 400, width / 2 + 34, 468), fill="#f7f8fa")
    return to_texture(image)


@cache
def wrap_label(title: str, ground: str, accent: str, ink: str, seed: int = 0) -> Texture:
    """A label that goes twice around a can, jar or bottle: title, band and fruit or vegetables. Tiles along u."""
    width, height = 512, 300
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (width, height), ground)
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 0, width, 22), fill=accent)
    draw.rectangle((0, height - 22, width, height), fill=accent)
    write(draw, (width / 2, 92), title, 100, ink, width * 0.6)
    draw.ellipse((width / 2 - 120, 150, width / 2 + 120, 270), fill=ink)
    for _ in range(26):
        x, y = width / 2 + rng.uniform(-80, 80), 210 + rng.uniform(-34, 34)
        radius = rng.uniform(10, 20)
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=accent, outline=ground, width=2)
    return to_texture(image)


@cache
def book_cover(title: str, ground: str, accent: str, seed: int = 0) -> Texture:
    """A cookery book's cover."""
    width, height = 320, 448
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (width, height), ground)
    draw = ImageDraw.Draw(image)
    draw.rectangle((18, 18, width - 18, height - 18), outline=accent, width=6)
    lines = title.split()
    for line, word in enumerate(lines):
        write(draw, (width / 2, 84 + 62 * line), word, 60, "#fff6e4", width * 0.8)
    for _ in range(7):
        x, y, radius = rng.uniform(80, width - 80), rng.uniform(290, 390), rng.uniform(18, 40)
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=accent)
    return to_texture(image)


@cache
def clock_face() -> Texture:
    """A round clock's face, twelve at the top."""
    size = 256
    image = Image.new("RGB", (size, size), "#f7f4ec")
    draw = ImageDraw.Draw(image)
    for hour in range(1, 13):
        angle = np.radians(30 * hour)
        centre = (size / 2 + 96 * np.sin(angle), size / 2 - 96 * np.cos(angle))
        write(draw, centre, str(hour), 34, "#23262a", 60)
    return to_texture(image)


@cache
def painting(seed: int = 0, size: int = 512) -> Texture:
    """A landscape: sky, two ranges of hills, a field."""
    down = np.broadcast_to((np.arange(size, dtype=np.float32)[:, None] + 0.5) / size, (size, size))
    brush = noise(size, seed, 8, 120, 0.8, (1.0, 5.0))
    image = blend(from_hex("#6fa8d6"), from_hex("#f6d9b0"), down * 1.7 + 0.05 * brush)
    layers = (
        ("#5f7f9a", "#7d9ab0", 0.46, 0.05),
        ("#3f6b45", "#6d9a58", 0.58, 0.06),
        ("#c99a3c", "#ecd07a", 0.76, 0.03),
    )
    for index, (dark, light, level, height) in enumerate(layers):
        ridge = level + height * noise((1, size), seed + 10 + index, 1, 9, 1.5)[0]
        cover = np.clip((down - ridge[None]) * 90, 0, 1)[..., None]
        ground = blend(from_hex(dark), from_hex(light), 0.5 + 0.22 * brush + 0.8 * (down - level))
        image = image * (1 - cover) + ground * cover
    sun = np.clip((0.07 - np.hypot(down - 0.26, down.T - 0.7)) * 80, 0, 1)
    return finish(paint(image, from_hex("#fff3cf"), 0.9 * sun))


@cache
def outside_view(seed: int = 0, size: int = 512) -> Texture:
    """A garden out of the window: sky with clouds, far trees, a hedge and a lawn. Seamless from left to right."""
    down = np.broadcast_to((np.arange(size, dtype=np.float32)[:, None] + 0.5) / size, (size, size))
    image = blend(from_hex("#a9d4fa"), from_hex("#f3f9fd"), down * 2.0)
    clouds = np.clip(noise(size, seed, 2, 60, 1.6, (1.0, 2.0)) - 0.3, 0, 1) * np.clip((0.45 - down) * 5, 0, 1)
    image = paint(image, from_hex("#ffffff"), 0.85 * clouds)
    foliage = noise(size, seed + 1, 8, 200, 0.8)
    layers = (
        ("#9db8a4", "#bdd0bb", 0.47, 0.022),
        ("#5f8a45", "#a5c672", 0.57, 0.030),
        ("#8fbb5a", "#bfdd86", 0.70, 0.004),
    )
    for index, (dark, light, level, height) in enumerate(layers):
        outline = noise((1, size), seed + 20 + index, 2, 120, 1.0)[0]
        cover = np.clip((down - (level + height * outline)[None]) * 160, 0, 1)[..., None]
        leaves = blend(from_hex(dark), from_hex(light), 0.45 + (0.24 if index < 2 else 0.08) * foliage)
        image = image * (1 - cover) + leaves * cover
    return finish(image)
