"""Pictures of office and shelf: book spines, a whiteboard's writing, a slide, sheets of paper.

Drawn with Pillow like `prints`; (H, W, 3) float32 linear RGB, cached, covering their surface once.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from indoor_rooms.materials.prints import to_texture, write
from indoor_rooms.materials.textures import Texture

# Spines side by side in one texture, each with its own colours and title.
SPINES = 16
_TITLES = (
    "ATLAS", "RIVERS", "OPTICS", "LOGIC", "THE SEA", "GARDENS", "NOVEL", "POEMS", "CITIES", "BIRDS", "MOTION",
    "LIGHT", "HISTORY", "ALGEBRA", "TRAVELS", "STARS", "WINTER", "ISLANDS", "MUSIC", "PLANETS",
)  # fmt: skip
_CLOTHS = (
    "#7d2f2a", "#2f4f6e", "#3f6b4c", "#c9a24a", "#e6dcc6", "#4a3b5c", "#b5562f", "#22282e", "#8a9aa6", "#d9d4c8",
    "#5a2340", "#1f6f78", "#a8b08a", "#c23b3b", "#35507f", "#efe6d2", "#6b4a2e", "#de8c3a", "#2a4038", "#9c6b7a",
)  # fmt: skip
_INK = ("#1f3f8f", "#b3261e", "#1d7a43", "#26282b")


@cache
def book_spines(seed: int = 0) -> Texture:
    """`SPINES` upright spines side by side: u across them, v upwards; each has a plain strip at its edges."""
    rng = np.random.default_rng(seed)
    cell, height = 48, 512
    sheet = Image.new("RGB", (cell * SPINES, height))
    colours, titles = rng.permutation(len(_CLOTHS)), rng.permutation(len(_TITLES))
    for index in range(SPINES):
        ground = _CLOTHS[colours[index]]
        dark = sum(int(ground[start : start + 2], 16) for start in (1, 3, 5)) < 390
        ink = "#efe3c2" if dark else "#3a2c20"
        # Drawn lying, then turned: titles run from top to bottom.
        spine = Image.new("RGB", (height, cell), ground)
        draw = ImageDraw.Draw(spine)
        style = rng.integers(4)
        if style == 0:
            for x in (30, 44, height - 50, height - 36):
                draw.rectangle((x, 5, x + 5, cell - 6), fill=ink)
        elif style == 1:
            draw.rectangle((60, 5, 330, cell - 6), fill=_CLOTHS[colours[(index + 5) % len(_CLOTHS)]])
            ink = "#f4ecd8"
        elif style == 2:
            draw.rectangle((height - 90, 5, height - 40, cell - 6), fill=ink)
        write(draw, (195, cell / 2), _TITLES[titles[index]], 30, ink, 240)
        draw.rectangle((400, cell / 2 - 4, 440, cell / 2 + 4), fill=ink)
        sheet.paste(spine.transpose(Image.Transpose.ROTATE_270), (index * cell, 0))
    return to_texture(sheet)


@cache
def whiteboard_writing(seed: int = 0, width: int = 768, height: int = 512) -> Texture:
    """A whiteboard after a meeting: a heading, a list, boxes with arrows, a curve."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (width, height), "#f6f7f7")
    draw = ImageDraw.Draw(image)
    heading = ("PLAN", "TO DO", "IDEAS", "WEEK 12", "GOALS")[rng.integers(5)]
    blue, red, green, black = (_INK[index] for index in rng.permutation(4))
    write(draw, (width * 0.22, height * 0.12), heading, 52, blue, width * 0.3)
    draw.line((width * 0.08, height * 0.19, width * 0.36, height * 0.2), fill=blue, width=4)
    for row in range(int(rng.integers(3, 6))):
        y = height * (0.30 + 0.11 * row)
        draw.ellipse((width * 0.07, y - 5, width * 0.07 + 10, y + 5), fill=red)
        _scrawl(draw, rng, width * 0.10, y, width * rng.uniform(0.16, 0.30), black)
    boxes = [(0.52, 0.16), (0.76, 0.16), (0.76, 0.42)]
    for index, (x, y) in enumerate(boxes):
        corner = (width * x, height * y, width * (x + 0.15), height * (y + 0.13))
        draw.rounded_rectangle(corner, 8, outline=green, width=4)
        _scrawl(draw, rng, corner[0] + 14, (corner[1] + corner[3]) / 2, width * 0.11, black)
        if index:
            last = boxes[index - 1]
            start = (
                width * (last[0] + 0.075 + 0.08 * (index == 1)),
                height * (last[1] + 0.065 + 0.07 * (index == 2)),
            )
            stop = (width * (x + 0.075 - 0.08 * (index == 1)), height * (y + 0.065 - 0.07 * (index == 2)))
            draw.line((*start, *stop), fill=red, width=4)
            draw.ellipse((stop[0] - 6, stop[1] - 6, stop[0] + 6, stop[1] + 6), fill=red)
    left, low = width * 0.5, height * 0.88
    draw.line((left, height * 0.56, left, low, width * 0.7, low), fill=black, width=4)
    rise = rng.uniform(1.2, 2.6)
    curve = [(left + width * 0.19 * t, low - height * 0.28 * t**rise) for t in np.linspace(0, 1, 30)]
    draw.line(curve, fill=blue, width=4)
    return to_texture(image)


def _scrawl(draw: ImageDraw.ImageDraw, rng: np.random.Generator, x: float, y: float, length: float, ink: str) -> None:
    """A line of handwriting too small to read: words of waves."""
    end = x + length
    while x < end:
        word = min(float(rng.uniform(18, 60)), end - x)
        steps = np.linspace(0, 1, max(6, int(word / 2.5)))
        phase = rng.uniform(0, 6)
        wave = 6 * np.sin(steps * word / 2.6 + phase) * (0.6 + 0.4 * np.sin(steps * 9 + phase))
        draw.line(list(zip(x + steps * word, y + wave, strict=True)), fill=ink, width=3)
        x += word + 12


@cache
def slide(seed: int = 0, width: int = 640, height: int = 360) -> Texture:
    """A presentation's slide: a title, a few lines, a bar chart."""
    rng = np.random.default_rng(seed)
    ground, ink, accent = (("#f5f7fa", "#1f3550", "#2f7fc1"), ("#14304d", "#f2f5f8", "#f0a63a"))[rng.integers(2)]
    image = Image.new("RGB", (width, height), ground)
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 0, width, 12), fill=accent)
    title = ("RESULTS", "ROADMAP", "OVERVIEW", "BUDGET")[rng.integers(4)]
    write(draw, (width * 0.27, height * 0.17), title, 46, ink, width * 0.44)
    for row in range(4):
        y = height * (0.36 + 0.13 * row)
        draw.rectangle((width * 0.07, y, width * 0.085, y + 10), fill=accent)
        draw.rectangle((width * 0.11, y, width * (0.11 + rng.uniform(0.18, 0.33)), y + 9), fill=ink)
    low = height * 0.86
    for bar in range(5):
        x, tall = width * (0.55 + 0.08 * bar), height * rng.uniform(0.15, 0.55)
        draw.rectangle((x, low - tall, x + width * 0.055, low), fill=accent if bar % 2 else ink)
    draw.line((width * 0.53, low, width * 0.95, low), fill=ink, width=3)
    return to_texture(image)


@cache
def note(seed: int = 0, width: int = 160, height: int = 220) -> Texture:
    """A sheet of paper with lines of print, some with a picture or a heading."""
    rng = np.random.default_rng(seed)
    paper = ("#f7f5ee", "#f7f5ee", "#fbe98a", "#cfe6f4", "#f6d3d0", "#dcefcf")[rng.integers(6)]
    image = Image.new("RGB", (width, height), paper)
    draw = ImageDraw.Draw(image)
    write(
        draw, (width / 2, 24), ("NOTICE", "MENU", "MEMO", "LIST", "MAP")[rng.integers(5)], 24, "#26303a", width * 0.8
    )
    y = 52
    if rng.random() < 0.5:
        draw.rectangle((18, y, width - 18, y + 62), fill=_CLOTHS[rng.integers(len(_CLOTHS))])
        y += 76
    while y < height - 18:
        draw.line((18, y, 18 + (width - 36) * rng.uniform(0.5, 1.0), y), fill="#6a7078", width=4)
        y += 14
    return to_texture(image)
