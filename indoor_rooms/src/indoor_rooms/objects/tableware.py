"""Crockery: mug, plate, bowl, teapot, glass jar."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.curves import arc, cylinder, disc, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, merge, transform
from indoor_rooms.geometry.pieces import Pieces, placed
from indoor_rooms.materials import prints, prints_patterns, textures
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import glazed, glossy_print, printed
from indoor_rooms.objects.shaping import PALETTE, pick, two_colours

CREAMS = ("#f6f4ef", "#f3efe2", "#eef3f5", "#f4eedd")
DRINKS = ("#3a2112", "#3a2112", "#b58a5c", "#8a4a1c")


def _decorated(rng: np.random.Generator, colour: str, other: str, repeats: int = 4) -> Material:
    """A pattern under glaze."""
    kind = pick(rng, prints_patterns.PATTERNS)
    return glossy_print(prints_patterns.pattern(kind, colour, other, pick(rng, CREAMS), repeats, 0.0))


def _band(profile: np.ndarray, low: float, high: float, segments: int = 36) -> Mesh:
    """A painted band on a turned wall, between two heights as shares of it."""
    wall = profile[np.argmax(profile[:, 1] > 0.002) :]
    heights = np.linspace(low, high, 5) * wall[:, 1].max()
    return lathe(
        np.stack([np.interp(heights, wall[:, 1], wall[:, 0]) + 0.0007, heights], axis=1), segments, (2.0, 1.0)
    )


def mug(rng: np.random.Generator) -> Pieces:
    """A mug with a handle towards +x, filled; straight, tapered, bellied or flared."""
    radius, height, wall = rng.uniform(0.037, 0.046), rng.uniform(0.086, 0.114), 0.0045
    foot, waist, lip = (
        np.array(
            ((1.0, 1.0, 1.0), (0.74, 0.88, 1.0), (0.82, 1.12, 0.94), (0.78, 0.86, 1.06), (1.08, 1.0, 0.92))[
                int(rng.integers(5))
            ]
        )
        * radius
    )
    outside = smooth_profile(
        [
            (0.0, 0.0),
            (foot - 0.005, 0.0),
            (foot, 0.006),
            (waist, height * 0.45),
            (lip, height * 0.9),
            (lip, height - 0.002),
            (lip - wall / 2, height),
        ]
    )
    inside = [
        (lip - wall / 2, height),
        (lip - wall, height - 0.002),
        (lip - wall, height * 0.9),
        (waist - wall, height * 0.45),
        (foot * 0.94 - wall, 0.012),
        (0.0, 0.009),
    ]
    upper, lower = height * rng.uniform(0.78, 0.86), height * rng.uniform(0.2, 0.3)
    first, last = np.interp([upper, lower], outside[1:-1, 1], outside[1:-1, 0]) - 0.002
    reach, middle, far = rng.uniform(0.024, 0.034), (upper + lower) / 2, max(first, last)
    forms = (
        [(far + 0.8 * reach, upper + 0.006), (far + 1.2 * reach, middle), (far + 0.8 * reach, lower - 0.006)],
        [(far + reach, upper), (far + reach, lower)],
        [(far + 1.3 * reach, upper + 0.008), (far + reach, middle)],
    )
    way = [(first, upper), *forms[int(rng.integers(3))], (last, lower)]
    handle = tube(smooth_profile([[x, 0.0, z] for x, z in way], 3), rng.uniform(0.0044, 0.0058), 10)
    handle = transform(handle, scale=(1.0, rng.uniform(0.95, 1.5), 1.0))
    colour, other = two_colours(rng)
    shell, inner = lathe(outside, 32, (2.0, 1.0)), lathe(smooth_profile(inside, 1), 32)
    drink = height * rng.uniform(0.74, 0.86)
    surface = np.interp(drink, [height * 0.45, height * 0.9], [waist, lip]) - wall + 0.0006
    liquid = (disc(float(surface), drink), Material(from_hex(pick(rng, DRINKS)), roughness=0.1))
    style = int(rng.integers(5))
    if style == 0:
        return [(merge([shell, inner, handle]), glazed(colour)), liquid]
    lining = glazed(pick(rng, CREAMS) if style != 2 else other)
    if style == 4:
        print_ = _decorated(rng, colour, other, 6)
        return [(shell, print_), (merge([inner]), lining), (handle, glazed(other)), liquid]
    pieces: Pieces = [(merge([shell, handle]), glazed(colour)), (inner, lining), liquid]
    if style == 3:
        low = rng.uniform(0.25, 0.45)
        pieces.append((_band(outside, low, low + rng.uniform(0.12, 0.35)), glazed(other)))
    return pieces


def plate(rng: np.random.Generator) -> Pieces:
    """A dinner plate with a broad or narrow rim, and coloured bands or a pattern on it."""
    radius = rng.uniform(0.115, 0.14)
    inner, rise = radius * rng.uniform(0.58, 0.74), rng.uniform(0.019, 0.028)
    profile = [
        (0.0, 0.002),
        (inner * 0.86, 0.002),
        (inner * 0.90, 0.0),
        (inner * 0.97, 0.0),
        (inner * 1.03, 0.004),
        (radius * 0.985, rise - 0.0025),
        (radius, rise),
        (radius * 0.985, rise + 0.0015),
        (inner * 1.03, 0.0095),
        (inner * 0.92, 0.0075),
        (0.0, 0.007),
    ]

    def on_rim(fraction: float) -> tuple[float, float]:
        low, high = np.array([inner * 1.03, 0.0095]), np.array([radius * 0.985, rise + 0.0015])
        place = low + fraction * (high - low)
        return float(place[0]), float(place[1]) + 0.0007

    colour, other = two_colours(rng)
    china = pick(rng, CREAMS) if rng.random() < 0.6 else other
    rings = ([(0.92, 0.55)], [(0.95, 0.85), (0.7, 0.62), (0.5, 0.45)], [(0.96, 0.12)], [(0.94, 0.8)])[
        int(rng.integers(4))
    ]
    bands = merge([lathe([on_rim(a), on_rim(b)], 48, (10.0, 1.0)) for a, b in rings])
    paint = _decorated(rng, colour, china, 2) if rng.random() < 0.4 else glazed(colour)
    return [(lathe(smooth_profile(profile, 1), 48), glazed(china)), (bands, paint)]


def bowl(rng: np.random.Generator) -> Pieces:
    """A bowl: round, steep or flaring; plain, two-coloured, banded or patterned."""
    radius, height = rng.uniform(0.072, 0.096), rng.uniform(0.058, 0.084)
    foot = rng.uniform(0.4, 0.55)
    reach, level = ((0.80, 0.42), (0.66, 0.5), (0.96, 0.36))[int(rng.integers(3))]
    outside = smooth_profile(
        [
            (0.0, 0.002),
            (radius * (foot - 0.08), 0.002),
            (radius * (foot - 0.06), 0.0),
            (radius * (foot - 0.02), 0.0),
            (radius * foot, 0.008),
            (radius * reach, height * level),
            (radius * 0.99, height * 0.95),
            (radius * 0.99, height),
        ]
    )
    inside = [
        (radius * 0.99, height),
        (radius * 0.955, height),
        (radius * (reach - 0.04), height * (level + 0.04)),
        (radius * (foot - 0.05), 0.013),
        (0.0, 0.011),
    ]
    colour, other = two_colours(rng)
    style = int(rng.integers(4))
    lining = glazed(other if style == 1 else (colour if style == 2 else pick(rng, CREAMS)))
    shell = _decorated(rng, colour, other) if style == 3 else glazed(colour)
    pieces: Pieces = [(lathe(outside, 36, (2.0, 1.0)), shell), (lathe(smooth_profile(inside), 36), lining)]
    if style == 0 and rng.random() < 0.6:
        pieces.append((_band(outside, 0.62, 0.8), glazed(other)))
    return pieces


def teapot(rng: np.random.Generator) -> Pieces:
    """A teapot, round, tall or squat: spout towards +x, handle towards -x."""
    size, wide, tall = rng.uniform(0.95, 1.08), *((1.0, 1.0), (0.88, 1.22), (1.1, 0.82))[int(rng.integers(3))]
    shoulder = rng.uniform(0.055, 0.075)
    belly = np.array(
        [(0.0, 0.0), (0.045, 0.0), (0.05, 0.004), (0.082, 0.035), (0.086, 0.07), (shoulder, 0.115), (0.038, 0.124)]
    )
    lid = np.array(
        [(0.043, 0.121), (0.043, 0.126), (0.026, 0.138), (0.007, 0.141), (0.008, 0.147), (0.014, 0.155), (0.0, 0.163)]
    )
    stretch = (wide, 1.0, tall)
    spout = tube(
        smooth_profile([[0.06, 0, 0.05], [0.105, 0, 0.06], [0.115, 0, 0.1], [0.142, 0, 0.122]]), [0.015, 0.009], 12
    )
    if rng.random() < 0.3:
        bow = arc((0.0, 0.0, 0.105), 0.07, 0, 180, 16) * [1.0, 1.0, 1.25] - [0.0, 0.0, 0.026]
        handle = tube(bow, 0.005, 10)
    else:
        handle = tube(arc((-0.075, 0.0, 0.075), 0.042, 70, 290, 16), 0.0075, 12)
    colour, other = two_colours(rng)
    body = transform(lathe(smooth_profile(belly), 40, (2.0, 1.0)), scale=stretch)
    cover = transform(lathe(smooth_profile(lid, 1), 32), scale=stretch)
    extras = transform(merge([spout, handle]), scale=stretch)
    style = int(rng.integers(3))
    glaze = glazed(colour)
    if style == 0:
        return [(transform(merge([body, cover, extras]), scale=size), glaze)]
    painted = _decorated(rng, colour, other) if style == 1 else glaze
    return placed([(body, painted), (merge([cover, extras]), glaze if style == 1 else glazed(other))], scale=size)


_PRESERVES = (
    ("#7a1420", "#c23a3a", "JAM"),
    ("#c9761c", "#3a6fa8", "HONEY"),
    ("#8f3b12", "#3f8a4a", "PEACH"),
    ("#3a1638", "#7a4f96", "PLUM"),
    ("#5a6a1c", "#e0a02c", "PICKLES"),
    ("#c8a06a", "#8a4a32", "NUTS"),
    ("#d8b03a", "#2f8f86", "LEMON"),
    ("#a8301c", "#3a3d42", "PEPPER"),
)


def jar(rng: np.random.Generator) -> Pieces:
    """A jar of something kept, tall or squat, with a cloth or metal lid and a label."""
    size, tall = rng.uniform(0.92, 1.1), float(rng.choice([0.82, 1.0, 1.0, 1.25]))
    jam, lid, title = _PRESERVES[int(rng.integers(len(_PRESERVES)))]
    if rng.random() < 0.5:
        lid = pick(rng, PALETTE)
    profile = [(0.0, 0.0), (0.036, 0.0), (0.041, 0.005), (0.041, 0.075), (0.036, 0.09), (0.034, 0.098), (0.0, 0.098)]
    neck = 0.098 * tall
    label = lathe([(0.0416, 0.022 * tall), (0.0416, 0.066 * tall)], 36, (2.0, 1.0))
    metal = rng.random() < 0.4
    cap = glazed(lid, 0.3) if metal else Material(from_hex(lid), roughness=0.6)
    cloth = glazed(lid, 0.3) if metal else printed(textures.gingham(lid))
    ground = pick(rng, ("#f6efdc", "#f6efdc", "#ffffff", "#3a3d42"))
    ink = "#f6efdc" if ground == "#3a3d42" else "#5a1f1a"
    pieces: Pieces = [
        (
            transform(lathe(smooth_profile(profile), 36), scale=(1.0, 1.0, tall)),
            Material(from_hex(jam), roughness=0.06, coat=1.0),
        ),
        (label, printed(prints.wrap_label(title, ground, lid, ink))),
        (transform(cylinder(0.0385, 0.020, 36), (0.0, 0.0, neck - 0.0025)), cap),
        (transform(disc(0.0365, 0.0206, 36, repeats=0.6), (0.0, 0.0, neck - 0.0025)), cloth),
    ]
    return placed(pieces, scale=size)
