"""Chairs, bin, coat stand and flip chart of an office. Centred at the origin on z = 0; metres."""

from __future__ import annotations

import numpy as np

from indoor_rooms.furniture.building import CLOTH_REPEATS, at, padded
from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, lathe, smooth_profile, sphere, tube
from indoor_rooms.geometry.mesh import Mesh, grid_faces, merge, quad, smooth_normals, transform
from indoor_rooms.geometry.pieces import Pieces, standing
from indoor_rooms.materials import board_prints
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import BLACK_PLASTIC, CHROME, STALK, WHITE_PAINT, cloth, printed, steel

OFFICE_SEAT_HEIGHT = 0.48
MEETING_SEAT_HEIGHT = 0.46


def _backrest(width: float, height: float, thickness: float, bow: float, lean: float) -> Mesh:
    """An upholstered backrest, its middle at the origin.

    Args:
        width: metres.
        height: metres.
        thickness: of the padding, metres.
        bow: how far its sides come forwards (+y), metres.
        lean: degrees it leans back (to -y).
    """
    turn = np.linspace(0.0, 2 * np.pi, 25)
    # The cross-section in (y, z): a flat loop with round ends.
    y = thickness / 2 * np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** 0.6
    z = height / 2 * np.sign(np.sin(turn)) * np.abs(np.sin(turn)) ** 0.3
    columns = np.linspace(-1.0, 1.0, 9)
    # The outermost loops shrink to a line and close the sides.
    stations = [(-1.0, 0.0), *((float(column), 1.0) for column in columns), (1.0, 0.0)]
    loops = []
    for across, full in stations:
        lower = 1 - 0.12 * across**4
        x = np.full_like(y, across * width / 2)
        loops.append(np.stack([x, full * y + bow * across**2, full**0.2 * lower * z], axis=1))
    vertices = np.round(np.concatenate(loops), 9)
    uvs = CLOTH_REPEATS * vertices[:, [0, 2]]
    sheet = smooth_normals(vertices, uvs, grid_faces(len(loops), len(turn))[:, ::-1])
    return transform(sheet, rotate=(lean, 0.0, 0.0))


def office_chair(fabric: Material) -> Pieces:
    """A swivel chair with armrests on five castors facing +y, its seat at `OFFICE_SEAT_HEIGHT`.

    Args:
        fabric: of seat and back.
    """
    spokes: list[Mesh] = []
    wheels: list[Mesh] = []
    for angle in np.radians(90 + 72 * np.arange(5)):
        x, y = float(np.cos(angle)), float(np.sin(angle))
        spokes.append(tube([[0.02 * x, 0.02 * y, 0.098], [0.29 * x, 0.29 * y, 0.072]], [0.024, 0.015], 10))
        spokes.append(at(cylinder(0.010, 0.022, 10, 0.0), 0.28 * x, 0.28 * y, 0.048))
        roll = transform(cylinder(0.025, 0.040, 16, 0.006), (0.28 * x, 0.28 * y, 0.025), (0.0, 90.0, 0.0))
        aim = float(np.degrees(angle)) + 30.0
        turned = transform(at(roll, -0.28 * x - 0.020, -0.28 * y), rotate=(0.0, 0.0, aim))
        wheels.append(at(turned, 0.28 * x, 0.28 * y))
    lift = [at(cylinder(0.034, 0.13, 20, 0.004), z=0.07), at(cylinder(0.015, 0.20, 16, 0.0), z=0.19)]
    plate = at(rounded_box((0.20, 0.24, 0.03), 0.008), z=0.385)
    seat = at(padded((0.49, 0.47, 0.08), 0.07, 0.5, 3), 0.0, 0.01, OFFICE_SEAT_HEIGHT - 0.04)
    shell = at(padded((0.43, 0.41, 0.02), 0.06, 0.16), 0.0, 0.0, OFFICE_SEAT_HEIGHT - 0.0705)
    back = at(_backrest(0.44, 0.50, 0.05, 0.055, 8.0), 0.0, -0.26, 0.825)
    spine = tube(
        smooth_profile([[0, -0.09, 0.385], [0, -0.24, 0.385], [0, -0.285, 0.48], [0, -0.30, 0.80]], 2),
        [0.022, 0.022, 0.016], 12,
    )  # fmt: skip
    black = [*spokes, *wheels, plate, shell, spine]
    for side in (-1, 1):
        post = [[side * 0.15, 0.0, 0.40], [side * 0.285, 0.0, 0.40], [side * 0.285, -0.02, 0.655]]
        black.append(tube(smooth_profile(post, 2), 0.013, 10))
        pad = padded((0.075, 0.25, 0.03), 0.025, 0.5)
        black.append(at(pad, side * 0.285, 0.02, 0.668))
    return standing([(merge([seat, back]), fabric), (merge(black), BLACK_PLASTIC), (merge(lift), CHROME)])


def meeting_chair(fabric: Material, frame: Material) -> Pieces:
    """A cantilever chair of bent tube facing +y, its seat at `MEETING_SEAT_HEIGHT`.

    Args:
        fabric: of seat and back.
        frame: of the tube.
    """
    radius, x, seat = 0.0125, 0.225, MEETING_SEAT_HEIGHT - 0.048
    # From the top of the back down, along the seat, down to the floor and back along it, then the same mirrored.
    half = [
        [x, -0.268, 0.84], [x, -0.23, 0.60], [x, -0.205, seat], [x, 0.0, seat], [x, 0.245, seat], [x, 0.23, 0.2],
        [x, 0.215, radius], [x, 0.0, radius], [x, -0.22, radius],
    ]  # fmt: skip
    other = [[-px, py, pz] for px, py, pz in reversed(half)]
    bend = tube(smooth_profile([*half, *other], 3), radius, 10)
    bend = at(bend, z=-float(bend.vertices[:, 2].min()))
    pad = at(padded((0.46, 0.44, 0.055), 0.035, 0.7, 2), 0.0, 0.015, MEETING_SEAT_HEIGHT - 0.0275)
    back = at(_backrest(0.43, 0.34, 0.036, 0.02, 9.0), 0.0, -0.243, 0.69)
    return [(bend, frame), (merge([pad, back]), fabric)]


def paper_bin(radius: float = 0.14, height: float = 0.31) -> Pieces:
    """An open waste paper basket with crumpled paper in it."""
    foot = radius * 0.8
    profile = [
        (0.0, 0.0), (foot, 0.0), (radius, height - 0.012), (radius + 0.005, height - 0.006), (radius + 0.003, height),
        (radius - 0.004, height - 0.002), (foot - 0.004, 0.006), (0.0, 0.005),
    ]  # fmt: skip
    basket = lathe(smooth_profile(profile, 1), 40)
    paper = []
    for x, y, size, z in ((0.04, 0.02, 0.055, 0.14), (-0.05, 0.03, 0.045, 0.17), (0.0, -0.045, 0.05, 0.18)):
        ball = sphere(size, 9)
        paper.append(transform(ball, (x, y, z), (20.0, 0.0, 900 * x)))
    return [(basket, BLACK_PLASTIC), (merge(paper), WHITE_PAINT)]


def coat_stand(coat: str | None = "#3d4a5c") -> Pieces:
    """A wooden coat stand, 1.75 m high, with hooks and perhaps a scarf in a colour (None: nothing hangs on it)."""
    pole = at(lathe([(0.0, 0.0), (0.022, 0.0), (0.022, 0.0), (0.018, 1.66), (0.03, 1.70), (0.0, 1.735)], 20), z=0.02)
    parts = [pole]
    for angle in np.radians([0.0, 90.0, 180.0, 270.0]):
        c, s = float(np.cos(angle)), float(np.sin(angle))
        foot = [[0.0, 0.0, 0.30], [0.10 * c, 0.10 * s, 0.12], [0.24 * c, 0.24 * s, 0.014]]
        parts.append(tube(smooth_profile(foot, 2), [0.014, 0.013], 10))
        turn = angle + np.pi / 4
        c, s = float(np.cos(turn)), float(np.sin(turn))
        hook = [[0.0, 0.0, 1.55], [0.09 * c, 0.09 * s, 1.56], [0.13 * c, 0.13 * s, 1.66]]
        parts.append(tube(smooth_profile(hook, 2), [0.010, 0.008], 10))
        parts.append(at(sphere(0.013, 12), 0.13 * c, 0.13 * s, 1.655))
    pieces: Pieces = [(merge(parts), STALK)]
    if coat:
        scarf = []
        for side, low in ((-1, 0.95), (1, 1.12)):
            strip = padded((0.10, 0.016, 1.60 - low), 0.007)
            scarf.append(
                transform(strip, (0.068 + side * 0.012, -0.068 + side * 0.012, (1.60 + low) / 2), (0, 0, 45))
            )
        pieces.append((merge(scarf), cloth(coat)))
    return standing(pieces)


def flip_chart(seed: int = 0) -> Pieces:
    """A flip chart on a tripod facing -y, 1.85 m high, with a drawing on its paper."""
    lean = (-8.0, 0.0, 0.0)
    board = transform(rounded_box((0.70, 0.018, 1.00), 0.005), rotate=lean)
    sheet = transform(quad((-0.32, -0.013, -0.48), (0.64, 0, 0), (0, 0, 0.94)), rotate=lean)
    clamp = transform(at(rounded_box((0.66, 0.03, 0.035), 0.006), 0.0, -0.012, 0.475), rotate=lean)
    tray = transform(at(rounded_box((0.60, 0.06, 0.010), 0.003), 0.0, -0.038, -0.495), rotate=lean)
    feet = [tube([[side * 0.40, -0.14, 0.012], [side * 0.06, 0.068, 1.72]], 0.0125, 10) for side in (-1, 1)] + [
        tube([[0.0, 0.50, 0.012], [0.0, 0.088, 1.70]], 0.0125, 10)
    ]
    hub = at(rounded_box((0.16, 0.05, 0.06), 0.012, 2), 0.0, 0.078, 1.70)
    lift = 1.33
    writing = printed(board_prints.whiteboard_writing(seed + 50, 384, 564), 0.8)
    return standing(
        [
            (at(merge([board, tray]), z=lift), WHITE_PAINT),
            (at(sheet, z=lift), writing),
            (at(clamp, z=lift), BLACK_PLASTIC),
            (merge([*feet, hub]), steel()),
        ]
    )
