"""What is shown and printed on devices: screens, keys, dials, grilles. Drawn as in `prints`."""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from indoor_rooms.materials.prints import to_texture, write
from indoor_rooms.materials.textures import Texture

APP_COLOURS = ("#e8453c", "#f2a33a", "#f7d046", "#4fb35a", "#3f8fe0", "#7a5fd0", "#e86aa0", "#f4f4f4", "#2f3a48")
WALLPAPERS = (
    ("#1f4f8f", "#7fc0e8"),
    ("#3a1f5f", "#e87a8a"),
    ("#0f3f3a", "#8fd0a0"),
    ("#7a2f1f", "#f2b86a"),
    ("#20242c", "#6a7686"),
)


@cache
def key_grid(labels: tuple[tuple[str, ...], ...], fills: tuple[tuple[str, ...], ...], ink: str) -> Texture:
    """Keys in rows from top to bottom, a cell of one colour and a label for each; all rows equally long."""
    side = 44
    image = Image.new("RGB", (side * len(labels[0]), side * len(labels)))
    draw = ImageDraw.Draw(image)
    for row, (names, colours) in enumerate(zip(labels, fills, strict=True)):
        for column, (name, colour) in enumerate(zip(names, colours, strict=True)):
            x, y = column * side, row * side
            draw.rectangle((x, y, x + side, y + side), fill=colour)
            if name:
                write(draw, (x + side / 2, y + side / 2), name, 24, ink, side * 0.66)
    return to_texture(image)


def _wallpaper(width: int, height: int, seed: int) -> Image.Image:
    """A soft gradient with a few large round shapes."""
    rng = np.random.default_rng(seed)
    low, high = (np.array(_rgb(code)) for code in WALLPAPERS[seed % len(WALLPAPERS)])
    y, x = np.mgrid[0:height, 0:width]
    amount = 0.6 * y / height + 0.3 * x / width
    for _ in range(4):
        distance = np.hypot(x - rng.uniform(0, width), y - rng.uniform(0, height))
        amount = amount + rng.uniform(-0.25, 0.25) * (distance < rng.uniform(0.2, 0.5) * height)
    mixed = high + np.clip(amount, 0, 1)[..., None] * (low - high)
    return Image.fromarray(mixed.astype(np.uint8))


def _rgb(code: str) -> tuple[int, int, int]:
    return (int(code[1:3], 16), int(code[3:5], 16), int(code[5:7], 16))


@cache
def phone_screen(seed: int) -> Texture:
    """A telephone's home screen: the time, rows of icons, a dock."""
    width, height = 150, 310
    rng = np.random.default_rng(seed)
    image = _wallpaper(width, height, seed)
    draw = ImageDraw.Draw(image)
    write(
        draw, (width / 2, 42), f"{int(rng.integers(7, 22))}:{int(rng.integers(10, 60))}", 40, "#ffffff", width * 0.8
    )
    draw.rounded_rectangle((8, height - 48, width - 8, height - 8), 10, fill="#dfe3e8")
    for row in (*range(int(rng.integers(3, 5))), 5):
        top = height - 44 if row == 5 else 84 + 42 * row
        for column in range(4):
            left = 13 + 32.5 * column
            colour = APP_COLOURS[int(rng.integers(len(APP_COLOURS)))]
            draw.rounded_rectangle((left, top, left + 26, top + 28), 7, fill=colour)
            draw.ellipse(
                (left + 8, top + 9, left + 18, top + 19), fill="#ffffff" if colour != "#f4f4f4" else "#3f8fe0"
            )
    return to_texture(image)


@cache
def laptop_screen(seed: int) -> Texture:
    """A computer's screen: windows with a text, a chart or a program, over a wallpaper."""
    width, height = 320, 200
    rng = np.random.default_rng(100 + seed)
    image = _wallpaper(width, height, seed)
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, height - 14, width, height), fill="#e4e7ea")
    for index in range(7):
        draw.rounded_rectangle((100 + 18 * index, height - 12, 110 + 18 * index, height - 2), 2, APP_COLOURS[index])
    if seed % 4 == 3:
        return to_texture(image)
    left, top = int(rng.integers(14, 40)), int(rng.integers(8, 24))
    dark = seed % 2 == 1
    page, ink = ("#22262e", "#9fb6c8") if dark else ("#fbfbf8", "#5a626a")
    draw.rectangle((left, top, width - left, height - 24), fill=page)
    draw.rectangle((left, top, width - left, top + 12), fill="#3a4048" if dark else "#d5d9de")
    for index, colour in enumerate(("#e8453c", "#f2b03a", "#4fb35a")):
        draw.ellipse((left + 4 + 9 * index, top + 3, left + 10 + 9 * index, top + 9), fill=colour)
    for row in range(int((height - 46 - top) / 8)):
        y = top + 18 + 8 * row
        indent = 8 + 10 * int(rng.integers(3)) * dark
        colour = APP_COLOURS[int(rng.integers(5))] if dark and rng.random() < 0.5 else ink
        draw.rectangle((left + indent, y, left + indent + rng.uniform(40, 120), y + 3), fill=colour)
    for index in range(6):
        tall, x = rng.uniform(14, 90), width - left - 96 + 14 * index
        draw.rectangle((x, height - 34 - tall, x + 9, height - 34), fill=APP_COLOURS[index])
    return to_texture(image)


@cache
def digits(text: str, ink: str, ground: str) -> Texture:
    """A display with a number."""
    width, height = 40 * len(text) + 24, 84
    image = Image.new("RGB", (width, height), ground)
    write(ImageDraw.Draw(image), (width / 2, height / 2), text, 66, ink, width * 0.86)
    return to_texture(image)


@cache
def dial(style: str, ground: str, ink: str) -> Texture:
    """A clock's face without hands, twelve at the top.

    Args:
        style: "numbers", "quarters", "roman" or "strokes".
        ground: hex colour of the face.
        ink: hex colour of figures and strokes.
    """
    size = 200
    image = Image.new("RGB", (size, size), ground)
    draw = ImageDraw.Draw(image)
    roman = ("I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX", "X", "XI", "XII")
    for minute in range(60):
        x, y = np.sin(np.radians(6 * minute)), -np.cos(np.radians(6 * minute))
        near = 0.86 if minute % 5 else (0.7 if style == "strokes" else 0.82)
        ends = [(size / 2 + size / 2 * reach * x, size / 2 + size / 2 * reach * y) for reach in (near, 0.92)]
        draw.line(ends, fill=ink, width=5 if minute % 5 == 0 else 1)
        hour = minute // 5 or 12
        if minute % 5 or style == "strokes" or (style == "quarters" and hour % 3):
            continue
        place = (size / 2 + 0.62 * size / 2 * x, size / 2 + 0.62 * size / 2 * y)
        write(draw, place, roman[hour - 1] if style == "roman" else str(hour), 30, ink, 40)
    return to_texture(image)


@cache
def grille(ground: str, hole: str, slots: bool) -> Texture:
    """A loudspeaker's front: a lattice of holes, or bars across. Tiles."""
    size, pitch = 96, 12
    image = Image.new("RGB", (size, size), ground)
    draw = ImageDraw.Draw(image)
    for y in range(0, size, pitch):
        if slots:
            draw.rectangle((0, y + 3, size, y + 8), fill=hole)
            continue
        for x in range(0, size, pitch):
            draw.ellipse((x + 3, y + 3, x + 9, y + 9), fill=hole)
    return to_texture(image)


@cache
def tuning_scale(ground: str, ink: str) -> Texture:
    """A radio's scale of frequencies, with its red needle."""
    width, height = 256, 72
    image = Image.new("RGB", (width, height), ground)
    draw = ImageDraw.Draw(image)
    for index in range(33):
        x = 16 + 7 * index
        draw.line((x, 30, x, 44 if index % 4 else 54), fill=ink, width=2)
    for index, name in enumerate(("88", "92", "96", "100", "104", "108")):
        write(draw, (22 + 42 * index, 16), name, 20, ink, 36)
    draw.line((150, 4, 150, 66), fill="#e03a2c", width=4)
    return to_texture(image)
