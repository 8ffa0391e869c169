"""Crockery: mug, plate, bowl, teapot, glass jar."""

from __future__ import annotations

import numpy as np

from active_perceiver.rooms import prints, textures
from active_perceiver.rooms.curves import arc, cylinder, disc, lathe, smooth_profile, tube
from active_perceiver.rooms.geometry import merge, transform
from active_perceiver.rooms.materials import Material, from_hex
from active_perceiver.rooms.pieces import Pieces
from active_perceiver.rooms.surfaces import glazed, printed

GLAZES = ("#c8372d", "#2f6fa8", "#e0a02c", "#3f8f74", "#d97a4a", "#7a4f8f")


def pick(rng: np.random.Generator, colours: tuple[str, ...]) -> str:
    """One of some colours."""
    return colours[int(rng.integers(len(colours)))]


def mug(rng: np.random.Generator) -> Pieces:
    """A coffee mug with a handle towards +x, filled."""
    radius, height = 0.043 * rng.uniform(0.95, 1.08), 0.102 * rng.uniform(0.95, 1.1)
    wall = 0.0045
    profile = [
        (0.0, 0.0),
        (radius * 0.84, 0.0),
        (radius * 0.93, 0.003),
        (radius, 0.014),
        (radius, height * 0.6),
        (radius, height - 0.002),
        (radius - wall / 2, height),
        (radius - wall, height - 0.002),
        (radius - wall, height * 0.4),
        (radius - wall, 0.012),
        (0.0, 0.009),
    ]
    middle, reach = height * 0.53, height * 0.29
    handle = np.concatenate(
        [
            [[radius - 0.002, 0.0, middle + reach]],
            arc((radius + 0.006, 0.0, middle), reach, 80, -80, 14),
            [[radius - 0.002, 0.0, middle - reach]],
        ]
    )
    body = merge([lathe(smooth_profile(profile), 44), tube(handle, 0.0062, 12)])
    coffee = disc(radius - wall - 0.0004, height * 0.84)
    return [(body, glazed(pick(rng, GLAZES))), (coffee, Material(from_hex("#3a2112"), roughness=0.1))]


def plate(rng: np.random.Generator) -> Pieces:
    """A dinner plate with a coloured band on its rim."""
    radius = 0.135 * rng.uniform(0.96, 1.06)
    inner = radius * 0.62
    profile = [
        (0.0, 0.002),
        (inner * 0.86, 0.002),
        (inner * 0.90, 0.0),
        (inner * 0.97, 0.0),
        (inner * 1.03, 0.004),
        (radius * 0.985, 0.022),
        (radius, 0.0245),
        (radius * 0.985, 0.026),
        (inner * 1.03, 0.0095),
        (inner * 0.92, 0.0075),
        (0.0, 0.007),
    ]

    def on_rim(fraction: float) -> tuple[float, float]:
        low, high = np.array([inner * 1.03, 0.0095]), np.array([radius * 0.985, 0.026])
        place = low + fraction * (high - low)
        return float(place[0]), float(place[1]) + 0.0007

    band = lathe([on_rim(0.92), on_rim(0.55)], 56)
    china = glazed(pick(rng, ("#f6f4ef", "#f3efe2", "#eef3f5")))
    return [(lathe(smooth_profile(profile), 56), china), (band, glazed(pick(rng, ("#2f5f9a", "#b5412f", "#3a7a5a"))))]


def bowl(rng: np.random.Generator) -> Pieces:
    """A deep bowl, coloured outside, cream inside."""
    radius, height = 0.088 * rng.uniform(0.95, 1.08), 0.072 * rng.uniform(0.92, 1.1)
    outside = [
        (0.0, 0.002),
        (radius * 0.42, 0.002),
        (radius * 0.44, 0.0),
        (radius * 0.48, 0.0),
        (radius * 0.50, 0.008),
        (radius * 0.80, height * 0.42),
        (radius * 0.99, height * 0.95),
        (radius * 0.99, height),
    ]
    inside = [
        (radius * 0.99, height),
        (radius * 0.955, height),
        (radius * 0.76, height * 0.46),
        (radius * 0.45, 0.013),
        (0.0, 0.011),
    ]
    return [
        (lathe(smooth_profile(outside), 48), glazed(pick(rng, ("#2f76a8", "#2f8f8a", "#d0622f", "#c9a227")))),
        (lathe(smooth_profile(inside), 48), glazed("#f4eedd")),
    ]


def teapot(rng: np.random.Generator) -> Pieces:
    """A round teapot: spout towards +x, handle towards -x."""
    size = rng.uniform(0.95, 1.08)
    belly = [(0.0, 0.0), (0.045, 0.0), (0.05, 0.004), (0.082, 0.035), (0.086, 0.07), (0.062, 0.115), (0.038, 0.124)]
    lid = [
        (0.043, 0.121),
        (0.043, 0.126),
        (0.026, 0.138),
        (0.007, 0.141),
        (0.008, 0.147),
        (0.014, 0.155),
        (0.0, 0.163),
    ]
    spout = tube(smooth_profile([[0.06, 0, 0.05], [0.105, 0, 0.06], [0.115, 0, 0.1], [0.142, 0, 0.122]]), 0.011, 12)
    handle = tube(arc((-0.075, 0.0, 0.075), 0.042, 70, 290, 16), 0.0075, 12)
    colour = pick(rng, ("#2e5f8f", "#b9433a", "#d8d2c2", "#3f7f6a"))
    body = merge([lathe(smooth_profile(belly), 44), lathe(smooth_profile([*lid]), 36), spout, handle])
    return [(transform(body, scale=size), glazed(colour))]


def jar(rng: np.random.Generator) -> Pieces:
    """A jar of jam with a gingham lid and a label."""
    size = rng.uniform(0.95, 1.1)
    jam, lid, title = (
        ("#7a1420", "#c23a3a", "JAM"),
        ("#c9761c", "#3a6fa8", "HONEY"),
        ("#8f3b12", "#3f8a4a", "PEACH"),
    )[int(rng.integers(3))]
    profile = [(0.0, 0.0), (0.036, 0.0), (0.041, 0.005), (0.041, 0.075), (0.036, 0.09), (0.034, 0.098), (0.0, 0.098)]
    label = lathe([(0.0416, 0.022), (0.0416, 0.066)], 40, (2.0, 1.0))
    cover = cylinder(0.0385, 0.020, 36)
    top = disc(0.0365, 0.0206, 36, repeats=0.6)
    cap = Material(from_hex(lid), roughness=0.4)
    pieces: Pieces = [
        (lathe(smooth_profile(profile), 40), Material(from_hex(jam), roughness=0.06, coat=1.0)),
        (label, printed(prints.wrap_label(title, "#f6efdc", lid, "#5a1f1a"))),
        (transform(cover, (0.0, 0.0, 0.0955)), cap),
        (transform(top, (0.0, 0.0, 0.0955)), printed(textures.gingham(lid))),
    ]
    return [(transform(mesh, scale=size), material) for mesh, material in pieces]
