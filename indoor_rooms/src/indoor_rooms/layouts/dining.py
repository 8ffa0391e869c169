"""A table with chairs around it, a rug beneath and a lamp above."""

from __future__ import annotations

import numpy as np

from indoor_rooms.furniture import seating, tables
from indoor_rooms.geometry.pieces import placed
from indoor_rooms.layouts.placement import Ledge, RoomBuilder
from indoor_rooms.layouts.walls import FloorLayout
from indoor_rooms.materials.themes import Theme

# What stands on a rug stands this high.
RUG_TOP = 0.0104
# A chair's middle is this far from the table's edge, and reaches this much farther out.
CHAIR_OUT, CHAIR_REACH = 0.09, 0.27


def dining_place(
    builder: RoomBuilder, plan: FloorLayout, theme: Theme, rng: np.random.Generator, gap: float = 0.55
) -> tuple[list[Ledge], tuple[float, float]] | None:
    """Put a table with chairs where there is room for both.

    Args:
        builder: takes the parts.
        plan: what stands where.
        theme: colours.
        rng: shape, size, place.
        gap: from all other furniture, metres.

    Returns:
        The table's two long edges as ledges and its middle, or None if there is no room.
    """
    is_round = rng.random() < 0.35
    width = 1.0 if is_round else float(rng.uniform(1.1, 1.45))
    depth = width if is_round else float(rng.uniform(0.75, 0.85))
    turned = rng.random() < 0.5
    around = CHAIR_OUT + CHAIR_REACH - 0.05
    for size in (1.0, 0.85):
        width, depth = width * size, max(depth * size, 0.72)
        across = (width, depth + 2 * around)
        place = plan.in_the_open(*(across[::-1] if turned else across), rng, gap=gap)
        if place is not None:
            break
    else:
        return None
    x, y = place
    half_x, half_y = (across[1] / 2, across[0] / 2) if turned else (across[0] / 2, across[1] / 2)
    floor = 0.0006
    rug_x, rug_y = half_x + 0.22, half_y + 0.22
    if rng.random() < 0.6 and plan.fits((x - rug_x, y - rug_y, x + rug_x, y + rug_y), 0.02):
        builder.add("rug", seating.rug(2 * rug_x, 2 * rug_y, *theme.rug), (x, y, floor))
        half_x, half_y, floor = rug_x, rug_y, RUG_TOP
    plan.take((x - half_x, y - half_y, x + half_x, y + half_y))

    turn = 90.0 if turned else 0.0
    make = tables.round_table(width / 2, theme.timber, theme.frames) if is_round else None
    table = make or seating.table(width, depth, theme.timber, theme.frames)
    builder.add("table", table, (x, y, floor), turn, obstacle=True)
    side = 0.0 if is_round or width < 1.2 else width * 0.23
    seats = [(-side, -1), (side, -1), (-side, 1), (side, 1)] if side else [(0.0, -1), (0.0, 1)]
    if len(seats) == 4 and rng.random() < 0.5:
        seats.pop(int(rng.integers(4)))
    # No edge of a round table is straight: its chairs stand a little closer.
    out = depth / 2 + CHAIR_OUT - (0.02 if is_round else 0.0)
    for number, (along, sign) in enumerate(seats, 1):
        seat = seating.chair(theme.frames, theme.fabric if rng.random() < 0.8 else None)
        local = placed(seat, turn=float(rng.uniform(-6, 6)) + (180.0 if sign > 0 else 0.0))
        local = placed(local, (along, sign * out, 0.0))
        builder.add(f"chair_{number}", local, (x, y, floor), turn, obstacle=True)
    return _edges(x, y, width, depth, turned, floor + seating.TABLE_HEIGHT, is_round), (x, y)


def _edges(
    x: float, y: float, width: float, depth: float, turned: bool, height: float, is_round: bool
) -> list[Ledge]:
    """The two long halves of a table top; on a round one there is room in the middle only."""
    reach = width / 2 - 0.04 if not is_round else width / 2 * 0.72
    strip = depth / 4 + (0.01 if not is_round else -0.03)
    usable = 0.32 if not is_round else 0.30
    corners = [((-reach, -strip), (reach, -strip)), ((reach, strip), (-reach, strip))]
    if turned:
        corners = [tuple((-b, a) for a, b in ends) for ends in corners]  # type: ignore[misc]
    return [
        Ledge("table", "table", (x + start[0], y + start[1]), (x + end[0], y + end[1]), height, usable)
        for start, end in corners
    ]
