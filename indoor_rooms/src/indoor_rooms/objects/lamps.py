"""Table lamps and desk lamps, not lit."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, lathe, smooth_profile, sphere, tube
from indoor_rooms.geometry.mesh import Mesh, merge, transform
from indoor_rooms.geometry.pieces import Pieces, standing
from indoor_rooms.materials import prints_patterns
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import (
    BLACK_PLASTIC,
    BRASS,
    CHROME,
    beech,
    cloth,
    glazed,
    glossy_print,
    metallic,
    patterned,
    plastic,
    wood,
)
from indoor_rooms.objects.shaping import PALETTE, pick, two_colours

_SHADES = (
    "#f2ead6",
    "#efe6d2",
    "#f6f4ee",
    "#e0682a",
    "#c8588f",
    "#3f8a7c",
    "#3a3f78",
    "#eab02e",
    "#8a4a32",
    "#c9a77a",
)


def _shade(radius_low: float, radius_high: float, low: float, high: float, waist: float) -> Mesh:
    """A lampshade, open above and below, 2 mm thick; `waist` < 1 draws its middle in."""
    middle = (radius_low + radius_high) / 2 * waist
    outside = smooth_profile([(radius_low, low), (middle, (low + high) / 2), (radius_high, high)], 1)
    inside = outside[::-1] - [0.002, 0.0]
    return lathe(np.concatenate([outside, inside, outside[:1]]), 40, (4.0, 1.0))


def lamp(rng: np.random.Generator) -> Pieces:
    """A table lamp, not lit: a foot of some shape with a cloth shade, or a desk lamp on an arm towards -y."""
    if rng.random() < 0.25:
        return _desk_lamp(rng)
    height = rng.uniform(0.39, 0.49)
    shade_high = height * rng.uniform(0.38, 0.46)
    neck = height - shade_high - 0.012
    family = int(rng.integers(5))
    radius = height * rng.uniform(0.11, 0.17)
    ceramic = glazed(pick(rng, PALETTE)) if rng.random() < 0.7 else _banded(rng)
    post_from = neck * 0.9
    body: Pieces
    if family == 0:
        gourd = [(0.0, 0.0), (0.6, 0.0), (0.95, 0.2), (0.95, 0.5), (0.35, 0.8), (0.2, 0.95), (0.0, 1.0)]
        body = [(lathe(smooth_profile(np.array(gourd) * [radius, neck * 0.95]), 40), ceramic)]
    elif family == 1:
        low = lathe([(0.0, 0.0), (radius, 0.0), (radius, 0.012), (radius * 0.9, 0.016), (0.0, 0.016)], 40)
        body = [(low, metallic(pick(rng, ("#d8b45a", "#c9ccd0", "#2f3135"))))]
        post_from = 0.012
    elif family == 2:
        stack = [
            transform(sphere(r * radius, 22), (0, 0, z * neck)) for r, z in ((0.85, 0.0), (0.62, 0.42), (0.4, 0.7))
        ]
        foot = cylinder(radius * 0.7, 0.01, 32)
        body = [(merge([foot, *[transform(ball, (0, 0, 0.006)) for ball in stack]]), ceramic)]
        post_from = neck * 0.4
    elif family == 3:
        block = rounded_box((radius * 1.3, radius * 1.3, neck * 0.8), 0.006, 2, 3.0, base=True)
        body = [(block, wood("#5a3a22", "#8a6038", 3) if rng.random() < 0.5 else beech())]
        post_from = neck * 0.78
    else:
        legs = [
            tube(
                [[radius * np.cos(a), radius * np.sin(a), 0.006], [0.008 * np.cos(a), 0.008 * np.sin(a), neck * 0.9]],
                [0.0075, 0.009],
                12,
            )
            for a in np.radians([90, 210, 330])
        ]
        body = [(merge(legs), beech() if rng.random() < 0.6 else BLACK_PLASTIC)]
        post_from = neck * 0.78
    low_radius = height * rng.uniform(0.23, 0.3)
    high_radius = low_radius * float(rng.choice([0.5, 0.68, 0.8, 1.0]))
    shade = _shade(low_radius, high_radius, height - shade_high, height, float(rng.choice([1.0, 1.0, 0.88])))
    metal = BRASS if rng.random() < 0.5 else CHROME
    post = transform(cylinder(0.006, height - 0.028 - post_from, 14), (0.0, 0.0, post_from))
    socket = transform(cylinder(0.015, 0.04, 18), (0.0, 0.0, neck + 0.004))
    bulb = transform(sphere(0.026, 20, 1.2), (0.0, 0.0, neck + 0.038))
    ring_z = height - 0.03
    reach = high_radius + (low_radius - high_radius) * 0.03 / shade_high - 0.001
    spokes = [
        tube([[0, 0, ring_z], [reach * np.cos(a), reach * np.sin(a), ring_z]], 0.0022, 6)
        for a in np.radians([0, 120, 240])
    ]
    if rng.random() < 0.25:
        ground, first = two_colours(rng, _SHADES)
        stuff = patterned(prints_patterns.pattern(pick(rng, prints_patterns.PATTERNS), ground, first, "#f2f2ef", 4))
    else:
        stuff = cloth(pick(rng, _SHADES))
    pieces: Pieces = [*body, (shade, stuff), (merge([post, socket, *spokes]), metal), (bulb, plastic("#f6f3ea", 0.2))]
    return standing(pieces)


def _banded(rng: np.random.Generator) -> Material:
    ground, first = two_colours(rng)
    return glossy_print(
        prints_patterns.pattern(pick(rng, ("zigzag", "dots", "diamonds")), ground, first, first, 4, 0.0)
    )


def _desk_lamp(rng: np.random.Generator) -> Pieces:
    """A lamp on a jointed arm, its head towards -y."""
    colour = pick(rng, (*PALETTE, "#26272a", "#f2f2ef"))
    foot = cylinder(rng.uniform(0.07, 0.085), 0.018, 40, 0.004)
    elbow = np.array([0.0, rng.uniform(0.07, 0.11), rng.uniform(0.2, 0.24)])
    head = np.array([0.0, rng.uniform(-0.09, -0.05), rng.uniform(0.37, 0.42)])
    arms = [tube(np.stack([[0.0, 0.0, 0.014], elbow]), 0.006, 12), tube(np.stack([elbow, head]), 0.006, 12)]
    joints = [
        transform(cylinder(0.012, 0.026, 18), (-0.013, *place[1:]), (0.0, 90.0, 0.0)) for place in (elbow, head)
    ]
    cone = [
        (0.0, 0.0),
        (0.022, 0.0),
        (0.026, 0.006),
        (0.03, 0.045),
        (0.068, 0.115),
        (0.065, 0.114),
        (0.027, 0.046),
        (0.0, 0.044),
    ]
    shade = transform(
        lathe(cone, 36), (0.0, head[1] + 0.012, head[2] + 0.012), (180.0 - rng.uniform(28, 45), 0.0, 0.0)
    )
    return [
        (merge([foot, shade]), plastic(colour, 0.3)),
        (merge([*arms, *joints]), CHROME if rng.random() < 0.6 else BLACK_PLASTIC),
    ]
