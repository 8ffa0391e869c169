"""Screens and boards: television, wall screen, whiteboard, pinboard. Fronts towards -y; metres."""

from __future__ import annotations

import numpy as np

from indoor_rooms.furniture.building import at, check_range
from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, sphere
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials import board_prints, textures
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import BLACK_GLASS, BLACK_PLASTIC, glazed, plastic, printed

TELEVISION_DEPTH = 0.24
WHITEBOARD_TRAY_DEPTH = 0.075
_BEZEL = 0.011
_ASPECT = 9 / 16
_ALUMINIUM = Material((0.72, 0.73, 0.74), roughness=0.35, metalness=0.9)


def screen_height(width: float) -> float:
    """The height of a screen's case with its frame, for its outer width; metres."""
    return (width - 2 * _BEZEL) * _ASPECT + 2 * _BEZEL


def _flat_screen(width: float, thickness: float) -> tuple[Mesh, Mesh]:
    """Case and glass of a flat screen, centred in x and z, its back at y = 0."""
    height = screen_height(width)
    case = at(rounded_box((width, thickness, height), 0.005), 0.0, -thickness / 2)
    x, z = width / 2 - _BEZEL, height / 2 - _BEZEL
    glass = quad((-x, -thickness - 0.0006, -z), (2 * x, 0, 0), (0, 0, 2 * z))
    return case, glass


def television(width: float) -> Pieces:
    """A flat television on two feet, switched off; standing on z = 0 with its back at y = 0.

    Raises:
        ValueError: if its width (metres) is out of range.
    """
    check_range("a television's width in metres", width, 0.5, 2.0)
    case, glass = _flat_screen(width, 0.032)
    lift = 0.055 + screen_height(width) / 2
    bulge = at(rounded_box((width * 0.6, 0.03, screen_height(width) * 0.55), 0.01, 2), 0.0, 0.0145, -0.04)
    y = -TELEVISION_DEPTH / 2 + 0.016
    feet = []
    for side in (-1, 1):
        foot = rounded_box((0.022, TELEVISION_DEPTH, 0.012), 0.004, 1, 1.0, base=True)
        feet.append(at(foot, side * width * 0.36, -TELEVISION_DEPTH / 2))
        feet.append(
            at(rounded_box((0.02, 0.026, 0.05), 0.004, 1, 1.0, base=True), side * width * 0.36, y - 0.016, 0.0115)
        )
    shell = merge([at(merge([case, bulge]), 0.0, y, lift), *feet])
    return [(shell, BLACK_PLASTIC), (at(glass, 0.0, y, lift), BLACK_GLASS)]


def wall_screen(width: float, slide: int | None = 0) -> Pieces:
    """A flat screen hung on a wall, its middle at the origin.

    Args:
        width: outer width, metres.
        slide: number of the slide it shows, glowing a little; None switches it off.

    Raises:
        ValueError: if its width is out of range.
    """
    check_range("a wall screen's width in metres", width, 0.5, 2.6)
    case, glass = _flat_screen(width, 0.045)
    shown = BLACK_GLASS
    if slide is not None:
        shown = Material((1.0, 1.0, 1.0), board_prints.slide(slide), roughness=0.3, emission=0.9)
    return [(at(case, 0.0, -0.004), BLACK_PLASTIC), (at(glass, 0.0, -0.004), shown)]


def whiteboard(width: float, height: float, seed: int = 0) -> Pieces:
    """A whiteboard with writing on it, its middle at the origin; pens and a wiper lie in its tray.

    Args:
        width: metres.
        height: of the framed board without the tray that sticks out below, metres.
        seed: of the writing.

    Raises:
        ValueError: if a size is out of range.
    """
    check_range("a whiteboard's width in metres", width, 0.5, 3.5)
    check_range("a whiteboard's height in metres", height, 0.4, 1.6)
    face = Material((1.0, 1.0, 1.0), board_prints.whiteboard_writing(seed), roughness=0.22)
    x, z = width / 2 - 0.018, height / 2 - 0.018
    surface = quad((-x - 0.002, -0.013, -z - 0.002), (2 * x + 0.004, 0, 0), (0, 0, 2 * z + 0.004))
    bars = _frame(width, height, 0.02, 0.02)
    tray_z = -height / 2 - 0.006
    reach = WHITEBOARD_TRAY_DEPTH
    tray = rounded_box((width * 0.5, reach, 0.006), 0.002)
    lip = rounded_box((width * 0.5, 0.004, 0.014), 0.001)
    frame = [*bars, at(tray, 0.0, -reach / 2 - 0.001, tray_z), at(lip, 0.0, -reach + 0.001, tray_z + 0.0105)]
    pieces: Pieces = [(surface, face), (merge(frame), _ALUMINIUM)]
    top = tray_z + 0.0032
    for index, colour in enumerate(("#1f3f8f", "#b3261e", "#1d7a43")):
        pen = transform(cylinder(0.008, 0.13, 14, 0.003), rotate=(0.0, 90.0, 0.0))
        pieces.append((at(pen, -width * 0.2 + 0.16 * index, -0.035, top + 0.008), plastic(colour)))
    wiper = rounded_box((0.13, 0.045, 0.03), 0.006, 1, 1.0, base=True)
    pieces.append((at(wiper, width * 0.16, -0.036, top), BLACK_PLASTIC))
    return pieces


def _frame(width: float, height: float, bar: float, thickness: float) -> list[Mesh]:
    """Four bars around a board, backs at y = -1 mm."""
    y = -thickness / 2 - 0.001
    bars = []
    for side in (-1, 1):
        bars.append(at(rounded_box((bar, thickness, height), 0.003, 1, 1.5), side * (width - bar) / 2, y))
        level = rounded_box((width - 2 * bar - 0.0004, thickness, bar), 0.003, 1, 1.5)
        bars.append(at(level, 0.0, y, side * (height - bar) / 2))
    return bars


def pinboard(width: float, height: float, rng: np.random.Generator) -> Pieces:
    """A cork board with pinned sheets of paper, its middle at the origin.

    Args:
        width: metres.
        height: metres.
        rng: which sheets hang where.

    Raises:
        ValueError: if a size is out of range.
    """
    check_range("a pinboard's width in metres", width, 0.4, 2.5)
    check_range("a pinboard's height in metres", height, 0.3, 1.6)
    x, z = width / 2 - 0.02, height / 2 - 0.02
    cork = quad((-x, -0.012, -z), (2 * x, 0, 0), (0, 0, 2 * z), 2.0)
    pieces: Pieces = [
        (cork, Material((1.0, 1.0, 1.0), textures.cork(), roughness=0.95, specular=0.1)),
        (merge(_frame(width, height, 0.024, 0.02)), _ALUMINIUM),
    ]
    # One sheet in most cells of a grid: they never overlap.
    columns, rows = max(1, int(2 * x / 0.26)), max(1, int(2 * z / 0.32))
    cell_x, cell_z = 2 * x / columns, 2 * z / rows
    sheets: dict[int, list[Mesh]] = {}
    pins: list[Mesh] = []
    for column in range(columns):
        for row in range(rows):
            if rng.random() < 0.25:
                continue
            scale = rng.uniform(0.62, 0.86) * min(cell_x / 0.21, cell_z / 0.297)
            half_x, half_z = 0.105 * scale, 0.1485 * scale
            free_x, free_z = cell_x / 2 - half_x - 0.012, cell_z / 2 - half_z - 0.012
            middle_x = -x + (column + 0.5) * cell_x + rng.uniform(-1, 1) * max(free_x, 0.0)
            middle_z = -z + (row + 0.5) * cell_z + rng.uniform(-1, 1) * max(free_z, 0.0)
            sheet = quad((-half_x, 0.0, -half_z), (2 * half_x, 0, 0), (0, 0, 2 * half_z))
            turned = transform(sheet, (middle_x, -0.0145, middle_z), (0.0, rng.uniform(-3, 3), 0.0))
            sheets.setdefault(int(rng.integers(8)), []).append(turned)
            pins.append(at(sphere(0.006, 10), middle_x, -0.018, middle_z + half_z - 0.02))
    for number in sorted(sheets):
        pieces.append((merge(sheets[number]), printed(board_prints.note(number), 0.9)))
    if pins:
        pieces.append((merge(pins), glazed(("#c8352c", "#2f62b5", "#e0b02f")[int(rng.integers(3))])))
    return pieces
