"""Upholstered seats: sofa and armchair. Fronts towards -y, standing on z = 0; metres.

A sofa stands on a wall: its back is at y = 0. An armchair is centred at the origin.
"""

from __future__ import annotations

import numpy as np

from indoor_rooms.furniture.building import at, check_range, four, legs, padded, pillow
from indoor_rooms.geometry.mesh import Mesh, merge, transform
from indoor_rooms.geometry.pieces import Pieces, placed
from indoor_rooms.materials.material import Material

SEAT_HEIGHT = 0.44
ARM_WIDTH = 0.19
ARM_HEIGHT = 0.60
SOFA_DEPTH = 0.92
# From a sofa's or armchair's back to the front of its back cushions, and from there to where the seat rounds off.
SOFA_BACK_DEPTH = 0.40
_FRONT_ROUNDING = 0.07
SOFA_SEAT_DEPTH = SOFA_DEPTH - SOFA_BACK_DEPTH - _FRONT_ROUNDING
ARMCHAIR_ARM_WIDTH = 0.14
_LEG = 0.11
_GAP = 0.006
_CUSHION = 0.155


def seat_centres(width: float) -> list[float]:
    """The x of the middles of a sofa's seat cushions: two up to 1.95 m, three above."""
    count = 2 if width < 1.95 else 3
    inside = width - 2 * ARM_WIDTH
    return [float(x) for x in (np.arange(count) + 0.5) * inside / count - inside / 2]


def _upholstery(width: float, depth: float, seats: int, arm: float, back_height: float) -> list[Mesh]:
    """Base, arms, back, seat and back cushions of a seat with its back at y = 0, without legs."""
    inside = width - 2 * arm
    parts = []
    # Arms, back and base are blocks of their own, a seam apart.
    arm_height = ARM_HEIGHT - _LEG
    for side in (-1, 1):
        block = padded((arm, depth, arm_height), 0.055, 1.0, 3)
        parts.append(at(block, side * (width - arm) / 2, -depth / 2, _LEG + arm_height / 2))
    back = padded((inside - _GAP, 0.19, back_height - _LEG), 0.06, 1.0, 3)
    parts.append(at(back, 0.0, -0.097, (back_height + _LEG) / 2))
    base_top = SEAT_HEIGHT - _CUSHION - 0.001
    base = padded((inside - _GAP, depth - 0.225, base_top - _LEG - 0.01), 0.02)
    parts.append(at(base, 0.0, -(depth - 0.225) / 2 - 0.195, (base_top + _LEG + 0.01) / 2))
    share = inside / seats
    for index in range(seats):
        x = (index + 0.5) * share - inside / 2
        seat_depth = depth - 0.205
        seat = padded((share - _GAP, seat_depth, _CUSHION), 0.06, 0.75, 3)
        parts.append(at(seat, x, -seat_depth / 2 - 0.20, SEAT_HEIGHT - _CUSHION / 2))
        cushion = transform(pillow((share - 0.012, 0.20, back_height - SEAT_HEIGHT + 0.05)), rotate=(-9.0, 0.0, 0.0))
        lowest = float(cushion.vertices[:, 2].min())
        hindmost = float(cushion.vertices[:, 1].max())
        # It sinks a little into the seat and leans on the back.
        parts.append(at(cushion, x, -0.185 - hindmost + 0.03, SEAT_HEIGHT - lowest - 0.004))
    return parts


def sofa(width: float, fabric: Material, feet: Material, depth: float = SOFA_DEPTH) -> Pieces:
    """A sofa with loose cushions.

    Args:
        width: over both arms, metres, 1.3 to 2.8.
        fabric: of the upholstery.
        feet: of the legs.
        depth: from the back to the front of the arms, metres.

    Raises:
        ValueError: if width or depth are out of range.
    """
    check_range("a sofa's width in metres", width, 1.3, 2.8)
    check_range("a sofa's depth in metres", depth, 0.75, 1.2)
    seats = len(seat_centres(width))
    corners = [(x, y - depth / 2) for x, y in four(width / 2 - 0.09, depth / 2 - 0.09)]
    return [
        (merge(_upholstery(width, depth, seats, ARM_WIDTH, 0.78)), fabric),
        (legs(corners, 0.0, _LEG + 0.004, 0.016, 0.024), feet),
    ]


def armchair(fabric: Material, feet: Material, width: float = 0.86, depth: float = 0.85) -> Pieces:
    """An armchair on slender legs, centred at the origin, facing -y.

    Args:
        fabric: of the upholstery.
        feet: of the legs.
        width: over both arms, metres.
        depth: metres.

    Raises:
        ValueError: if width or depth are out of range.
    """
    check_range("an armchair's width in metres", width, 0.7, 1.2)
    check_range("an armchair's depth in metres", depth, 0.72, 1.1)
    parts = merge(_upholstery(width, depth, 1, ARMCHAIR_ARM_WIDTH, 0.84))
    pieces = placed([(parts, fabric)], (0.0, depth / 2, 0.0))
    return [*pieces, (legs(four(width / 2 - 0.09, depth / 2 - 0.09), 0.0, _LEG + 0.004, 0.012, 0.021), feet)]
