"""Things in packages: bottle, cereal, milk, can, soap, spray bottle."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials import prints
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import WHITE_PAINT, glazed, plastic, printed, steel
from indoor_rooms.objects.shaping import PALETTE, pick, two_colours


def _sides(width: float, depth: float, height: float) -> tuple[Mesh, Mesh]:
    """The (front and back, left and right) faces of a box on z = 0, each covered once by its texture."""
    x, y = width / 2, depth / 2
    wide = [
        quad((-x, -y, 0), (width, 0, 0), (0, 0, height)),
        quad((x, y, 0), (-width, 0, 0), (0, 0, height)),
    ]
    narrow = [
        quad((x, -y, 0), (0, depth, 0), (0, 0, height)),
        quad((-x, y, 0), (0, -depth, 0), (0, 0, height)),
    ]
    return merge(wide), merge(narrow)


def bottle(rng: np.random.Generator) -> Pieces:
    """A tall bottle of oil or wine with a label and a cap."""
    size = rng.uniform(0.95, 1.06)
    glass = pick(rng, ("#1f5a34", "#6a7a1c", "#5a1f24", "#7a4a1c", "#c9b04a", "#1f3a5a", "#d8e0dc", "#26282a"))
    label, accent, ink = (
        pick(rng, ("#f3ead2", "#f7f2e2", "#efe4cc", "#ffffff", "#26282d")),
        pick(rng, PALETTE),
        "#3a2a1c",
    )
    cap = pick(rng, ("#8f1f26", "#26221e", "#c7a14a", "#f2f2ef", *PALETTE))
    title = pick(rng, ("OLIO", "VINO", "SYRUP", "CIDER", "JUICE", "ROSSO", "TONIC"))
    # Shoulders: round, sloping as of burgundy, high as of a flask, long-necked.
    body, shoulder, neck = ((0.17, 0.2, 0.235), (0.135, 0.18, 0.25), (0.19, 0.215, 0.232), (0.12, 0.15, 0.19))[
        int(rng.integers(4))
    ]
    profile = [
        (0.0, 0.0),
        (0.036, 0.0),
        (0.040, 0.006),
        (0.040, body),
        (0.036, shoulder),
        (0.017, neck),
        (0.0145, 0.295),
    ]
    pieces: Pieces = [
        (lathe(smooth_profile([*profile, (0.0, 0.296)]), 36), Material(from_hex(glass), roughness=0.06, coat=1.0)),
        (
            lathe([(0.0406, body * 0.22), (0.0406, body * 0.8)], 36, (2.0, 1.0)),
            printed(prints.wrap_label(title, label, accent, "#efe4cc" if label == "#26282d" else ink)),
        ),
        (transform(cylinder(0.0168, 0.034), (0.0, 0.0, 0.268)), plastic(cap, 0.3)),
    ]
    return [(transform(mesh, scale=size), material) for mesh, material in pieces]


def cereal(rng: np.random.Generator) -> Pieces:
    """A box of cereal, its front towards -y."""
    width, depth, height = 0.19 * rng.uniform(0.95, 1.05), 0.065, 0.285 * rng.uniform(0.97, 1.05)
    brand = pick(rng, ("CRUNCH", "HOOPS", "OATIES", "FLAKES", "PUFFS", "MUESLI", "STARS", "BRAN"))
    ground, accent = pick(
        rng,
        (
            "#d2342c #e8643a",
            "#2456a8 #3a78c8",
            "#e08a1c #f0a83a",
            "#3a8a4a #6ab06a",
            "#7a4f96 #a078b8",
            "#2f8f86 #5ab0a8",
            "#c8588f #e088b0",
            "#6a4028 #946440",
        ),
    ).split()
    front, side = _sides(width, depth, height)
    lid = quad((-width / 2, -depth / 2, height), (width, 0, 0), (0, depth, 0))
    floor = quad((-width / 2, depth / 2, 0), (width, 0, 0), (0, -depth, 0))
    plain = Material(from_hex(ground), roughness=0.5, specular=0.35)
    return [
        (front, printed(prints.cereal_box(brand, ground, accent, int(rng.integers(3))))),
        (merge([side, lid, floor]), plain),
    ]


def milk(rng: np.random.Generator) -> Pieces:
    """A gable-top milk carton."""
    width, height, gable = 0.09, 0.185 * rng.uniform(0.97, 1.06), 0.052
    half = width / 2
    colour = pick(rng, ("#2a6ab8", "#2f9a5a", "#c83a6a", *PALETTE[:12]))
    wide, narrow = _sides(width, width, height)
    roof = [
        quad((-half, -half, height), (width, 0, 0), (0, half - 0.001, gable)),
        quad((half, half, height), (-width, 0, 0), (0, -half + 0.001, gable)),
    ]
    gables = []
    for side in (-1.0, 1.0):
        vertices = np.array([[half, -half, height], [half, half, height], [half - 0.004, 0.0, height + gable]])
        vertices[:, :2] *= side
        normal = np.cross(vertices[1] - vertices[0], vertices[2] - vertices[0])
        normals = np.tile(normal / np.linalg.norm(normal), (3, 1))
        gables.append(Mesh(vertices, normals, np.full((3, 2), 0.5), np.array([[0, 1, 2]])))
    fin = transform(rounded_box((width - 0.002, 0.004, 0.022), 0.001), (0.0, 0.0, height + gable + 0.0095))
    cap = transform(cylinder(0.014, 0.014, 24), (0.0, -0.026, height + 0.023), (41.0, 0.0, 0.0))
    white = Material(from_hex("#f7f8fa"), roughness=0.4)
    floor = quad((-half, half, 0), (width, 0, 0), (0, -width, 0))
    return [
        (
            merge([wide, narrow]),
            printed(prints.milk_carton(pick(rng, ("MILK", "MILK", "OAT", "SOY", "CREAM")), colour), 0.4),
        ),
        (merge([*roof, *gables, floor]), Material(from_hex(colour), roughness=0.4)),
        (fin, white),
        (cap, plastic(colour)),
    ]


def can(rng: np.random.Generator) -> Pieces:
    """A tin can with a paper label."""
    radius, height = 0.040 * rng.uniform(0.9, 1.08), 0.115 * rng.uniform(0.72, 1.1)
    title, ground, accent, ink = (
        ("SOUP", "#c22a24", "#f0c040", "#fff6e4"),
        ("BEANS", "#2a7a6a", "#e8843a", "#fff6e4"),
        ("CORN", "#3a8a3a", "#f5d040", "#fffbe8"),
        ("TUNA", "#24507a", "#8fc0e0", "#fff6e4"),
        ("PEAS", "#efe6d2", "#4f8a3a", "#2f4a24"),
        ("PEARS", "#e8c23a", "#8fae3a", "#4a3a1c"),
        ("TOMATO", "#f2efe6", "#c22f2a", "#7a1f1a"),
        ("COCOA", "#5a3422", "#d8a860", "#f4e4c8"),
    )[int(rng.integers(8))]
    metal = [
        (0.0, 0.0025),
        (radius - 0.003, 0.0025),
        (radius - 0.001, 0.0),
        (radius + 0.001, 0.001),
        (radius + 0.001, 0.004),
        (radius - 0.0006, 0.006),
        (radius - 0.0006, height - 0.006),
        (radius + 0.001, height - 0.004),
        (radius + 0.001, height - 0.001),
        (radius - 0.001, height),
        (radius - 0.003, height - 0.004),
        (radius * 0.7, height - 0.0035),
        (radius * 0.66, height - 0.0045),
        (0.0, height - 0.0045),
    ]
    label = lathe([(radius, 0.007), (radius, height - 0.007)], 40, (2.0, 1.0))
    return [
        (lathe(metal, 40), steel()),
        (label, printed(prints.wrap_label(title, ground, accent, ink), 0.45)),
    ]


def soap(rng: np.random.Generator) -> Pieces:
    """A pump bottle of soap, its spout towards +x."""
    size = rng.uniform(1.0, 1.12)
    colour, other = two_colours(rng)
    foot, top = ((0.040, 0.040), (0.042, 0.034), (0.034, 0.041))[int(rng.integers(3))]
    body = [
        (0.0, 0.0),
        (foot - 0.004, 0.0),
        (foot, 0.006),
        (foot, 0.03),
        (top, 0.115),
        (top * 0.8, 0.136),
        (0.014, 0.144),
        (0.014, 0.152),
    ]
    collar = transform(cylinder(0.016, 0.018, 24), (0.0, 0.0, 0.148))
    spout = smooth_profile([[-0.014, 0, 0.203], [0.02, 0, 0.203], [0.046, 0, 0.203], [0.052, 0, 0.192]])
    pump = merge([collar, tube([[0, 0, 0.165], [0, 0, 0.2]], 0.0055), tube(spout, 0.0075)])
    low, high = np.interp([0.045, 0.095], [0.03, 0.115], [foot, top]) + 0.0007
    label = lathe([(low, 0.045), (high, 0.095)], 36, (2.0, 1.0))
    pieces: Pieces = [
        (lathe(smooth_profile([*body, (0.0, 0.1525)]), 36), glazed(colour, 0.1)),
        (
            label,
            printed(prints.wrap_label(pick(rng, ("SOAP", "LIMA", "ALOE", "FRESH")), "#f7f7f2", other, "#2f5f5a")),
        ),
        (pump, (WHITE_PAINT, plastic("#26272a"), steel(), plastic(other))[int(rng.integers(4))]),
    ]
    return [(transform(mesh, scale=size), material) for mesh, material in pieces]


def spray_bottle(rng: np.random.Generator) -> Pieces:
    """A cleaner's spray bottle: trigger and nozzle towards +x."""
    colour, head = two_colours(rng)
    width, tall = rng.uniform(0.85, 1.1), rng.uniform(0.9, 1.05)
    body = transform(lathe(smooth_profile(_SPRAY), 36), scale=(1.0, 0.68, 1.0))
    neck = transform(cylinder(0.017, 0.028, 24), (0.0, 0.0, 0.168))
    top = transform(rounded_box((0.085, 0.028, 0.036), 0.010, 2), (0.016, 0.0, 0.213))
    nozzle = transform(cylinder(0.009, 0.016, 18), (0.056, 0.0, 0.217), (0.0, 90.0, 0.0))
    trigger = tube(smooth_profile([[0.036, 0, 0.198], [0.05, 0, 0.18], [0.042, 0, 0.155]]), 0.006, 10)
    pieces: Pieces = [
        (body, plastic(colour, 0.2)),
        (merge([neck, top]), plastic(head)),
        (merge([nozzle, trigger]), plastic(pick(rng, ("#d2402c", "#f2f2ef", "#26272a", colour)))),
    ]
    size = rng.uniform(1.0, 1.12)
    return [(transform(mesh, scale=(size * width, size * width, size * tall)), material) for mesh, material in pieces]


_SPRAY = (
    (0.0, 0.0),
    (0.042, 0.0),
    (0.048, 0.008),
    (0.048, 0.095),
    (0.03, 0.14),
    (0.018, 0.158),
    (0.018, 0.172),
    (0.0, 0.173),
)
