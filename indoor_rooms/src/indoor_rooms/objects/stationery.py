"""Things of the desk: scissors, stapler, tape dispenser, pen cup, tissue box."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, lathe, tube
from indoor_rooms.geometry.mesh import Mesh, grid_faces, merge, quad, smooth_normals, transform
from indoor_rooms.geometry.pieces import Pieces, placed, standing
from indoor_rooms.materials import prints_patterns
from indoor_rooms.materials.surfaces import (
    BLACK_PLASTIC,
    CHROME,
    PAPER,
    glazed,
    metallic,
    plastic,
    printed,
    steel,
    wood,
)
from indoor_rooms.objects.shaping import (
    PALETTE,
    closed_curve,
    double_sided,
    facing,
    pick,
    prism,
    rounded_rectangle,
    two_colours,
)

_BLADE = ((-0.007, -0.024), (0.006, -0.028), (0.0085, 0.0), (0.0075, 0.06), (0.0015, 0.112), (-0.0015, 0.112))


def scissors(rng: np.random.Generator) -> Pieces:
    """Scissors lying a little open, blades towards +y, about 0.2 m long."""
    colour, opening = pick(rng, (*PALETTE[:12], "#26272a", "#e0682a")), rng.uniform(7.0, 17.0)
    width, length, thick = rng.uniform(0.015, 0.019), rng.uniform(0.024, 0.032), rng.uniform(0.0045, 0.006)
    angles = np.linspace(0.0, 2 * np.pi, 25)
    blades, grips = [], []
    for side in (1.0, -1.0):
        # The second arm is the first turned over; its ring is larger on many scissors.
        large = 1.0 if side > 0 else rng.uniform(0.8, 1.25)
        reach = -0.045 - length * large
        ring = np.stack(
            [0.021 + width * np.cos(angles) * large, reach + length * large * np.sin(angles), 0 * angles], axis=1
        )
        shank = [[0.0, -0.016, 0.0], [0.003, -0.028, 0.0], [0.012, -0.047, 0.0]]
        blade = transform(prism(_BLADE, 0.0017, 0.0004), (0.0, 0.0, 0.0001))
        arms = (blade, merge([tube(ring, thick, 10, capped=False), tube(shank, [0.006, 0.008, thick], 10)]))
        turned = [
            transform(transform(mesh, rotate=(0.0, 0.0 if side > 0 else 180.0, 0.0)), rotate=(0, 0, side * opening))
            for mesh in arms
        ]
        blades.append(turned[0])
        grips.append(turned[1])
    screw = transform(cylinder(0.0045, 0.0056, 18, 0.001), (0.0, 0.0, -0.0028))
    pieces: Pieces = [
        (merge(blades), metallic("#c9cccf", 0.25) if rng.random() < 0.8 else metallic("#3a3d42", 0.35)),
        (merge(grips), plastic(colour, rng.uniform(0.25, 0.55))),
        (screw, CHROME),
    ]
    return standing(placed(pieces, scale=rng.uniform(0.92, 1.06)))


def stapler(rng: np.random.Generator) -> Pieces:
    """A stapler lying along x, its mouth towards +x."""
    colour, lower = two_colours(rng)
    if rng.random() < 0.5:
        lower = "#26272a"
    width, rise = rng.uniform(0.026, 0.036), rng.uniform(0.0, 0.012)
    foot = prism(rounded_rectangle(0.145, width, 0.4 * width), 0.009, 0.002)
    anvil = transform(rounded_box((0.02, width * 0.5, 0.002), 0.0005), (0.055, 0.0, 0.0095))
    upper = closed_curve(
        [
            (-0.07, 0.016),
            (0.066, 0.023 + rise),
            (0.078, 0.03 + rise),
            (0.07, 0.043 + rise),
            (0.01, 0.056 + rise / 2),
            (-0.06, 0.048),
            (-0.08, 0.034),
        ],
        int(rng.integers(1, 3)),
    )
    arm = facing(prism(upper, width * 0.86, 0.004), width * 0.43)
    rail = [(-0.06, 0.013), (0.068, 0.015 + rise * 0.9), (0.068, 0.027 + rise), (-0.06, 0.027)]
    magazine = facing(prism(rail, width * 0.5, 0.0008), width * 0.25)
    hinge = transform(rounded_box((0.026, width * 0.66, 0.03), 0.003), (-0.055, 0.0, 0.022))
    shell = plastic(colour, 0.3) if rng.random() < 0.6 else glazed(colour)
    return [
        (arm, shell),
        (foot, plastic(lower)),
        (merge([magazine, anvil]), steel()),
        (hinge, BLACK_PLASTIC if lower != "#26272a" else shell),
    ]


def tape_dispenser(rng: np.random.Generator) -> Pieces:
    """A desk dispenser of sticky tape, its cutter towards +x."""
    colour = pick(rng, PALETTE)
    core, tape = pick(rng, ("#e8e6e0", "#c22f2a", "#2f5fa8", "#eab02e")), pick(rng, ("#d9cfa8", "#c9a35a", "#e4e8ea"))
    width, length = rng.uniform(0.044, 0.056), rng.uniform(0.9, 1.1)
    hub_z = 0.046
    foot = prism(rounded_rectangle(0.15, width, 0.012), 0.02, 0.003)
    cheek = closed_curve(
        [(-0.07, 0.012), (0.07, 0.012), (0.072, 0.03), (0.03, 0.04), (0.0, 0.056), (-0.03, 0.06), (-0.066, 0.04)], 2
    )
    sides = [facing(prism(cheek, 0.006, 0.0015), y) for y in (-width / 2 + 0.009, width / 2 - 0.003)]
    nose = transform(rounded_box((0.014, width - 0.012, 0.022), 0.003), (0.062, 0.0, 0.026))
    roll, inner = rng.uniform(0.03, 0.036), 0.02
    ring = [(inner, 0.0), (roll, 0.0), (roll, 0.0), (roll, 0.019), (roll, 0.019), (inner, 0.019), (inner, 0.0)]
    hub = [(0.0, 0.0), (inner + 0.0005, 0.0), (inner + 0.0005, 0.021), (0.014, 0.021), (0.012, 0.016), (0.0, 0.016)]
    strip = double_sided(
        quad((-0.018, -0.0095, hub_z + roll - 0.0008), (0.082, 0, 0.043 - hub_z - roll), (0, 0.019, 0))
    )
    teeth = transform(rounded_box((0.005, width - 0.02, 0.014), 0.001), (0.0675, 0.0, 0.037))
    pieces: Pieces = [
        (merge([foot, *sides, nose]), plastic(colour, rng.uniform(0.2, 0.5))),
        (transform(facing(lathe(ring, 36), 0.0095, hub_z), (-0.018, 0.0, 0.0)), plastic(tape, 0.2)),
        (transform(facing(lathe(hub, 30), 0.0105, hub_z), (-0.018, 0.0, 0.0)), plastic(core)),
        (strip, plastic(tape, 0.15)),
        (teeth, CHROME),
    ]
    return placed(pieces, scale=length)


def _pen(length: float, radius: float, pencil: bool) -> tuple[Mesh, Mesh]:
    """A pen upright on z = 0, its upper end at `length`: the barrel, and the cap or sharpened end."""
    if pencil:
        barrel = lathe([(0.0, 0.0), (radius, 0.0), (radius, length - 0.018)], 8)
        return barrel, lathe([(radius, length - 0.018), (radius * 0.35, length - 0.004), (0.0, length)], 8)
    barrel = lathe([(0.0, 0.0), (radius, 0.0), (radius, length * 0.66)], 12)
    clip = transform(rounded_box((0.0015, 0.003, 0.034), 0.0005), (radius + 0.001, 0.0, length - 0.024))
    top = [(radius * 1.15, length * 0.66), (radius * 1.15, length - 0.003), (radius * 0.7, length), (0.0, length)]
    return barrel, merge([lathe(top, 12), clip])


def pen_cup(rng: np.random.Generator) -> Pieces:
    """A cup with pens, pencils and perhaps a ruler."""
    colour, other = two_colours(rng)
    size, height, wall = rng.uniform(0.034, 0.042), rng.uniform(0.085, 0.11), 0.0035
    flare = rng.choice([0.82, 1.0, 1.0, 1.12])
    segments = int(rng.choice([36, 36, 6, 4]))
    outside = [(0.0, 0.0), (size * flare, 0.0), (size * flare, 0.0), (size, height), (size, height)]
    inside = [(size - wall, height), (size - wall, height), (size * flare - wall, 0.012), (0.0, 0.012)]
    cup = _facetted(lathe([*outside, *inside], segments, (2.0, 1.0)), segments)
    look = (
        plastic(colour),
        glazed(colour),
        steel(),
        wood("#7a4f2c", "#b5824e", int(rng.integers(3))),
        printed(prints_patterns.pattern(pick(rng, prints_patterns.PATTERNS), colour, other, "#f2f2ef", 4, 0.0)),
    )[int(rng.integers(5))]
    pieces: Pieces = [(cup, look)]
    count = int(rng.integers(5, 9))
    for index in range(count):
        pencil = rng.random() < 0.4
        barrel, end = _pen(rng.uniform(0.135, 0.175), rng.uniform(0.0033, 0.0048), pencil)
        lean, turn = rng.uniform(6, 13), 360 * index / count + rng.uniform(-18, 18)
        place = (0.35 * size, 0.0, 0.0135)
        moved = [
            transform(transform(mesh, place, (0.0, lean * 0.75, 0.0)), rotate=(0.0, 0.0, turn))
            for mesh in (barrel, end)
        ]
        shade = pick(rng, PALETTE)
        pieces.append((moved[0], plastic(shade)))
        pieces.append((moved[1], wood("#c99a62", "#e4c190", 8) if pencil else plastic(pick(rng, (shade, "#26272a")))))
    if rng.random() < 0.4:
        ruler = transform(rounded_box((0.026, 0.002, 0.2), 0.0006, base=True), (0.0, 0.0, 0.0135), (-7.0, 0.0, 0.0))
        pieces.append((ruler, plastic(pick(rng, ("#e8d49a", "#9fd0e8", "#f2f2ef", "#e8a03a")), 0.25)))
    return pieces


def _facetted(mesh: Mesh, segments: int) -> Mesh:
    """A lathe of few segments with flat sides; one of many as it is."""
    if segments > 8:
        return mesh
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    faces = np.arange(3 * len(mesh.faces)).reshape(-1, 3)
    flat = mesh.faces.ravel()
    return Mesh(mesh.vertices[flat], np.repeat(normals, 3, axis=0), mesh.uvs[flat], faces)


def tissue_box(rng: np.random.Generator) -> Pieces:
    """A box of paper tissues, one of them pulled out."""
    cube = rng.random() < 0.4
    width, depth, height = (0.115, 0.115, 0.125) if cube else (0.23, 0.12, rng.uniform(0.06, 0.09))
    ground, first = two_colours(rng)
    kind = pick(rng, prints_patterns.PATTERNS)
    print_ = prints_patterns.pattern(kind, ground, first, "#f2f2ef", 4, 0.0)
    box = rounded_box((width, depth, height), 0.002, 1, rng.uniform(7.0, 12.0), base=True)
    slot = prism(rounded_rectangle(0.095 if not cube else 0.06, 0.036, 0.018, 6), 0.0012, 0.0003)
    turns, steps = 48, 8
    angle, along = np.meshgrid(np.linspace(0, 2 * np.pi, turns + 1), np.linspace(0.0, 1.0, steps + 1))
    fold = (
        1
        + 0.32 * along * np.cos(5 * angle + rng.uniform(0, 6))
        + 0.16 * along * np.cos(3 * angle + rng.uniform(0, 6))
    )
    reach = (0.006 + 0.042 * along**1.3) * fold
    rise = 0.075 * along**0.8 * (1 + 0.12 * np.cos(2 * angle + 1.0) * along)
    points = np.stack([1.25 * reach * np.cos(angle), 0.7 * reach * np.sin(angle), rise], axis=-1)
    sheet = smooth_normals(
        points.reshape(-1, 3), np.stack([angle, along], axis=-1).reshape(-1, 2), grid_faces(steps + 1, turns + 1)
    )
    return [
        (box, printed(print_, 0.45)),
        (transform(slot, (0.0, 0.0, height - 0.0004)), PAPER),
        (transform(double_sided(sheet), (0.0, 0.0, height - 0.001)), plastic("#fbfbf9", 0.95)),
    ]
