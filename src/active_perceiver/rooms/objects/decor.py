"""Plants and other things that make a room lived in."""

from __future__ import annotations

import numpy as np

from active_perceiver.rooms.boxes import rounded_box
from active_perceiver.rooms.curves import cylinder, disc, lathe, leaf, smooth_profile, sphere, tube
from active_perceiver.rooms.geometry import Mesh, merge, transform
from active_perceiver.rooms.materials import Material, from_hex
from active_perceiver.rooms.objects.tableware import pick
from active_perceiver.rooms.pieces import Pieces, placed
from active_perceiver.rooms.surfaces import beech, glazed, steel, wood

GREEN = Material(from_hex("#4f8a3a"), roughness=0.5)
FRESH_GREEN = Material(from_hex("#7fae4a"), roughness=0.5)


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


def vase(rng: np.random.Generator) -> Pieces:
    """A vase with leaves and tulips."""
    colour = pick(rng, ("#3a6f9a", "#e8e2d4", "#b86a4a", "#4a7a6a"))
    profile = [(0.0, 0.0), (0.045, 0.0), (0.05, 0.006), (0.068, 0.075), (0.052, 0.14), (0.032, 0.175), (0.040, 0.2)]
    inside = [(0.040, 0.2), (0.036, 0.2), (0.029, 0.175), (0.04, 0.15), (0.0, 0.148)]
    body = lathe(smooth_profile([*profile, *inside[1:]]), 40)
    leaves = transform(_leaves(rng, 12, (0.13, 0.22), 0.035, (0.2, 0.75), 0.014), (0.0, 0.0, 0.17))
    stems, flowers = [], []
    petal = [(0.0, 0.0), (0.012, 0.003), (0.020, 0.018), (0.019, 0.036), (0.011, 0.05), (0.004, 0.05), (0.0, 0.038)]
    for index in range(7):
        angle, spread = 2 * np.pi * index / 7 + rng.uniform(-0.2, 0.2), rng.uniform(0.02, 0.085)
        tip = np.array([spread * np.cos(angle), spread * np.sin(angle), rng.uniform(0.31, 0.38)])
        x, y, _ = tip
        path = smooth_profile([[0.2 * x, 0.2 * y, 0.155], [0.35 * x, 0.35 * y, 0.26], list(tip)])
        stems.append(tube(path, 0.0028, 8))
        flowers.append(transform(lathe(smooth_profile(petal), 18), (tip[0], tip[1], tip[2] - 0.003)))
    bloom = Material(from_hex(pick(rng, ("#e8523f", "#f2b32c", "#e87aa0", "#f4efe4"))), roughness=0.6)
    return [(body, glazed(colour)), (merge([leaves, *stems]), GREEN), (merge(flowers), bloom)]


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
    return [(pot, Material(from_hex("#c4744a"), roughness=0.8)), (merge([*bush, *stems]), FRESH_GREEN)]


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
    return [(pot, glazed("#e6dfd0", 0.5)), (soil, Material(from_hex("#4a3526"), roughness=0.95)), (leaves, GREEN)]


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
        (crock, glazed(pick(rng, ("#e9e2d2", "#6f8fa0", "#a8583a")))),
        (merge(spoons), beech()),
        (merge(steels), steel()),
    ]


def cutting_board(rng: np.random.Generator) -> Pieces:
    """A wooden board lying along x, 2 cm thick."""
    board = rounded_box((0.36 * rng.uniform(0.95, 1.05), 0.22, 0.02), 0.006, 2, 2.0, base=True)
    return [(board, wood("#9a6a3a", "#c9955a", 4))]


def paper_roll(rng: np.random.Generator) -> Pieces:
    """Kitchen paper on a wooden stand."""
    foot = cylinder(0.075, 0.014, 36)
    pole = transform(cylinder(0.008, 0.305, 14), (0.0, 0.0, 0.012))
    roll = transform(cylinder(0.055 * rng.uniform(0.9, 1.1), 0.23, 36, 0.003), (0.0, 0.0, 0.0155))
    knob = transform(sphere(0.014, 16), (0.0, 0.0, 0.308))
    return [(merge([foot, pole, knob]), beech()), (roll, Material(from_hex("#f5f3ee"), roughness=0.9, specular=0.1))]


def pepper_mill(rng: np.random.Generator) -> Pieces:
    """A turned wooden pepper mill."""
    profile = [
        (0.0, 0.0),
        (0.028, 0.0),
        (0.028, 0.02),
        (0.02, 0.07),
        (0.024, 0.11),
        (0.016, 0.125),
        (0.024, 0.15),
        (0.0, 0.172),
    ]
    body = wood("#4a2a16", "#7a4a28", 6, 0.7) if rng.random() < 0.5 else beech()
    pieces: Pieces = [
        (lathe(smooth_profile(profile), 32), body),
        (transform(sphere(0.008, 14), (0.0, 0.0, 0.169)), steel()),
    ]
    return placed(pieces, scale=rng.uniform(0.9, 1.15))
