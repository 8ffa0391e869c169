"""Printed paper and painted goods: spines, covers, labels, photographs. Drawn as in `prints`."""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from indoor_rooms.materials.prints import to_texture, write
from indoor_rooms.materials.textures import Texture


@cache
def spine(title: str, ground: str, ink: str) -> Texture:
    """A book's spine lying on its side: its title between two bands, read from left to right."""
    width, height = 300, 48
    image = Image.new("RGB", (width, height), ground)
    draw = ImageDraw.Draw(image)
    for x in (16, width - 24):
        draw.rectangle((x, 0, x + 7, height), fill=ink)
    write(draw, (width / 2, height / 2), title, 30, ink, width * 0.72)
    return to_texture(image)


@cache
def cover(title: str, ground: str, accent: str, ink: str, style: int) -> Texture:
    """A book's or notebook's front.

    Args:
        title: words; an empty one for none.
        ground: hex colour of the board.
        accent: hex colour of the ornament.
        ink: hex colour of the title.
        style: 0 bands, 1 a large disc, 2 diagonals, 3 a lattice of dots, 4 plain with a label, 5 hills.
    """
    width, height = 240, 336
    image = Image.new("RGB", (width, height), ground)
    draw = ImageDraw.Draw(image)
    if style == 0:
        for y in (0, 210, 236, 262):
            draw.rectangle((0, y, width, y + (64 if y == 0 else 14)), fill=accent)
    elif style == 1:
        draw.ellipse((30, 130, width - 30, height - 26), fill=accent)
        draw.ellipse((76, 176, width - 76, height - 72), fill=ground)
    elif style == 2:
        for x in range(-height, width, 60):
            draw.polygon([(x, height), (x + 26, height), (x + 206, 150), (x + 180, 150)], fill=accent)
    elif style == 3:
        for x in range(24, width, 38):
            for y in range(150, height, 38):
                draw.ellipse((x - 9, y - 9, x + 9, y + 9), fill=accent)
    elif style == 4:
        draw.rectangle((44, 54, width - 44, 150), fill=accent)
    else:
        draw.ellipse((150, 130, 206, 186), fill=ink)
        draw.polygon(
            [(0, 260), (80, 170), (150, 250), (190, 215), (width, 270), (width, height), (0, height)], accent
        )
    words = title.split()
    for line, word in enumerate(words):
        write(draw, (width / 2, 76 + 42 * (line - (len(words) - 1) / 2)), word, 44, ink, width * 0.7)
    return to_texture(image)


@cache
def binder_label(title: str, accent: str) -> Texture:
    """The label on a file's spine: a title from bottom to top, ruled lines, a coloured band."""
    width, height = 80, 220
    upright = Image.new("RGB", (height, width), "#fbfaf5")
    draw = ImageDraw.Draw(upright)
    draw.rectangle((0, 0, 26, width), fill=accent)
    write(draw, (height / 2 + 8, width * 0.36), title, 40, "#26282c", height * 0.72)
    for y in (54, 66):
        draw.line((44, y, height - 14, y), fill="#b5b8bd", width=2)
    return to_texture(upright.rotate(90, expand=True))


@cache
def portrait(seed: int, people: int) -> Texture:
    """A photograph of one to three people, out of doors."""
    width, height = 192, 240
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (width, height), ("#a9d0ea", "#c9dcc0", "#e8d0b0", "#b8b4c8")[seed % 4])
    draw = ImageDraw.Draw(image)
    draw.ellipse((-80, 120, width + 80, height + 120), fill=("#6a9a50", "#8a7a5a", "#5a8a8a")[seed % 3])
    for index in range(people):
        x, size = width * (index + 1) / (people + 1), (46 if people == 1 else 30) * rng.uniform(0.85, 1.1)
        top = 0.34 * height + rng.uniform(0, 26)
        coat = ("#b5412f", "#2f5f9a", "#e8b84a", "#3a7a5a", "#f0ece2", "#5a3a6a")[int(rng.integers(6))]
        skin = ("#e8b996", "#c98f66", "#8a5a3c", "#f0cdb0")[int(rng.integers(4))]
        hair = ("#2a1c14", "#5a3a1f", "#c99a4a", "#8a8a88", "#7a2f1f")[int(rng.integers(5))]
        draw.rounded_rectangle((x - 1.3 * size, top + 1.7 * size, x + 1.3 * size, height + 40), int(size), fill=coat)
        draw.ellipse((x - 0.92 * size, top - 0.18 * size, x + 0.92 * size, top + 1.75 * size), fill=hair)
        draw.ellipse((x - 0.72 * size, top + 0.2 * size, x + 0.72 * size, top + 1.9 * size), fill=skin)
        for side in (-1, 1):
            eye = x + 0.28 * side * size
            draw.ellipse((eye - 3, top + 0.9 * size, eye + 3, top + 0.9 * size + 6), fill="#2a2422")
        draw.arc(
            (x - 0.3 * size, top + 1.1 * size, x + 0.3 * size, top + 1.55 * size), 20, 160, fill="#8a3a30", width=3
        )
    return to_texture(image)


@cache
def lettering(text: str, ground: str, ink: str, stripe: str) -> Texture:
    """A word between stripes, twice around a bottle or box. Tiles along u."""
    width, height = 360, 120
    image = Image.new("RGB", (width, height), ground)
    draw = ImageDraw.Draw(image)
    for y in (8, height - 18):
        draw.rectangle((0, y, width, y + 10), fill=stripe)
    write(draw, (width / 2, height / 2), text, 64, ink, width * 0.7)
    return to_texture(image)
