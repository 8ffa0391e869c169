"""Plants and other things that make a room lived in."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.curves import cylinder, disc, lathe, leaf, smooth_profile, sphere, tube
from indoor_rooms.geometry.mesh import Mesh, merge, transform
from indoor_rooms.geometry.pieces import Pieces, placed
from indoor_rooms.materials import prints_patterns
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import beech, glazed, printed, steel, wood
from indoor_rooms.objects.shaping import PALETTE, pick, prism, rounded_rectangle, two_colours


def _leaves(
    rng: np.random.Generator,
    count: int,
    length: tuple[float, float],
    width: float,
    bend: tuple[float, float],
    rim: float,
) -> Mesh:
    """Leaves all around, growing from a circle of radius `rim` at the origin."""
    blades = []
    for index in range(count):
        blade = leaf(rng.uniform(*length), width * rng.uniform(0.8, 1.2), rng.uniform(*bend), 6, rng.uniform(0, 0.25))
        turn = 360 * index / count * 2.4 + rng.uniform(-12, 12)
        blades.append(transform(transform(blade, (rim * rng.uniform(0.2, 1), 0, 0)), rotate=(0.0, 0.0, turn)))
    return merge(blades)


def herb_pot(rng: np.random.Generator) -> Pieces:
    """A small terracotta pot with a bushy herb."""
    profile = [
        (0.0, 0.0),
        (0.040, 0.0),
        (0.052, 0.075),
        (0.058, 0.075),
        (0.060, 0.098),
        (0.054, 0.098),
        (0.052, 0.088),
    ]
    pot = lathe(smooth_profile([*profile, (0.0, 0.086)], 1), 36)
    bush = []
    for _ in range(46):
        blade = leaf(rng.uniform(0.045, 0.08), 0.030, rng.uniform(0.3, 0.9), 4, rng.uniform(0.0, 0.3))
        turn, height = rng.uniform(0, 360), 0.09 + 0.09 * rng.random() ** 0.7
        bush.append(transform(transform(blade, (0.028 * rng.random(), 0.0, height)), rotate=(0.0, 0.0, turn)))
    stems = [
        tube([[0.01 * x, 0.01 * y, 0.08], [0.014 * x, 0.014 * y, 0.16]], 0.002, 6)
        for x, y in ((1, 0), (-1, 1), (0, -1))
    ]
    earthen = Material(from_hex(pick(rng, ("#c4744a", "#a85a38", "#d88a60"))), roughness=0.8)
    green = Material(from_hex(pick(rng, ("#7fae4a", "#5a8f3c", "#9fb87a", "#4a7a4a", "#6f9a8a"))), roughness=0.5)
    ware = earthen if rng.random() < 0.5 else glazed(pick(rng, PALETTE), 0.3)
    return placed([(pot, ware), (merge([*bush, *stems]), green)], scale=rng.uniform(0.9, 1.12))


def floor_plant(rng: np.random.Generator) -> Pieces:
    """A tall plant in a basket-coloured pot, for a corner of the floor."""
    profile = [
        (0.0, 0.0),
        (0.13, 0.0),
        (0.14, 0.01),
        (0.165, 0.3),
        (0.165, 0.32),
        (0.15, 0.32),
        (0.147, 0.28),
        (0.0, 0.279),
    ]
    pot = lathe(smooth_profile(profile, 1), 40)
    soil = disc(0.147, 0.283)
    leaves = transform(_leaves(rng, 26, (0.5, 0.85), 0.085, (0.05, 0.34), 0.07), (0.0, 0.0, 0.26))
    ware = glazed("#e6dfd0" if rng.random() < 0.4 else pick(rng, PALETTE), float(rng.choice([0.2, 0.5])))
    green = Material(from_hex(pick(rng, ("#4f8a3a", "#3f7a44", "#6f9a44", "#2f6a3c"))), roughness=0.5)
    return [(pot, ware), (soil, Material(from_hex("#4a3526"), roughness=0.95)), (leaves, green)]


def utensil_crock(rng: np.random.Generator) -> Pieces:
    """An earthenware jar with wooden spoons and a whisk of steel."""
    profile = [
        (0.0, 0.0),
        (0.050, 0.0),
        (0.055, 0.006),
        (0.055, 0.14),
        (0.052, 0.143),
        (0.049, 0.14),
        (0.047, 0.03),
        (0.0, 0.028),
    ]
    crock = lathe(smooth_profile(profile, 1), 36)
    spoons: list[Mesh] = []
    steels: list[Mesh] = []
    for index in range(5):
        angle = 2 * np.pi * index / 5 + rng.uniform(-0.3, 0.3)
        foot, tip = 0.02, 0.065
        low = np.array([-foot * np.cos(angle), -foot * np.sin(angle), 0.035])
        high = np.array([tip * np.cos(angle), tip * np.sin(angle), rng.uniform(0.24, 0.29)])
        stick = tube([low, high], 0.0045, 8)
        ladle = transform(sphere(0.021, 18, 1.35), (high[0], high[1], high[2] - 0.008), (0, 0, 0), 1.0)
        (spoons if index % 2 == 0 else steels).append(merge([stick, ladle]))
    return [
        (crock, glazed(pick(rng, PALETTE))),
        (merge(spoons), beech()),
        (merge(steels), steel()),
    ]


def cutting_board(rng: np.random.Generator) -> Pieces:
    """A wooden board lying along x, 2 cm thick."""
    width, depth, thick = rng.uniform(0.32, 0.38), rng.uniform(0.2, 0.25), rng.uniform(0.016, 0.024)
    timber = (
        wood("#9a6a3a", "#c9955a", 4),
        beech(),
        wood("#5a3a22", "#8a6038", 3),
        wood("#b08a5c", "#ead0a0", 7),
        wood("#6a3a24", "#a8643c", 9),
    )[int(rng.integers(5))]
    corner = float(rng.choice([0.012, 0.03, 0.09]))
    board = prism(rounded_rectangle(width, depth, corner, 6), thick, 0.004, 2.0)
    strip = prism(rounded_rectangle(0.02, depth - 2 * corner, 0.004), 0.001, 0.0003, 2.0)
    inlay = transform(strip, (width * rng.choice([-0.38, 0.38]), 0.0, thick - 0.0002))
    return [(board, timber), (inlay, wood("#3a2418", "#5f4028", 2) if rng.random() < 0.5 else timber)]


def paper_roll(rng: np.random.Generator) -> Pieces:
    """Kitchen paper on a wooden stand."""
    foot = cylinder(0.075, 0.014, 36)
    pole = transform(cylinder(0.008, 0.305, 14), (0.0, 0.0, 0.012))
    roll = transform(cylinder(0.055 * rng.uniform(0.9, 1.1), 0.23, 36, 0.003), (0.0, 0.0, 0.0155))
    knob = transform(sphere(0.014, 16), (0.0, 0.0, 0.308))
    colour, other = two_colours(rng)
    kind = pick(rng, ("leaves", "dots", "diamonds", "zigzag"))
    paper = Material(from_hex("#f5f3ee"), roughness=0.9, specular=0.1)
    if rng.random() < 0.6:
        paper = printed(prints_patterns.pattern(kind, "#f7f5f0", colour, other, 6, 0.0), 0.9)
    stand = (beech(), steel(), glazed(pick(rng, PALETTE)), wood("#4a2a18", "#7a4a2a", 1))[int(rng.integers(4))]
    return [(merge([foot, pole, knob]), stand), (roll, paper)]


def pepper_mill(rng: np.random.Generator) -> Pieces:
    """A turned wooden pepper mill."""
    waist = rng.uniform(0.8, 1.25)
    profile = [
        (0.0, 0.0),
        (0.028, 0.0),
        (0.028, 0.02),
        (0.02 * waist, 0.07),
        (0.024 * waist, 0.11),
        (0.016, 0.125),
        (0.024, 0.15),
        (0.0, 0.172),
    ]
    body = (
        wood("#4a2a16", "#7a4a28", 6, 0.7),
        beech(),
        wood("#241610", "#3f281a", 4, 0.7),
        glazed(pick(rng, PALETTE)),
        steel(),
    )[int(rng.integers(5))]
    pieces: Pieces = [
        (lathe(smooth_profile(profile), 32), body),
        (transform(sphere(0.008, 14), (0.0, 0.0, 0.169)), steel()),
    ]
    return placed(pieces, scale=rng.uniform(0.9, 1.15))
