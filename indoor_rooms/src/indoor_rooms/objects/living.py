"""Things of the living room: candle, basket, cushion, photo frame."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import arc, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import grid_faces, merge, quad, smooth_normals, transform
from indoor_rooms.geometry.pieces import Pieces, standing
from indoor_rooms.materials import prints, prints_paper, prints_patterns
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import (
    BLACK_PLASTIC,
    BRASS,
    CHROME,
    PAPER,
    cloth,
    glazed,
    glossy_print,
    metallic,
    patterned,
    plastic,
    printed,
    wood,
)
from indoor_rooms.objects.shaping import PALETTE, pick, two_colours


def candle(rng: np.random.Generator) -> Pieces:
    """A candle that does not burn: a pillar on a dish, one in a glass, or a tall one on a candlestick."""
    wax = pick(
        rng, ("#f4ead0", "#f4ead0", "#f6f3ec", "#b5322c", "#3f6a4c", "#d88a3a", "#7a4f86", "#3a5f8a", "#e0a0a8")
    )
    family = int(rng.integers(3))
    if family == 0:
        radius, low, high = rng.uniform(0.03, 0.042), 0.008, rng.uniform(0.09, 0.17)
        dish = [
            (0.0, 0.0),
            (radius * 1.3, 0.0),
            (radius * 1.75, 0.012),
            (radius * 1.72, 0.015),
            (radius * 1.3, 0.007),
            (0.0, 0.007),
        ]
        holder = (lathe(smooth_profile(dish, 1), 36), glazed(pick(rng, PALETTE)) if rng.random() < 0.6 else BRASS)
    elif family == 1:
        radius, low, high = rng.uniform(0.036, 0.045), 0.007, rng.uniform(0.055, 0.075)
        wall, top = radius + 0.0035, high + 0.02
        glass = [
            (0.0, 0.0),
            (wall, 0.0),
            (wall, 0.0),
            (wall, top),
            (radius + 0.0005, top),
            (radius + 0.0005, low),
            (0.0, low - 0.0005),
        ]
        first, second = two_colours(rng)
        pattern = prints_patterns.pattern(pick(rng, prints_patterns.PATTERNS), first, second, "#f2f2ef", 4, 0.0)
        holder = (lathe(glass, 36, (2.0, 1.0)), glossy_print(pattern) if rng.random() < 0.6 else glazed(first, 0.08))
    else:
        radius, low, high = 0.011, rng.uniform(0.06, 0.15), rng.uniform(0.24, 0.32)
        stick = [
            (0.0, 0.0),
            (0.045, 0.0),
            (0.046, 0.006),
            (0.016, 0.018),
            (0.009, low * 0.5),
            (0.017, low * 0.6),
            (0.009, low * 0.75),
            (0.02, low - 0.004),
            (0.017, low + 0.008),
            (0.0, low + 0.003),
        ]
        holder = (
            lathe(smooth_profile(stick), 32),
            (BRASS, CHROME, CHROME, wood("#4a2a18", "#7a4a2a", 1), glazed("#f2f2ef"))[int(rng.integers(5))],
        )
    pool = [
        (0.0, low),
        (radius, low),
        # Where it stands it is dark; a ring just above keeps that from spreading up the wax.
        (radius, low + 0.012),
        (radius, (low + high) / 2),
        (radius * 0.97, high - 0.003),
        (radius * 0.9, high),
        (radius * 0.6, high - 0.004),
        (0.0, high - 0.006),
    ]
    wick = tube([[0, 0, high - 0.008], [0.0005, 0, high + 0.004], [0.003, 0, high + 0.010]], 0.0012, 8)
    return [holder, (lathe(pool, 32), Material(glazed(wax).colour, roughness=0.45, coat=0.1)), (wick, BLACK_PLASTIC)]


def basket(rng: np.random.Generator) -> Pieces:
    """A woven basket, round or oval, with a bow or two handles across x."""
    radius, height = rng.uniform(0.11, 0.15), rng.uniform(0.09, 0.17)
    foot, oval = radius * rng.uniform(0.72, 1.0), float(rng.choice([1.0, 0.72]))
    dark, light = (("#6a4526", "#c9a06a"), ("#4a3020", "#8a6242"), ("#b5a07a", "#efe0bc"), ("#5a5a58", "#b5b8b5"))[
        int(rng.integers(4))
    ]
    weave = patterned(prints_patterns.cane(dark, light, pick(rng, (light, light, *PALETTE))))
    wall = 0.008
    outside = smooth_profile([(foot, 0.0), (0.55 * foot + 0.5 * radius, height * 0.5), (radius, height)], 1)
    inside = outside[::-1] - [wall, 0.0]
    shell = lathe([(0.0, 0.0), *outside], 40, (3.0, 1.0))
    hollow = lathe([*inside[:-1], (inside[-1][0], wall), (0.0, wall)], 40, (3.0, 1.0))
    rim = tube(arc((0.0, 0.0, height), radius - wall / 2, 0, 360, 37, "xy"), 0.007, 8, capped=False)
    bows = []
    if rng.random() < 0.5:
        bow = arc((0.0, 0.0, 0.0), radius - 0.004, 0, 180, 20)
        bow[:, 2] *= rng.uniform(0.8, 1.1)
        bows.append(transform(tube(bow, 0.006, 8), (0.0, 0.0, height)))
    else:
        for side in (-1.0, 1.0):
            bow = arc((0.0, 0.0, 0.0), 0.035, 0, 180, 12, "yz") * [1, 1, 0.9]
            bows.append(transform(tube(bow, 0.005, 8), (side * (radius - 0.004), 0.0, height)))
    frame = plastic(light, 0.75)
    pieces = [(merge([shell, hollow]), weave), (merge([rim, *bows]), frame)]
    return [(transform(mesh, scale=(1.0, oval, 1.0)), material) for mesh, material in pieces]


def cushion(rng: np.random.Generator) -> Pieces:
    """A cushion lying, with piped edges: square or oblong, of plain or patterned cloth."""
    width = rng.uniform(0.36, 0.45)
    depth = width * float(rng.choice([1.0, 1.0, 0.7]))
    height, count = rng.uniform(0.12, 0.16), 17
    steps = np.linspace(-1, 1, count)
    a, b = np.meshgrid(steps, steps, indexing="ij")
    # Between its corners the edge is drawn in, since the filling lifts the middle.
    x, y = width / 2 * a * (1 - 0.07 * (1 - b**2)), depth / 2 * b * (1 - 0.07 * (1 - a**2))
    puff = ((1 - a**2) * (1 - b**2)) ** 0.42
    below = 0.4 * height
    dent = 1 - rng.uniform(0.0, 0.16) * np.exp(-((a - rng.uniform(-0.2, 0.2)) ** 2 + b**2) / 0.12)
    uvs = np.stack([a, b], axis=-1).reshape(-1, 2) / 2 + 0.5
    faces = grid_faces(count, count)
    sheets = []
    for z, winding in (
        ((height - below) * puff * dent, faces),
        (-below * np.minimum(1.15 * puff, 1.0), faces[:, ::-1]),
    ):
        sheets.append(smooth_normals(np.stack([x, y, z], axis=-1).reshape(-1, 3), uvs, winding))
    rim = np.concatenate(
        [
            np.stack(p, axis=-1)
            for p in (
                (x[0, ::-1], y[0, ::-1]),
                (x[1:, 0], y[1:, 0]),
                (x[-1, 1:], y[-1, 1:]),
                (x[-2::-1, -1], y[-2::-1, -1]),
            )
        ]
    )
    piping = tube(np.column_stack([rim, np.zeros(len(rim))]), 0.0042, 6, capped=False)
    ground, first = two_colours(rng)
    second = pick(rng, PALETTE)
    if rng.random() < 0.12:
        stuff = cloth(ground)
    else:
        kind = pick(rng, prints_patterns.PATTERNS)
        stuff = patterned(prints_patterns.pattern(kind, ground, first, second, int(rng.choice([4, 6, 8]))))
    return standing([(merge(sheets), stuff), (piping, cloth(first if rng.random() < 0.6 else ground))])


def photo_frame(rng: np.random.Generator) -> Pieces:
    """A framed photograph leaning back on its support, its front towards -y."""
    width, height = rng.uniform(0.13, 0.19), rng.uniform(0.17, 0.24)
    if rng.random() < 0.3:
        width, height = height, width
    rim, depth, lean = rng.uniform(0.012, 0.028), rng.uniform(0.01, 0.018), rng.uniform(10.0, 17.0)
    look = (
        wood("#4a2a18", "#7a4a2a", int(rng.integers(3))),
        wood("#b98a57", "#e0b985", 5),
        metallic(pick(rng, ("#c9ccd0", "#d8b45a", "#3a3d42"))),
        plastic(pick(rng, PALETTE), 0.25),
    )[int(rng.integers(4))]
    bars = [
        transform(rounded_box((width, depth, rim), 0.002, 1, 3.0), (0.0, 0.0, z)) for z in (rim / 2, height - rim / 2)
    ]
    bars += [
        transform(rounded_box((rim, depth * 0.98, height - 1.6 * rim), 0.002, 1, 3.0), (x, 0.0, height / 2))
        for x in (-(width - rim) / 2, (width - rim) / 2)
    ]
    back = transform(rounded_box((width - rim, 0.004, height - rim), 0.001), (0.0, depth / 2 - 0.003, height / 2))
    mat = float(rng.choice([0.0, 0.014, 0.022]))
    inner_x, inner_z = width / 2 - rim, height / 2 - rim
    passepartout = quad((-inner_x, depth / 2 - 0.006, rim), (2 * inner_x, 0, 0), (0, 0, 2 * inner_z))
    seed = int(rng.integers(12))
    picture = prints_paper.portrait(seed, 1 + seed % 3) if seed < 8 else prints.painting(seed, 128)
    photo = quad(
        (-inner_x + mat, depth / 2 - 0.0068, rim + mat), (2 * (inner_x - mat), 0, 0), (0, 0, 2 * (inner_z - mat))
    )
    framed: Pieces = [
        (merge(bars), look),
        (back, BLACK_PLASTIC),
        (passepartout, PAPER),
        (photo, printed(picture, 0.2)),
    ]
    framed = standing([(transform(mesh, rotate=(-lean, 0.0, 0.0)), material) for mesh, material in framed])
    # From two thirds up the back the leg comes down as far behind as the frame leans.
    joint = np.array([0.0, depth / 2 * np.cos(np.radians(lean)), 0.0])
    high = 0.62 * height
    joint += [0.0, high * np.sin(np.radians(lean)), high * np.cos(np.radians(lean))]
    foot = joint[1] + 0.3 * height
    length = float(np.hypot(joint[2], foot - joint[1]))
    leg = transform(
        rounded_box((0.03, 0.003, length), 0.001, base=True),
        (0.0, foot, 0.0015),
        (np.degrees(np.arctan2(foot - joint[1], joint[2])), 0.0, 0.0),
    )
    return standing([*framed, (leg, BLACK_PLASTIC)])
