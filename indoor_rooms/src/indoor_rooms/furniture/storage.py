"""Bookcases and their books, chests, stands, cabinets.

Whatever stands or hangs on a wall has its back at y = 0, its front towards -y, and is centred in x; metres.
"""

from __future__ import annotations

import math

import numpy as np

from indoor_rooms.furniture.building import at, check_range, four, legs, upright_grain
from indoor_rooms.furniture.tables import bar_pull
from indoor_rooms.geometry.boxes import box, rounded_box, slab
from indoor_rooms.geometry.curves import lathe, smooth_profile
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform, with_uvs, without_sides
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials import board_prints
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import BLACK_PLASTIC, CHROME, PAPER, printed

BOARD_THICKNESS = 0.022
TV_STAND_HEIGHT = 0.46
CHEST_HEIGHT = 0.85
FILING_CABINET_HEIGHT = 1.0
# What is lost of a bookcase's depth to its back panel and to the boards' setback from its front.
BOOKCASE_BACK = 0.008
_PLINTH = 0.06
_LEAST_ROOM = 0.16
_GAP = 0.004


def board_heights(height: float, boards: int) -> list[float]:
    """The z of the upper sides of a bookcase's boards, from the bottom board to its top, evenly spaced.

    Args:
        height: of the bookcase, metres.
        boards: bottom and top included, at least 2.

    Raises:
        ValueError: if there are fewer than 2 boards, or so many that less than 16 cm is left between two.
    """
    check_range("a bookcase's height in metres", height, 0.3, 2.6)
    if boards < 2:
        raise ValueError(f"a bookcase has at least 2 boards, its bottom and its top, got {boards}")
    lowest = _PLINTH + BOARD_THICKNESS
    room = (height - lowest) / (boards - 1) - BOARD_THICKNESS
    if room < _LEAST_ROOM:
        raise ValueError(
            f"{boards} boards leave only {room:.2f} m between two in a bookcase {height:g} m high;"
            f" take at most {1 + int((height - lowest) / (_LEAST_ROOM + BOARD_THICKNESS))}"
        )
    return [float(z) for z in np.linspace(lowest, height, boards)]


def inner_width(width: float) -> float:
    """The clear width between a bookcase's sides, metres."""
    return width - 2 * BOARD_THICKNESS - 0.002


def bookcase(width: float, height: float, material: Material, boards: int, depth: float = 0.30) -> Pieces:
    """An open bookcase with a back panel; `board_heights` says where its boards are.

    Args:
        width: metres.
        height: metres.
        material: of all of it.
        boards: bottom and top included.
        depth: metres.

    Raises:
        ValueError: if a size is out of range or there are too many boards.
    """
    check_range("a bookcase's width in metres", width, 0.3, 2.4)
    check_range("a bookcase's depth in metres", depth, 0.15, 0.6)
    tops = board_heights(height, boards)
    side_top = height - BOARD_THICKNESS - 0.0004
    sides = [
        box((x, -depth, 0.0), (x + BOARD_THICKNESS, -0.001, side_top), 1.2)
        for x in (-width / 2, width / 2 - BOARD_THICKNESS)
    ]
    x = inner_width(width) / 2
    levels = [box((-x, -depth + 0.004, z - BOARD_THICKNESS), (x, -BOOKCASE_BACK, z), 1.2) for z in tops[:-1]]
    top = box((-width / 2, -depth, height - BOARD_THICKNESS), (width / 2, -0.001, height), 1.2)
    plinth = box((-x, -depth + 0.03, 0.0), (x, -depth + 0.045, _PLINTH - 0.0005), 1.2)
    panel = box((-x, -BOOKCASE_BACK + 0.0005, _PLINTH), (x, -0.0015, side_top), 1.2)
    return [
        (merge([*map(upright_grain, sides), *levels, top, plinth]), material),
        (without_sides(upright_grain(panel), "+y"), material),
    ]


def _book(width: float, height: float, depth: float, cell: int) -> tuple[Mesh, Mesh]:
    """A closed book standing on z = 0 with its spine at y = 0 facing -y, its left side at x = 0: cover and pages."""
    board = min(0.0025, width / 5)
    cover = slab(
        (0, board, width - board, width), (0, 0.003, depth), [[True, True], [True, False], [True, True]], 0.0, height
    )
    # The spine shows the texture's cell; boards and edges show the plain strip on the cell's rim.
    low, span = cell / board_prints.SPINES, 1 / board_prints.SPINES
    front = cover.normals[:, 1] < -0.5
    across = np.where(front, 0.5 + 0.9 * (cover.vertices[:, 0] / width - 0.5), 0.04)
    uvs = np.column_stack([low + span * across, 0.02 + 0.96 * cover.vertices[:, 2] / height])
    pages = without_sides(box((board, 0.0035, 0.0), (width - board, depth - 0.003, height - 0.004)), "-z", "-x", "+x")
    return with_uvs(cover, uvs), pages


def row_of_books(width: float, height: float, depth: float, rng: np.random.Generator) -> Pieces:
    """Books side by side, spines towards -y, filling a width; now and then the last one leans on its neighbour.

    Args:
        width: of the row, met exactly, metres.
        height: of the tallest book at most, metres.
        depth: from the wall to the foremost spine, metres.
        rng: thickness, height, depth and colours of the books.

    Raises:
        ValueError: if a size is out of range.
    """
    check_range("a row of books' width in metres", width, 0.06, 2.4)
    check_range("a row of books' height in metres", height, 0.12, 0.6)
    check_range("a row of books' depth in metres", depth, 0.1, 0.5)
    lean = math.radians(rng.uniform(9.0, 16.0)) if width > 0.25 and rng.random() < 0.5 else 0.0
    leaning_height = height * 0.72
    leaning_width = 0.022
    taken = leaning_height * math.sin(lean) + leaning_width * math.cos(lean) if lean else 0.0
    # About thirty books at most: thin ones in a short row, thick ones in a long one.
    count = max(2, min(30, round((width - taken) / rng.uniform(0.026, 0.034))))
    thickness = rng.uniform(0.6, 1.6, count)
    thickness *= (width - taken) / thickness.sum()
    heights = height * rng.choice([0.78, 0.84, 0.9, 0.95, 1.0], count) * rng.uniform(0.97, 1.0, count)
    cells = rng.permutation(np.resize(np.arange(board_prints.SPINES), count))
    covers, pages = [], []
    x = -width / 2
    for wide, high, cell in zip(thickness, heights, cells, strict=True):
        setback = float(rng.choice([0.0, 0.002, 0.006, 0.012]))
        long = (depth - setback) * rng.uniform(0.82, 1.0)
        cover, paper = _book(float(wide) - 0.0006, float(high), long, int(cell))
        covers.append(at(cover, x + 0.0003, setback - depth))
        pages.append(at(paper, x + 0.0003, setback - depth))
        x += float(wide)
    if lean:
        # It turns about its lower left edge until its upper left edge touches the last upright book.
        cover, paper = _book(leaning_width, leaning_height, depth * 0.85, int(rng.integers(board_prints.SPINES)))
        place = (x + leaning_height * math.sin(lean) + 0.0004, -depth, 0.0)
        turn = (0.0, -math.degrees(lean), 0.0)
        covers.append(transform(cover, place, turn))
        pages.append(transform(paper, place, turn))
    spines = printed(board_prints.book_spines(int(rng.integers(4))), 0.55)
    return [(merge(covers), spines), (merge(pages), PAPER)]


def _knob(x: float, y: float, z: float) -> Mesh:
    """A round knob on a front at `y`."""
    profile = [(0.008, 0.0), (0.006, 0.008), (0.013, 0.016), (0.012, 0.024), (0.0, 0.026)]
    return transform(lathe(smooth_profile(profile, 1), 14), (x, y, z), (90.0, 0.0, 0.0))


def tv_stand(width: float, material: Material, depth: float = 0.42, height: float = TV_STAND_HEIGHT) -> Pieces:
    """A low board for a television: doors left and right, an open compartment with a shelf between them.

    Raises:
        ValueError: if a size (metres) is out of range.
    """
    check_range("a tv stand's width in metres", width, 0.9, 2.6)
    check_range("a tv stand's depth in metres", depth, 0.3, 0.6)
    check_range("a tv stand's height in metres", height, 0.35, 0.7)
    t, foot = 0.02, 0.10
    x, front = width / 2, -depth
    third = width / 3
    top = at(rounded_box((width, depth, 0.024), 0.003, 1, 1.2), 0.0, -depth / 2, height - 0.012)
    under = height - 0.0245
    bottom = box((-x + 0.004, front + 0.004, foot), (x - 0.004, -0.001, foot + t), 1.2)
    walls = [
        box((left, front + 0.004, foot + t + 0.0005), (left + t, -0.001, under), 1.2)
        for left in (-x + 0.004, -third / 2 - t, third / 2, x - 0.004 - t)
    ]
    back = box((-third / 2 + 0.0005, -0.012, foot + t + 0.001), (third / 2 - 0.0005, -0.002, under), 1.2)
    middle = (foot + t + under) / 2
    board = box(
        (-third / 2 + 0.0005, front + 0.02, middle - 0.008), (third / 2 - 0.0005, -0.013, middle + 0.008), 1.2
    )
    fronts, knobs = [], []
    for side in (-1, 1):
        low, high = third / 2 + _GAP / 2, x - _GAP
        door = rounded_box((high - low, 0.018, under - foot - 0.004), 0.002, 1, 1.2)
        fronts.append(at(door, side * (low + high) / 2, front - 0.0055, (foot + under) / 2))
        knobs.append(_knob(side * (low + 0.04), front - 0.0146, under - 0.07))
    corners = [(px, py - depth / 2) for px, py in four(x - 0.09, depth / 2 - 0.06)]
    feet = legs(corners, 0.0, foot + 0.001, 0.011, 0.018)
    return [(merge([top, bottom, *walls, back, board, *fronts, feet]), material), (merge(knobs), CHROME)]


def chest_of_drawers(
    width: float, material: Material, top: Material, drawers: int, depth: float = 0.45, height: float = CHEST_HEIGHT
) -> Pieces:
    """A chest with full-width drawers, two knobs each, on short legs.

    Args:
        width: metres.
        material: of body and fronts.
        top: of its top.
        drawers: number of drawers, 1 to 6.
        depth: metres.
        height: metres.

    Raises:
        ValueError: if a size is out of range, or the drawers would be lower than 9 cm.
    """
    check_range("a chest's width in metres", width, 0.4, 1.8)
    check_range("a chest's depth in metres", depth, 0.3, 0.7)
    check_range("a chest's height in metres", height, 0.4, 1.5)
    check_range("a chest's number of drawers", drawers, 1, min(6, int((height - 0.13) / 0.09)))
    foot, under = 0.10, height - 0.0255
    board = at(rounded_box((width, depth, 0.025), 0.005, 1, 1.2), 0.0, -depth / 2, height - 0.0125)
    x, front = width / 2 - 0.008, -depth + 0.028
    body = box((-x, front, foot), (x, -0.001, under), 1.2)
    fronts, knobs = [], []
    share = (under - foot) / drawers
    for row in range(drawers):
        z = foot + (row + 0.5) * share
        fronts.append(at(rounded_box((2 * x - 0.012, 0.02, share - 0.008), 0.003, 1, 1.2), 0.0, front - 0.0105, z))
        for side in (-1, 1):
            knobs.append(_knob(side * width * 0.26, front - 0.0206, z))
    corners = [(px, py - depth / 2) for px, py in four(x - 0.04, depth / 2 - 0.05)]
    feet = legs(corners, 0.0, foot + 0.001, 0.013, 0.02)
    return [(merge([body, *fronts]), material), (merge([board, feet]), top), (merge(knobs), CHROME)]


def filing_cabinet(
    material: Material,
    drawers: int = 3,
    width: float = 0.42,
    depth: float = 0.5,
    height: float = FILING_CABINET_HEIGHT,
) -> Pieces:
    """A steel filing cabinet with a handle and a label holder on each drawer.

    Raises:
        ValueError: if a size (metres) is out of range, or the drawers would be lower than 15 cm.
    """
    check_range("a filing cabinet's width in metres", width, 0.3, 1.0)
    check_range("a filing cabinet's depth in metres", depth, 0.35, 0.8)
    check_range("a filing cabinet's height in metres", height, 0.4, 1.6)
    check_range("a filing cabinet's number of drawers", drawers, 1, int((height - 0.06) / 0.15))
    front = -depth + 0.02
    body = at(rounded_box((width, depth - 0.021, height - 0.03), 0.004), 0.0, front / 2 - 0.0005, height / 2 + 0.015)
    plinth = box((-width / 2 + 0.015, front + 0.03, 0.0), (width / 2 - 0.015, -0.02, 0.0295))
    fronts, handles, labels = [], [], []
    share = (height - 0.05) / drawers
    for row in range(drawers):
        z = 0.04 + (row + 0.5) * share
        fronts.append(at(rounded_box((width - 0.012, 0.019, share - 0.008), 0.004), 0.0, front - 0.0105, z))
        handles.append(bar_pull(0.13, 0.0, front - 0.019, z + share * 0.12))
        labels.append(quad((-0.035, front - 0.0207, z + share * 0.26), (0.07, 0, 0), (0, 0, 0.028)))
    return [
        (merge([body, *fronts]), material),
        (plinth, BLACK_PLASTIC),
        (merge(handles), CHROME),
        (merge(labels), PAPER),
    ]
