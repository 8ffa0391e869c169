"""Things to cook with: pot, pan, kettle, toaster, knife block."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import arc, cylinder, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import merge, shear, transform
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import (
    BLACK_PLASTIC,
    BRASS,
    CAST_IRON,
    CHROME,
    beech,
    glazed,
    plastic,
    steel,
    wood,
)
from indoor_rooms.objects.shaping import PALETTE, pick


def pot(rng: np.random.Generator) -> Pieces:
    """A cooking pot with two handles (along y) and a lid."""
    radius, height = 0.105 * rng.uniform(0.88, 1.05), 0.125 * rng.uniform(0.8, 1.12)
    body = [
        (0.0, 0.0),
        (radius - 0.008, 0.0),
        (radius, 0.008),
        (radius, height * 0.5),
        (radius, height - 0.003),
        (radius + 0.003, height),
        (radius - 0.003, height + 0.001),
        (radius - 0.004, height - 0.03),
    ]
    lid = [
        (radius - 0.002, height + 0.0015),
        (radius + 0.001, height + 0.003),
        (radius * 0.7, height + 0.016),
        (0.0, height + 0.023),
    ]
    knob = [(0.007, 0.0), (0.007, 0.010), (0.018, 0.016), (0.017, 0.026), (0.0, 0.029)]
    bar = smooth_profile(
        [
            [-0.04, radius - 0.002, height * 0.74],
            [-0.036, radius + 0.034, height * 0.78],
            [0.036, radius + 0.034, height * 0.78],
            [0.04, radius - 0.002, height * 0.74],
        ]
    )
    handle = tube(bar, 0.0062, 10)
    handles = merge([handle, transform(handle, rotate=(0.0, 0.0, 180.0))])
    knob_mesh = transform(lathe(smooth_profile(knob), 24), (0.0, 0.0, height + 0.021))
    shell = steel() if rng.random() < 0.5 else glazed(pick(rng, PALETTE))
    cover = glazed(pick(rng, PALETTE)) if rng.random() < 0.25 else shell
    return [
        (lathe(smooth_profile(body, 1), 44), shell),
        (lathe(smooth_profile(lid, 1), 44), cover),
        (handles, steel()),
        (knob_mesh, (BLACK_PLASTIC, beech(), steel())[int(rng.integers(3))]),
    ]


def pan(rng: np.random.Generator) -> Pieces:
    """A frying pan, its handle towards +x; the origin is below the pan's middle."""
    radius = 0.13 * rng.uniform(0.9, 1.05)
    profile = [
        (0.0, 0.0),
        (radius * 0.80, 0.0),
        (radius * 0.86, 0.004),
        (radius, 0.045),
        (radius - 0.002, 0.047),
        (radius - 0.005, 0.045),
        (radius * 0.83, 0.009),
        (0.0, 0.007),
    ]
    grip = tube(
        [[radius - 0.006, 0, 0.04], [radius + 0.05, 0, 0.05], [radius + 0.17, 0, 0.062]], [0.008, 0.0105, 0.012]
    )
    handle = (
        Material(from_hex(pick(rng, ("#6a4426", "#8f5f34", "#c08a50", "#3a2618"))), roughness=0.4),
        BLACK_PLASTIC,
        steel(),
        glazed(pick(rng, PALETTE)),
    )[int(rng.integers(4))]
    metal = (CAST_IRON, CAST_IRON, steel(), Material(from_hex("#a8623c"), roughness=0.25, metalness=0.9))
    inside = lathe(smooth_profile(profile[5:]), 40)
    outside = lathe(smooth_profile(profile[:6]), 40)
    shell = glazed(pick(rng, PALETTE)) if rng.random() < 0.3 else metal[int(rng.integers(4))]
    return [(outside, shell), (inside, CAST_IRON if rng.random() < 0.7 else shell), (grip, handle)]


def kettle(rng: np.random.Generator) -> Pieces:
    """A stove-top kettle, spout towards +x, with an arched handle."""
    size, tall = rng.uniform(0.97, 1.06), rng.uniform(0.88, 1.08)
    belly = [(0.0, 0.0), (0.088, 0.0), (0.097, 0.008), (0.095, 0.06), (0.072, 0.135), (0.04, 0.158), (0.036, 0.159)]
    lid = [(0.039, 0.157), (0.039, 0.161), (0.02, 0.168), (0.0, 0.170)]
    knob = [(0.006, 0.0), (0.006, 0.006), (0.015, 0.012), (0.013, 0.022), (0.0, 0.025)]
    spout = tube(smooth_profile([[0.07, 0, 0.08], [0.115, 0, 0.105], [0.135, 0, 0.15]]), [0.021, 0.011])
    bow = arc((0.0, 0.0, 0.14), 0.082, 8, 172, 18)
    bow[:, 2] = 0.14 + (bow[:, 2] - 0.14) * 1.15
    grip = arc((0.0, 0.0, 0.14), 0.082, 50, 130, 12)
    grip[:, 2] = 0.14 + (grip[:, 2] - 0.14) * 1.15
    enamel = steel() if rng.random() < 0.2 else glazed(pick(rng, PALETTE), 0.1)
    pieces: Pieces = [
        (merge([lathe(smooth_profile(belly), 36), lathe(smooth_profile(lid, 1), 32), spout]), enamel),
        (tube(bow, 0.005, 10), CHROME),
        (
            merge([tube(grip, 0.0105, 12), transform(lathe(smooth_profile(knob), 20), (0.0, 0.0, 0.168))]),
            BLACK_PLASTIC if rng.random() < 0.6 else beech(),
        ),
    ]
    return [(transform(mesh, scale=(size, size, size * tall)), material) for mesh, material in pieces]


def toaster(rng: np.random.Generator) -> Pieces:
    """A two-slot toaster, long side along x, lever and dial on its +x end."""
    width, depth, height = 0.29 * rng.uniform(0.92, 1.05), 0.175, 0.19 * rng.uniform(0.92, 1.05)
    shell = steel() if rng.random() < 0.4 else glazed(pick(rng, (*PALETTE, "#b9d2c4", "#f0e4c8")))
    body = transform(
        rounded_box((width, depth, height - 0.018), rng.uniform(0.014, 0.05), 4),
        (0.0, 0.0, 0.018 + (height - 0.018) / 2),
    )
    foot = transform(rounded_box((width - 0.03, depth - 0.025, 0.022), 0.006), (0.0, 0.0, 0.011))
    slots = [
        transform(rounded_box((width * 0.68, 0.026, 0.006), 0.002), (0.0, y, height + 0.0008))
        for y in (-0.033, 0.033)
    ]
    rims = [
        transform(rounded_box((width * 0.72, 0.038, 0.003), 0.001), (0.0, y, height + 0.0002))
        for y in (-0.033, 0.033)
    ]
    track = transform(rounded_box((0.004, 0.012, 0.09), 0.0015), (width / 2 + 0.0005, 0.0, 0.115))
    lever = transform(rounded_box((0.026, 0.046, 0.018), 0.006, 2), (width / 2 + 0.013, 0.0, 0.142))
    dial = transform(cylinder(0.014, 0.012, 24), (width / 2 - 0.0005, -0.05, 0.055), (0.0, 90.0, 0.0))
    return [(body, shell), (merge([foot, *slots, track, lever]), BLACK_PLASTIC), (merge([*rims, dial]), CHROME)]


def knife_block(rng: np.random.Generator) -> Pieces:
    """A slanting wooden block with six knives, handles towards -y."""
    lean = rng.uniform(0.34, 0.43)
    block_wood = (
        wood("#5a3a22", "#8a6038", 3),
        beech(),
        wood("#3a2418", "#5f4028", 2),
        Material(from_hex("#26272a"), roughness=0.4),
    )[int(rng.integers(4))]
    grip = plastic(pick(rng, (*PALETTE, "#2b2b2d", "#2b2b2d"))) if rng.random() < 0.6 else BLACK_PLASTIC
    pieces: Pieces = [(transform(rounded_box((0.105, 0.125, 0.21), 0.006, 1, 3.0), (0.0, 0.0, 0.105)), block_wood)]
    for row, y in enumerate((-0.032, 0.028)):
        for x in (-0.033, 0.0, 0.033):
            length = 0.105 - 0.02 * row - rng.uniform(0, 0.012)
            handle = rounded_box((0.015, 0.024, length), 0.006)
            bolster = rounded_box((0.012, 0.020, 0.012), 0.002)
            pieces.append((transform(handle, (x, y, 0.2195 + length / 2)), grip))
            pieces.append((transform(bolster, (x, y, 0.2145)), CHROME))
            rivets = [
                transform(cylinder(0.0028, 0.0164, 10), (x - 0.0082, y, 0.2195 + length * f), (0.0, 90.0, 0.0))
                for f in (0.3, 0.7)
            ]
            pieces.append((merge(rivets), BRASS))
    # The foot stays level: the block is slanted, not tilted.
    return [(transform(shear(mesh, -lean), (0.0, 0.5 * lean * 0.2, 0.0)), material) for mesh, material in pieces]
