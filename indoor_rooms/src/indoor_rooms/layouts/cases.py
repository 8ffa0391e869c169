"""Bookcases, chests, desks and other furniture along walls, with the ledges that things may stand on."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from indoor_rooms.furniture import cabinets, office, seating, soft, storage, tables
from indoor_rooms.layouts.common import wall_ledge
from indoor_rooms.layouts.placement import Ledge, RoomBuilder
from indoor_rooms.layouts.shell import Window
from indoor_rooms.layouts.walls import WALL_GAP, FloorLayout, Wall
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.themes import Theme
from indoor_rooms.objects.decor import floor_plant

BOOKCASE_DEPTH = 0.30
# Boards that somebody who stands in front can look at; metres.
SEEN_BOARDS = (0.30, 1.22)


def stand_bookcase(
    builder: RoomBuilder,
    plan: FloorLayout,
    walls: list[Wall],
    material: Material,
    name: str,
    rng: np.random.Generator,
) -> list[Ledge]:
    """A bookcase, its boards filled with books here and there; returns what is left of its boards."""
    width, height = float(rng.uniform(0.8, 1.25)), float(rng.uniform(1.5, 2.05))
    found = plan.somewhere(walls, width, BOOKCASE_DEPTH, rng, tall=True)
    if found is None:
        return []
    wall, along = found
    boards = 5 if height < 1.85 else 6
    case = storage.bookcase(width, height, material, boards, BOOKCASE_DEPTH)
    builder.add(name, case, wall.point(along, WALL_GAP), wall.turn, obstacle=True)
    ledges = []
    inside = storage.inner_width(width)
    for low, high in pairwise(storage.board_heights(height, boards)):
        room = high - low - storage.BOARD_THICKNESS
        # Books from the left, from the right, all over, or none; a board out of sight is full or empty.
        seen = SEEN_BOARDS[0] < low < SEEN_BOARDS[1]
        share = float(rng.choice((0.0, 0.4, 0.55, 1.0), p=(0.3, 0.3, 0.25, 0.15) if seen else (0.3, 0.0, 0.2, 0.5)))
        books = share * (inside - 0.02)
        side = float(rng.choice((-1.0, 1.0)))
        if share > 0:
            row = storage.row_of_books(books, room - 0.03, BOOKCASE_DEPTH - 0.06, rng)
            place = along + side * (inside - books - 0.01) / 2
            builder.add("books", row, wall.point(place, WALL_GAP + 0.02, low + 0.0008), wall.turn)
        if seen and share < 1:
            free = inside - books - 0.03
            place = along - side * (inside - free - 0.01) / 2
            ledges.append(wall_ledge(wall, (place, WALL_GAP + 0.155, low), (free, 0.25), name, "shelf", room - 0.02))
    return ledges


def stand_chest(
    builder: RoomBuilder, plan: FloorLayout, walls: list[Wall], theme: Theme, name: str, rng: np.random.Generator
) -> list[Ledge]:
    """A sideboard or a chest of drawers."""
    width = float(rng.uniform(0.95, 1.5))
    is_sideboard = rng.random() < 0.5
    depth, height = (0.38, 0.82) if is_sideboard else (0.45, storage.CHEST_HEIGHT)
    found = plan.somewhere(walls, width, depth + 0.04, rng)
    if found is None:
        return []
    wall, along = found
    piece = (
        cabinets.sideboard(width, theme.casing, theme.timber)
        if is_sideboard
        else storage.chest_of_drawers(width, theme.casing, theme.timber, int(rng.integers(3, 5)))
    )
    builder.add(name, piece, wall.point(along, WALL_GAP), wall.turn, obstacle=True)
    return [wall_ledge(wall, (along, WALL_GAP + depth / 2, height), (width - 0.06, depth - 0.04), name, "board")]


def stand_desk(
    builder: RoomBuilder, plan: FloorLayout, walls: list[Wall], theme: Theme, rng: np.random.Generator, swivel: bool
) -> list[Ledge]:
    """A desk against a wall with a chair in front of it."""
    width, depth = float(rng.uniform(1.1, 1.4)), float(rng.uniform(0.58, 0.66))
    found = plan.somewhere(walls, width, depth + 0.50, rng)
    if found is None:
        return []
    wall, along = found
    desk = tables.desk(width, depth, theme.timber, theme.frames)
    builder.add("desk", desk, wall.point(along, WALL_GAP), wall.turn, obstacle=True)
    chair = office.office_chair(theme.casing) if swivel else seating.chair(theme.frames, theme.fabric)
    # The drawers are on the right, seen by who sits there: the chair stands left of them.
    place = wall.point(along - tables.DESK_PEDESTAL / 2, WALL_GAP + depth + 0.16, 0.0006)
    builder.add("desk_chair", chair, place, wall.turn + float(rng.uniform(-12, 12)), obstacle=True)
    return [
        wall_ledge(
            wall, (along, WALL_GAP + depth / 2, tables.DESK_HEIGHT), (width - 0.06, depth - 0.06), "desk", "desk"
        )
    ]


def keep_floor(plan: FloorLayout, walls: list[Wall], count: int, rng: np.random.Generator) -> list[Ledge]:
    """Stretches of the floor along walls where a bag or a ball may lie."""
    ledges = []
    for number in range(count):
        found = plan.somewhere(walls, 0.52, 0.40, rng)
        if found is not None:
            wall, along = found
            ledges.append(wall_ledge(wall, (along, 0.23, 0.0), (0.50, 0.40), f"floor {number}", "floor", 0.7))
    return ledges


def stand_plants(
    builder: RoomBuilder, plan: FloorLayout, walls: list[Wall], count: int, rng: np.random.Generator
) -> None:
    """Tall plants along the walls."""
    for number in range(1, count + 1):
        found = plan.somewhere(walls, 0.62, 0.62, rng, tall=True)
        if found is not None:
            wall, along = found
            builder.add(
                f"plant_{number}", floor_plant(rng), wall.point(along, 0.36, 0.0006), wall.turn, obstacle=True
            )


def stand_radiator(builder: RoomBuilder, window: Window) -> None:
    """A radiator under a window."""
    width = window.width * 0.8
    place = window.wall.point(window.along, WALL_GAP)
    builder.add("radiator", soft.radiator(width), place, window.wall.turn, obstacle=True)
