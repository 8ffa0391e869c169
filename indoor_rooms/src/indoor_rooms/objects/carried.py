"""Things taken along: bags of several kinds, water bottle."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import arc, cylinder, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, grid_faces, merge, smooth_normals, transform
from indoor_rooms.geometry.pieces import Pieces, standing
from indoor_rooms.materials import prints_paper, prints_patterns
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import (
    BLACK_PLASTIC,
    BRASS,
    CHROME,
    cloth,
    metallic,
    patterned,
    plastic,
    printed,
    rubber,
)
from indoor_rooms.objects.shaping import bulge, closed_curve, facing, pick, prism, rounded_rectangle, two_colours


def _strap(width: float, low: float, rise: float, y: float, radius: float = 0.006) -> Mesh:
    """A bowed handle across x, both ends at z = `low`."""
    path = smooth_profile(
        [[-width / 2, y, low], [-width * 0.46, y, low + rise], [width * 0.46, y, low + rise], [width / 2, y, low]], 2
    )
    return tube(path, radius, 10)


def bag(rng: np.random.Generator) -> Pieces:
    """A bag standing, its front towards -y: tote, backpack, briefcase or handbag."""
    return (_tote, _backpack, _briefcase, _handbag)[int(rng.integers(4))](rng)


def _tote(rng: np.random.Generator) -> Pieces:
    """A shopping bag of cloth, open above, with two long handles."""
    width, height, depth = rng.uniform(0.3, 0.36), rng.uniform(0.27, 0.31), rng.uniform(0.09, 0.12)
    rings = np.linspace(0, 1, 7)
    outline = closed_curve(rounded_rectangle(width, depth, 0.03, 3), 1)
    closed = np.concatenate([outline, outline[:1]])
    around = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    # Two prints around, one of them in the middle of the front.
    front = 0.75 * around[-1] - depth / 2
    along = 2 * (around - front) / around[-1] + 0.5
    layers = []
    for side in (0.0, 0.0022):
        scales = [(1 - 0.12 * t - side / 0.15, 1 - 0.45 * t**1.5 - side / 0.05) for t in rings]
        lattice = np.stack(
            [
                np.column_stack([outline * scale, np.full(len(outline), max(t * height, 1.5 * side))])
                for t, scale in zip(rings, scales, strict=True)
            ]
        )
        lattice = np.concatenate([lattice, lattice[:, :1]], axis=1)
        floor = np.broadcast_to([0.0, 0.0, 1.5 * side], lattice[:1].shape)
        lattice = np.concatenate([floor, lattice])
        u, v = np.meshgrid(along, np.linspace(0, 1, len(lattice)))
        faces = grid_faces(len(lattice), lattice.shape[1])
        layers.append(
            smooth_normals(
                lattice.reshape(-1, 3), np.stack([u, v], axis=-1).reshape(-1, 2), faces if side else faces[:, ::-1]
            )
        )
    ground, first = two_colours(rng)
    stuff = (
        cloth(ground),
        patterned(prints_patterns.pattern(pick(rng, prints_patterns.PATTERNS), ground, first, "#f2f2ef", 4)),
        patterned(
            prints_paper.lettering(pick(rng, ("MARKET", "BOOKS", "GREEN", "HELLO")), "#efe6d2", ground, ground)
        ),
    )[int(rng.integers(3))]
    handles = [
        _strap(width * 0.42, height * 0.93, rng.uniform(0.09, 0.13), y * depth * 0.29, 0.0055) for y in (-1, 1)
    ]
    return [(merge(layers), stuff), (merge(handles), cloth(first))]


def _backpack(rng: np.random.Generator) -> Pieces:
    """A rucksack with a pocket, its straps behind."""
    width, height, depth = rng.uniform(0.26, 0.31), rng.uniform(0.38, 0.44), rng.uniform(0.07, 0.1)
    ground, first = two_colours(rng)
    body = facing(bulge(rounded_rectangle(width, height, 0.09, 6), depth, 0.03, 0.4), 0.03, height / 2)
    pocket = facing(
        bulge(rounded_rectangle(width * 0.78, height * 0.42, 0.05, 5), 0.05, 0.02, 0.45), -depth * 0.72, height * 0.21
    )
    lid = facing(
        bulge(rounded_rectangle(width * 0.74, height * 0.16, 0.03, 5), 0.018, 0.03, 0.5), -depth * 0.72, height * 0.62
    )
    zips = [tube([[-width * 0.3, 0, 0], [width * 0.3, 0, 0]], 0.003, 6)]
    zips = [
        transform(zips[0], (0.0, -depth * 0.72 - 0.046, height * 0.29)),
        transform(zips[0], (0, -depth * 0.72 - 0.0165, height * 0.62)),
    ]
    loop = _strap(0.09, height - 0.012, 0.035, 0.0, 0.006)
    straps = []
    for side in (-1, 1):
        path = smooth_profile(
            [
                [side * 0.06, 0.022, height * 0.86],
                [side * 0.075, 0.06, height * 0.75],
                [side * 0.085, 0.06, height * 0.35],
                [side * 0.1, 0.02, height * 0.16],
            ]
        )
        straps.append(tube(path, [0.012, 0.014, 0.008], 8))
    front = cloth(first) if rng.random() < 0.6 else cloth(ground)
    return standing(
        [
            (body, cloth(ground)),
            (merge([pocket, lid]), front),
            (merge([*straps, loop]), cloth(pick(rng, ("#26272a", first)))),
            (merge(zips), metallic("#c9ccd0")),
        ]
    )


def _briefcase(rng: np.random.Generator) -> Pieces:
    """A flat case with two clasps."""
    width, height, depth = rng.uniform(0.36, 0.42), rng.uniform(0.26, 0.3), rng.uniform(0.08, 0.11)
    leather = rubber(pick(rng, ("#5a3a26", "#26272a", "#8a4a32", "#3a2a24", "#3a3f56", "#6a6e74")))
    halves = [
        transform(rounded_box((width, depth * share, height), 0.012, 2, base=True), (0.0, y * depth, 0.0))
        for share, y in ((0.56, -0.22), (0.42, 0.28))
    ]
    seam = transform(
        rounded_box((width - 0.006, depth * 0.1, height - 0.006), 0.003, base=True), (0.0, 0.07 * depth, 0.003)
    )
    grip = _strap(0.13, height - 0.003, 0.036, 0.0, 0.0085)
    metal = BRASS if rng.random() < 0.5 else CHROME
    front = -0.5 * depth
    clasps = [
        transform(rounded_box((0.034, 0.004, 0.03), 0.0015), (x * width * 0.3, front - 0.0012, height * 0.86))
        for x in (-1, 1)
    ]
    rings = [transform(cylinder(0.008, 0.02, 14), (x * 0.064, 0.0, height - 0.004)) for x in (-1, 1)]
    return [(merge(halves), leather), (seam, BLACK_PLASTIC), (grip, leather), (merge([*clasps, *rings]), metal)]


def _handbag(rng: np.random.Generator) -> Pieces:
    """A handbag with a flap, a clasp and one or two handles."""
    width, height, depth = rng.uniform(0.27, 0.34), rng.uniform(0.19, 0.24), rng.uniform(0.08, 0.12)
    colour, other = two_colours(rng)
    taper = rng.uniform(0.7, 1.0)
    outline = closed_curve(
        [
            (-width / 2, 0),
            (-width / 4, 0),
            (width / 4, 0),
            (width / 2, 0),
            (width / 2 * taper, height),
            (0, height),
            (-width / 2 * taper, height),
        ],
        2,
    )
    body = facing(bulge(outline, depth / 2, depth / 2, 0.35), depth / 2)
    pieces: Pieces = [(body, rubber(colour))]
    if rng.random() < 0.7:
        low = height * rng.uniform(0.35, 0.6)
        w = width / 2 * taper
        flap = closed_curve(
            [
                (-w * 0.94, height * 0.96),
                (-w * 0.98, low),
                (0, low - 0.035),
                (w * 0.98, low),
                (w * 0.94, height * 0.96),
                (0, height * 0.97),
            ],
            2,
        )
        pieces.append(
            (facing(prism(flap, 0.008, 0.002), -depth / 2 + 0.004), rubber(other if rng.random() < 0.5 else colour))
        )
        buckle = facing(prism(rounded_rectangle(0.032, 0.026, 0.006), 0.006, 0.0015), -depth / 2 - 0.003, low - 0.005)
        pieces.append((buckle, BRASS if rng.random() < 0.6 else CHROME))
    rise = rng.uniform(0.09, 0.14)
    handles = [
        _strap(width * 0.5 * taper, height * 0.93, rise, y, 0.006)
        for y in ((0.0,) if rng.random() < 0.5 else (-0.016, 0.016))
    ]
    pieces.append((merge(handles), rubber(other if rng.random() < 0.5 else colour)))
    return standing(pieces)


def water_bottle(rng: np.random.Generator) -> Pieces:
    """A sports bottle with a lid, a band of print and perhaps a carrying loop."""
    radius, height = rng.uniform(0.031, 0.038), rng.uniform(0.17, 0.22)
    colour, other = two_colours(rng)
    family = int(rng.integers(3))
    shoulder = height * rng.uniform(0.8, 0.9)
    waist = radius * float(rng.choice([1.0, 1.0, 0.86]))
    body = [
        (0.0, 0.0),
        (radius - 0.003, 0.0),
        (radius, 0.004),
        (radius, height * 0.3),
        (waist, height * 0.5),
        (radius, height * 0.68),
        (radius, shoulder),
        (radius * 0.6, height - 0.004),
        (radius * 0.58, height + 0.004),
    ]
    look = (
        plastic(colour, 0.2),
        metallic(colour, 0.28),
        Material(from_hex(colour), roughness=0.08, coat=0.8),
        metallic("#c9ccd0", 0.25),
    )[int(rng.integers(4))]
    pieces: Pieces = [(lathe(smooth_profile([*body, (0.0, height + 0.004)], 2), 36), look)]
    if waist == radius:
        word = pick(rng, ("RUN", "AQUA", "PEAK", "H2O", "TOUR"))
        band = lathe([(radius + 0.0006, height * 0.32), (radius + 0.0006, height * 0.62)], 36, (2.0, 1.0))
        pieces.append((band, printed(prints_paper.lettering(word, other, "#fbfbf8", "#26272a"), 0.35)))
    lid = transform(cylinder(radius * 0.68, 0.026, 28, 0.002), (0.0, 0.0, height - 0.002))
    top = height + 0.022
    if family == 0:
        spout = lathe([(0.012, 0.0), (0.009, 0.012), (0.011, 0.016), (0.010, 0.026), (0.0, 0.027)], 20)
        pieces.append((transform(spout, (0.0, 0.0, top)), plastic(pick(rng, ("#e8eaec", other)), 0.3)))
    elif family == 1:
        pieces.append((_strap(radius * 1.1, top - 0.003, 0.026, 0.0, 0.0045), plastic(other)))
    else:
        cord = arc((radius * 0.66, 0.0, height + 0.006), 0.018, 110, -110, 14)
        pieces.append((tube(cord, 0.003, 8), rubber(other)))
    pieces.append((lid, plastic(pick(rng, ("#26272a", other, "#e8eaec")), 0.4)))
    return pieces
