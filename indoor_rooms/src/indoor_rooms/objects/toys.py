"""Teddy bear, ball, globe."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.curves import arc, lathe, sphere, tube
from indoor_rooms.geometry.mesh import merge, transform
from indoor_rooms.geometry.pieces import Pieces, placed, standing
from indoor_rooms.materials import prints_patterns
from indoor_rooms.materials.surfaces import (
    BLACK_PLASTIC,
    BRASS,
    CHROME,
    cloth,
    glossy_print,
    plastic,
    printed,
    rubber,
    wood,
)
from indoor_rooms.objects.shaping import PALETTE, blob, pick, two_colours


def teddy_bear(rng: np.random.Generator) -> Pieces:
    """A teddy bear sitting, its face towards -y, perhaps with a bow."""
    fur = pick(rng, ("#a8703a", "#7a4a28", "#d8b07a", "#efe2c8", "#8a8682", "#4a3428", "#e8b8c0", "#9fb8d0"))
    snout = pick(rng, ("#f0dcb4", "#e8d8c0", "#d8b88a"))
    fat, big = rng.uniform(0.9, 1.12), rng.uniform(0.92, 1.1)
    head_z = 0.175 + 0.012 * big
    body = [
        blob((0, 0, 0.085), (0.062 * fat, 0.052 * fat, 0.085), 20),
        blob((0, -0.004, head_z + 0.02), (0.058 * big, 0.05 * big, 0.052 * big), 20),
    ]
    for side in (-1, 1):
        body.append(blob((side * 0.045 * big, 0.004, head_z + 0.062 * big), (0.021, 0.012, 0.021), 14))
        arm = transform(blob((0, 0, 0), (0.023, 0.024, 0.055), 14), rotate=(-28.0, side * rng.uniform(-48, -26), 0.0))
        body.append(transform(arm, (side * 0.075 * fat, -0.022, 0.115)))
        leg = transform(blob((0, 0, 0), (0.029, 0.06, 0.028), 14), rotate=(0.0, 0.0, side * rng.uniform(14, 30)))
        body.append(transform(leg, (side * 0.052, -0.064, 0.028)))
    pale = [blob((0, -0.05 * big, head_z + 0.008), (0.027, 0.02, 0.021), 14)]
    for side in (-1, 1):
        pale.append(blob((side * 0.045 * big, -0.005, head_z + 0.061 * big), (0.013, 0.0075, 0.013), 10))
        pale.append(blob((side * 0.074, -0.121, 0.03), (0.017, 0.006, 0.018), 12))
    dark = [blob((side * 0.021, -0.047 * big, head_z + 0.034), (0.006, 0.006, 0.0065), 10) for side in (-1, 1)]
    dark.append(blob((0, -0.068 * big, head_z + 0.016), (0.010, 0.008, 0.007), 10))
    pieces: Pieces = [(merge(body), cloth(fur)), (merge(pale), cloth(snout)), (merge(dark), BLACK_PLASTIC)]
    if rng.random() < 0.65:
        y, z = -0.052 * fat, 0.158
        loops = [
            transform(blob((0, 0, 0), (0.021, 0.008, 0.013), 12), (side * 0.02, y, z), (0.0, side * 14.0, 0.0))
            for side in (-1, 1)
        ]
        band = arc((0, 0, 0.158), 0.047, 0, 360, 25, "xy") * [1, 0.92, 1]
        knot = blob((0, y - 0.004, z), (0.008, 0.007, 0.008), 10)
        pieces.append((merge([*loops, knot, tube(band, 0.006, 8, capped=False)]), plastic(pick(rng, PALETTE), 0.6)))
    return standing(placed(pieces, scale=rng.uniform(0.95, 1.35)))


def ball(rng: np.random.Generator) -> Pieces:
    """A football, basketball or beach ball, turned at will."""
    family, first, second = int(rng.integers(3)), *two_colours(rng)
    if family == 0:
        look, radius = printed(prints_patterns.football(pick(rng, ("#232427", "#232427", first))), 0.4), 0.11
    elif family == 1:
        leather = pick(rng, ("#c8642a", "#d8742f", "#a84f24", first))
        look, radius = printed(prints_patterns.basketball(leather), 0.6), 0.12
    else:
        colours = (
            (first, "#f4f4f0", second, "#f4f4f0")
            if rng.random() < 0.5
            else (first, second, pick(rng, PALETTE), first, second, "#f4f4f0")
        )
        look, radius = glossy_print(prints_patterns.beach_ball(colours), 0.3), rng.uniform(0.1, 0.14)
    tumble = tuple(float(angle) for angle in rng.uniform(0, 360, 3))
    turned = transform(transform(sphere(radius, 48), (0.0, 0.0, -radius)), rotate=(tumble[0], tumble[1], tumble[2]))
    return standing([(turned, look)])


def globe(rng: np.random.Generator) -> Pieces:
    """A globe on its stand, its axis slanting."""
    radius = rng.uniform(0.085, 0.12)
    sea, land, lines = (
        ("#2f7fc0", "#c9b45a", "#7fb8e0"),
        ("#6fb0d8", "#5a9a4a", "#a8d0e8"),
        ("#e0cfa0", "#a87a3e", "#c9b07a"),
        ("#1f3f6a", "#d8a04a", "#3f6a9a"),
        ("#23262b", "#c9ccd0", "#4a4f58"),
    )[int(rng.integers(5))]
    gap, foot = 0.014, rng.uniform(0.025, 0.05)
    centre = foot + radius + gap + 0.012
    turn = rng.uniform(0, 360)
    ball = transform(
        transform(sphere(radius, 44), (0.0, 0.0, -radius), (0.0, 0.0, turn)), (0, 0, centre), (0, 23.4, 0)
    )
    frame = arc((0.0, 0.0, centre), radius + gap, 66.6, 66.6 - 180.0, 28)
    axle = [
        np.array(
            [
                side * (radius + reach) * np.cos(np.radians(66.6)),
                0.0,
                centre + side * (radius + reach) * np.sin(np.radians(66.6)),
            ]
        )
        for side, reach in ((1, gap + 0.004), (1, -0.004), (-1, -0.004), (-1, gap + 0.004))
    ]
    pins = [tube([axle[0], axle[1]], 0.0035, 10), tube([axle[2], axle[3]], 0.0035, 10)]
    metal = BRASS if rng.random() < 0.5 else CHROME
    stand = wood("#4a2a18", "#7a4a2a", 2) if rng.random() < 0.5 else rubber("#26272a")
    base = radius * rng.uniform(0.6, 0.75)
    profile = [
        (0.0, 0.0),
        (base, 0.0),
        (base, 0.012),
        (base * 0.5, 0.018),
        (0.012, foot * 0.8 + 0.004),
        (0.009, foot + 0.013),
    ]
    return [
        (ball, printed(prints_patterns.world_map(sea, land, lines), 0.3)),
        (merge([tube(frame, 0.0045, 10), *pins]), metal),
        (lathe([*profile, (0.0, foot + 0.013)], 32), stand),
    ]
