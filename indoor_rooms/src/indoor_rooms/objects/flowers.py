"""Vases with cut flowers."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.curves import lathe, leaf, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, merge, transform
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials import prints_patterns
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import glazed, glossy_print
from indoor_rooms.objects.shaping import PALETTE, blob, pick, two_colours

BLOOMS = ("#e8523f", "#f2b32c", "#e87aa0", "#f4efe4", "#b03a78", "#7a5fb8", "#c22f2a", "#f08a3a", "#8fa8e0")
# Radius and height of each vase's outside from foot to lip, as shares of its height.
_SHAPES = (
    ((0.25, 0.03), (0.34, 0.375), (0.26, 0.7), (0.16, 0.875), (0.2, 1.0)),
    ((0.2, 0.03), (0.2, 0.5), (0.2, 0.9), (0.2, 1.0)),
    ((0.3, 0.03), (0.4, 0.22), (0.38, 0.45), (0.12, 0.62), (0.11, 0.95), (0.14, 1.0)),
    ((0.13, 0.03), (0.15, 0.3), (0.24, 0.75), (0.31, 1.0)),
    ((0.18, 0.03), (0.3, 0.6), (0.33, 0.8), (0.22, 0.96), (0.2, 1.0)),
)
_TULIP = ((0.0, 0.0), (0.012, 0.003), (0.02, 0.018), (0.019, 0.036), (0.011, 0.05), (0.004, 0.05), (0.0, 0.038))


def vase(rng: np.random.Generator) -> Pieces:
    """A vase of some shape with tulips, daisies, round blossoms or twigs."""
    height = rng.uniform(0.17, 0.22)
    outside = np.array([(0.0, 0.0), (0.24, 0.0), *_SHAPES[int(rng.integers(len(_SHAPES)))]]) * height
    outside[1, 0] = outside[2, 0] * 0.92
    lip = float(outside[-1, 0])
    inside = [(lip - 0.004, height), (lip - 0.006, height * 0.86), (lip * 0.9, height * 0.76), (0.0, height * 0.75)]
    body = lathe(smooth_profile([*outside, *inside], 1), 24, (2.0, 1.0))
    colour, other = two_colours(rng)
    kind = pick(rng, prints_patterns.PATTERNS)
    pattern = prints_patterns.pattern(kind, colour, other, "#f2f2ef", 4, 0.0)
    look = glossy_print(pattern) if rng.random() < 0.3 else glazed(colour, float(rng.choice([0.1, 0.16, 0.5])))
    green = Material(from_hex(pick(rng, ("#4f8a3a", "#3f7a44", "#7f9f5a", "#5a8a6a"))), roughness=0.5)
    count, family = int(rng.integers(5, 8)), int(rng.integers(4))
    stems, blooms, hearts = [], [], []
    for index in range(count):
        angle, spread = 2 * np.pi * index / count + rng.uniform(-0.25, 0.25), rng.uniform(0.02, 0.095)
        tip = np.array([spread * np.cos(angle), spread * np.sin(angle), height + rng.uniform(0.1, 0.18)])
        throat = tip * [0.3 * lip / 0.04, 0.3 * lip / 0.04, 0.0] + [0.0, 0.0, height]
        low = throat * [0.6, 0.6, 0.0] + [0.0, 0.0, 0.77 * height]
        stems.append(tube(smooth_profile(np.stack([low, throat, tip])), 0.0024, 4))
        flower, heart = _blossom(rng, family)
        place, lean = (float(tip[0]), float(tip[1]), float(tip[2]) - 0.003), 140 * spread
        turn = float(np.degrees(angle))
        blooms.append(transform(transform(flower, rotate=(0.0, lean, 0.0)), place, (0.0, 0.0, turn)))
        if heart is not None:
            hearts.append(transform(transform(heart, rotate=(0.0, lean, 0.0)), place, (0.0, 0.0, turn)))
    blades = []
    for index in range(int(rng.integers(6, 11))):
        blade = leaf(
            rng.uniform(0.11, 0.19), rng.uniform(0.018, 0.034), rng.uniform(0.2, 0.75), 5, rng.uniform(0, 0.2)
        )
        blades.append(transform(blade, (0.0, 0.0, 0.84 * height), (0.0, 0.0, 137.5 * index + rng.uniform(-12, 12))))
    bloom = Material(from_hex(pick(rng, BLOOMS)), roughness=0.6)
    pieces: Pieces = [(body, look), (merge([*blades, *stems]), green), (merge(blooms), bloom)]
    if hearts:
        pieces.append(
            (merge(hearts), Material(from_hex(pick(rng, ("#e8b02c", "#5a3a1c", PALETTE[1]))), roughness=0.8))
        )
    return pieces


def _blossom(rng: np.random.Generator, family: int) -> tuple[Mesh, Mesh | None]:
    """A flower on the origin, looking up, and its heart if that has a colour of its own."""
    size = rng.uniform(0.85, 1.15)
    if family == 0:
        return transform(lathe(smooth_profile(_TULIP, 1), 12), scale=size), None
    if family == 1:
        petal = transform(leaf(0.034 * size, 0.014, 0.95, 3), (0.004, 0.0, 0.0))
        petals = [transform(petal, rotate=(0.0, 0.0, 40.0 * index)) for index in range(9)]
        return merge(petals), blob((0.0, 0.0, 0.006), (0.011, 0.011, 0.007), 10)
    if family == 2:
        return blob((0.0, 0.0, 0.016 * size), (0.024 * size, 0.024 * size, 0.019 * size), 14), None
    heads = [
        blob((0.0, 0.0, 0.012 * level), (0.011 - 0.0014 * level, 0.011 - 0.0014 * level, 0.01), 8)
        for level in range(5)
    ]
    return transform(merge(heads), scale=size), None
