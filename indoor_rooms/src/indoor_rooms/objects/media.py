"""Devices to listen to and to look through: headphones, radio, camera."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import arc, cylinder, disc, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform
from indoor_rooms.geometry.pieces import Pieces, standing
from indoor_rooms.materials import prints_devices
from indoor_rooms.materials.surfaces import (
    BLACK_GLASS,
    BLACK_PLASTIC,
    CHROME,
    cloth,
    metallic,
    plastic,
    printed,
    rubber,
    steel,
    wood,
)
from indoor_rooms.objects.shaping import PALETTE, facing, pick, prism, rounded_rectangle


def _ear_piece(radius: float, side: float) -> tuple[Mesh, Mesh]:
    """The shell and the cushion of one ear, its back towards `side` along x, about the origin."""
    shell = [(0.0, 0.0), (radius * 0.7, 0.0), (radius, 0.008), (radius, 0.016), (radius * 0.9, 0.018)]
    pad = [(radius * 0.9, 0.0), (radius, 0.006), (radius * 0.85, 0.015), (radius * 0.5, 0.013), (0.0, 0.004)]
    turn = (0.0, -90.0 * side, 0.0)
    back = transform(lathe(smooth_profile(shell, 1), 28), (side * 0.017, 0.0, 0.0), turn)
    return back, transform(lathe(smooth_profile(pad, 1), 28), (side * 0.0, 0.0, 0.0), turn)


def headphones(rng: np.random.Generator) -> Pieces:
    """Headphones lying on the table, band towards +y, or hanging on a stand with their band across x."""
    colour = pick(rng, (*PALETTE, "#26272a", "#26272a", "#f2f2ef", "#c9ccd0"))
    pad = pick(rng, ("#202124", "#202124", "#6a4a34", "#d8d4cc"))
    radius, reach, rise = rng.uniform(0.034, 0.043), rng.uniform(0.074, 0.084), rng.uniform(0.135, 0.16)
    bow = arc((0.0, 0.0, 0.0), reach, 0, 180, 22)
    bow[:, 2] = bow[:, 2] / reach * rise
    band = transform(tube(bow, 0.0042, 10), scale=(1.0, rng.uniform(2.0, 3.4), 1.0))
    rest = arc((0.0, 0.0, 0.0), reach - 0.006, 40, 140, 12)
    rest[:, 2] = rest[:, 2] / reach * rise
    lining = transform(tube(rest, 0.006, 10), scale=(1.0, 2.4, 1.0))
    shells, pads = zip(*(_ear_piece(radius, side) for side in (-1.0, 1.0)), strict=True)
    sides = [(-reach, 0.0, -0.01), (reach, 0.0, -0.01)]
    shell = merge([transform(mesh, place) for mesh, place in zip(shells, sides, strict=True)])
    soft = merge([transform(mesh, place) for mesh, place in zip(pads, sides, strict=True)])
    look = plastic(colour, 0.3) if rng.random() < 0.6 else metallic(colour)
    pieces: Pieces = [
        (shell, look),
        (band, look if rng.random() < 0.5 else BLACK_PLASTIC),
        (merge([soft, lining]), rubber(pad)),
    ]
    if rng.random() < 0.5:
        # Ears and the top of the band touch the table.
        lean = -90.0 - np.degrees(np.arcsin((radius - 0.012) / (rise + 0.01)))
        return standing([(transform(mesh, rotate=(lean, 0.0, 0.0)), material) for mesh, material in pieces])
    height = rise + 0.012 - 0.0175 + radius * 1.2
    post = transform(cylinder(0.007, height, 16), (0.0, 0.0, 0.004))
    hook = transform(cylinder(0.011, 0.05, 18, 0.003), (0.0, 0.025, height - 0.004), (90.0, 0.0, 0.0))
    foot = cylinder(rng.uniform(0.055, 0.07), 0.009, 36, 0.002)
    frame = (wood(), steel(), BLACK_PLASTIC, plastic("#f2f2ef"))[int(rng.integers(4))]
    lift = height + 0.007 - (rise - 0.012)
    return [(merge([post, hook, foot]), frame)] + [
        (transform(mesh, (0.0, 0.0, lift)), material) for mesh, material in pieces
    ]


def radio(rng: np.random.Generator) -> Pieces:
    """A table radio or a loudspeaker, its front towards -y."""
    if rng.random() < 0.25:
        return _speaker(rng)
    width, height, depth = rng.uniform(0.22, 0.32), rng.uniform(0.13, 0.19), rng.uniform(0.08, 0.12)
    colour = pick(rng, PALETTE)
    body = wood("#6a4024", "#a06a3c", int(rng.integers(3))) if rng.random() < 0.4 else plastic(colour, 0.3)
    outline = rounded_rectangle(width, height, _corner(rng, height), 5)
    case = facing(prism(outline, depth, 0.004, 3.0), depth / 2, 0.006 + height / 2)
    feet = merge([transform(cylinder(0.009, 0.009, 14), (x * width * 0.3, 0.0, 0.0)) for x in (-1, 1)])
    front = -depth / 2
    side = float(rng.choice([-1.0, 1.0]))
    ground, hole = ("#3a3430", "#191614") if rng.random() < 0.5 else ("#d8c9a8", "#7a6848")
    slots = bool(rng.random() < 0.5)
    middle = 0.006 + height * 0.52
    round_front = rng.random() < 0.4
    if round_front:
        size = height * 0.36
        speaker = facing(disc(size, 0.0022, 36, 3.0), front, middle)
        ring = lathe([(size + 0.004, 0.0), (size + 0.004, 0.003), (size - 0.001, 0.0035), (size - 0.001, 0.0)], 36)
        ring = facing(ring, front, middle)
    else:
        wide, tall = width * 0.42, height * 0.66
        speaker = facing(prism(rounded_rectangle(wide, tall, 0.01), 0.003, 0.001, 12.0), front + 0.0005, middle)
        edge = rounded_rectangle(wide + 0.008, tall + 0.008, 0.013)
        ring = facing(prism(edge, 0.002, 0.0005), front + 0.0005, middle)
    pieces: Pieces = [
        (case, body),
        (transform(speaker, (side * width * 0.23, 0.0, 0.0)), printed(prints_devices.grille(ground, hole, slots))),
        (transform(ring, (side * width * 0.23, 0.0, 0.0)), steel()),
    ]
    scale_x = -side * width * 0.23
    dial_ground, ink = (("#f4e8c4", "#40301c"), ("#20242a", "#e8e4d8"))[int(rng.integers(2))]
    dial = quad(
        (scale_x - width * 0.19, front - 0.0016, middle + height * 0.06), (width * 0.38, 0, 0), (0, 0, height * 0.26)
    )
    pieces.append((dial, printed(prints_devices.tuning_scale(dial_ground, ink), 0.25)))
    knob = [(0.0, 0.0), (0.015, 0.0), (0.015, 0.003), (0.013, 0.012), (0.010, 0.0135), (0.0, 0.0135)]
    knobs = [
        transform(
            facing(lathe(knob[1:], 24), front + 0.001, middle - height * 0.18), (scale_x + x * width * 0.1, 0.0, 0.0)
        )
        for x in (-1, 1)
    ]
    pieces += [(merge(knobs), metallic("#c9b27a") if rng.random() < 0.5 else BLACK_PLASTIC), (feet, BLACK_PLASTIC)]
    top = 0.006 + height
    if rng.random() < 0.5:
        bow = smooth_profile(
            [
                [-width * 0.32, 0, top - 0.003],
                [-width * 0.3, 0, top + 0.035],
                [width * 0.3, 0, top + 0.035],
                [width * 0.32, 0, top - 0.003],
            ]
        )
        pieces.append((tube(bow, 0.005, 10), CHROME if rng.random() < 0.5 else rubber("#5a3a26")))
    if rng.random() < 0.5:
        x = -side * width * 0.36
        mast = tube(
            [[x, depth * 0.3, top - 0.004], [x - side * 0.05, depth * 0.3, top + rng.uniform(0.07, 0.13)]], 0.0016, 8
        )
        pieces.append((mast, CHROME))
    return pieces


def _corner(rng: np.random.Generator, height: float) -> float:
    """Corners of a case from nearly square to quite round, metres."""
    return float(rng.choice([0.006, 0.02, 0.3 * height]))


def _speaker(rng: np.random.Generator) -> Pieces:
    """A wireless loudspeaker: an upright cylinder covered with cloth."""
    radius, height = rng.uniform(0.04, 0.055), rng.uniform(0.13, 0.19)
    colour = pick(rng, PALETTE)
    ends = [(0.0, 0.0), (radius - 0.004, 0.0), (radius, 0.004), (radius, 0.016), (radius - 0.002, 0.018)]
    body = lathe(
        [(radius - 0.002, 0.016), (radius - 0.0015, 0.02), (radius - 0.0015, height - 0.012)], 36, (8.0, 4.0)
    )
    lid = [(radius - 0.002, height - 0.014), (radius, height - 0.01), (radius - 0.004, height), (0.0, height - 0.002)]
    buttons = [transform(cylinder(0.006, 0.003, 14), (0.016 * x, 0.0, height - 0.003)) for x in (-1, 0, 1)]
    frame = plastic(pick(rng, ("#26272a", "#e8e6e0", "#8f9499")))
    strap = tube(arc((radius, 0.0, height * 0.62), 0.022, 90, -90, 12), 0.003, 8)
    return [
        (merge([lathe(ends, 36), lathe(lid, 36)]), frame),
        (body, cloth(colour)),
        (merge([*buttons, strap]), rubber(pick(rng, ("#c9ccd0", "#26272a", "#d8642c")))),
    ]


def camera(rng: np.random.Generator) -> Pieces:
    """A camera with its lens towards -y."""
    width, height, depth = rng.uniform(0.12, 0.145), rng.uniform(0.074, 0.09), rng.uniform(0.034, 0.042)
    top_colour = pick(rng, ("#26272a", "#c9ccd0", "#c9ccd0", "#e8e6e0"))
    skin = pick(rng, ("#1f2022", "#1f2022", "#5a3a26", "#8a3a30", "#2d4a5a", "#c9a77a"))
    outline = rounded_rectangle(width, depth, depth * 0.4, 5)
    body = transform(prism(outline, height * 0.68, 0.002), (0.0, 0.0, 0.002))
    foot = prism(outline, 0.004, 0.001)
    lid = transform(prism(outline, height * 0.24, 0.003), (0.0, 0.0, height * 0.66))
    lens_x, lens_z, lens = rng.uniform(-0.008, 0.014), height * 0.44, height * rng.uniform(0.33, 0.4)
    long = rng.uniform(0.025, 0.06)
    barrel = [
        (lens, 0.0),
        (lens, long * 0.4),
        (lens * 0.93, long * 0.42),
        (lens * 0.93, long * 0.8),
        (lens, long * 0.82),
        (lens, long),
        (lens * 0.88, long),
        (lens * 0.66, long - 0.008),
    ]
    glass = [(lens * 0.68, long - 0.008), (lens * 0.4, long - 0.0045), (0.0, long - 0.003)]
    front = -depth / 2 + 0.001
    tube_mesh = transform(facing(lathe(barrel, 36), front, lens_z), (lens_x, 0.0, 0.0))
    eye = transform(facing(lathe(glass, 30), front, lens_z), (lens_x, 0.0, 0.0))
    ring = [(lens + 0.001, long * 0.44), (lens + 0.001, long * 0.52), (lens * 0.92, long * 0.53)]
    band = transform(facing(lathe(ring, 36), front, lens_z), (lens_x, 0.0, 0.0))
    top = height * 0.9
    release = transform(cylinder(0.0055, 0.006, 16), (-width * 0.34, 0.0, top - 0.001))
    wheel = transform(cylinder(0.0095, 0.008, 22, 0.001), (width * 0.3, 0.0, top - 0.001))
    pieces: Pieces = [
        (body, rubber(skin)),
        (merge([lid, foot]), metallic(top_colour) if top_colour == "#c9ccd0" else plastic(top_colour)),
        (tube_mesh, BLACK_PLASTIC),
        (eye, BLACK_GLASS),
        (merge([release, wheel]), CHROME),
        (band, metallic(pick(rng, ("#c9ccd0", "#c8372d", "#d0a24a")))),
    ]
    if rng.random() < 0.55:
        hump = prism([(-0.022, 0.0), (0.022, 0.0), (0.014, 0.016), (-0.014, 0.016)], depth * 0.8, 0.002)
        pieces.append((transform(facing(hump, depth * 0.4, top - 0.002), (lens_x, 0.0, 0.0)), BLACK_PLASTIC))
    else:
        finder = quad((width * 0.2, -depth / 2 - 0.0008, height * 0.72), (0.018, 0, 0), (0, 0, height * 0.12))
        pieces.append((finder, BLACK_GLASS))
    if rng.random() < 0.6:
        grip = transform(
            rounded_box((0.02, 0.014, height * 0.62), 0.006, 2), (-width * 0.38, -depth / 2, height * 0.36)
        )
        pieces.append((grip, rubber(skin)))
    return pieces
