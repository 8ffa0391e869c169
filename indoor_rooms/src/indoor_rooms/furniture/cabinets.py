"""Fitted kitchen: cabinets, countertops, sink and tap, sideboard, shelf.

Whatever stands or hangs on a wall has its back at y = 0, its front towards -y, and is centred in x; metres.
"""

from __future__ import annotations

from collections.abc import Sequence

from indoor_rooms.geometry.boxes import box, rounded_box, slab
from indoor_rooms.geometry.curves import arc, cylinder, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform, without_sides
from indoor_rooms.geometry.pieces import Pieces, placed
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import BLACK_PLASTIC, CHROME, steel

COUNTER_HEIGHT = 0.90
COUNTER_DEPTH = 0.60
TOP_THICKNESS = 0.038
_PLINTH = 0.09
_DOOR = 0.018


def _strip(width: float, height: float, grain: float) -> Mesh:
    """A flat strip 8 mm thick, centred at the origin, without its back."""
    return without_sides(box((-width / 2, -0.004, -height / 2), (width / 2, 0.004, height / 2), grain), "+y")


def _shaker_front(width: float, height: float, grain: float = 1.4) -> Mesh:
    """A framed door or drawer front, its back at y = 0, centred in x, standing on z = 0."""
    panel = without_sides(box((-width / 2, -_DOOR, 0.0), (width / 2, 0.0, height), grain), "+y")
    frame = min(0.06, height * 0.22)
    if height < 0.2:
        return panel
    strips = []
    for side in (-1, 1):
        upright = _strip(frame, height - 0.002, grain)
        strips.append(transform(upright, (side * (width - 0.002 - frame) / 2, -_DOOR - 0.0035, height / 2)))
        rail = _strip(width - 0.002 - 2 * frame, frame, grain)
        strips.append(transform(rail, (0.0, -_DOOR - 0.0035, height / 2 + side * (height - 0.002 - frame) / 2)))
    return merge([panel, *strips])


def _bar_handle(length: float, upright: bool) -> Mesh:
    """A bent bar handle in front of y = 0, centred at the origin."""
    half = length / 2
    path = smooth_profile([[-half, 0.002, 0], [-half, -0.03, 0], [half, -0.03, 0], [half, 0.002, 0]], 1)
    return transform(tube(path, 0.0055, 8), rotate=(0.0, 90.0, 0.0) if upright else (0.0, 0.0, 0.0))


def base_cabinet(
    width: float,
    material: Material,
    drawers: int = 0,
    handle_side: int = 1,
    body_height: float | None = None,
    hidden_sides: Sequence[str] = (),
) -> Pieces:
    """A floor cabinet up to the underside of the countertop.

    Args:
        width: metres.
        material: of body and fronts.
        drawers: 0 one door, 1 a drawer over a door, 3 three drawers.
        handle_side: +1 or -1, where a door's handle is.
        body_height: top of the body, lower than the front where a sink hangs into it.
        hidden_sides: "-x" or "+x" where a neighbour stands; these sides are left out.
    """
    top = COUNTER_HEIGHT - TOP_THICKNESS - 0.002
    depth = COUNTER_DEPTH - 0.03
    body = box((-width / 2, -depth, _PLINTH), (width / 2, 0.0, body_height or top), 1.4)
    plinth = box((-width / 2, -depth + 0.06, 0.0), (width / 2, -0.01, _PLINTH - 0.001))
    # Hidden by the wall, the floor, the worktop and the neighbours.
    unseen = ("+y", "-z", "+z", *hidden_sides)
    body, plinth = without_sides(body, *unseen), without_sides(plinth, *unseen)
    heights = {0: [1.0], 1: [0.78, 0.22], 3: [0.40, 0.36, 0.24]}[drawers]
    pieces: Pieces = [(body, material), (plinth, BLACK_PLASTIC)]
    fronts, handles = [], []
    bottom, room = _PLINTH + 0.003, top - _PLINTH - 0.006
    for index, share in enumerate(heights):
        height = share * room - 0.004
        fronts.append(transform(_shaker_front(width - 0.005, height), (0.0, -depth - 0.001, bottom)))
        front_y = -depth - _DOOR - 0.009
        if drawers == 3 or (drawers == 1 and index == 1):
            handles.append(transform(_bar_handle(0.13, False), (0.0, front_y, bottom + height * 0.62)))
        else:
            place = (handle_side * (width / 2 - 0.035), front_y, bottom + height - 0.13)
            handles.append(transform(_bar_handle(0.13, True), place))
        bottom += share * room
    return [*pieces, (merge(fronts), material), (merge(handles), CHROME)]


def wall_cabinet(
    width: float, material: Material, height: float = 0.7, depth: float = 0.32, doors: int = 1
) -> Pieces:
    """A hanging cabinet, its underside at z = 0."""
    body = without_sides(box((-width / 2, -depth, 0.0), (width / 2, 0.0, height), 1.4), "+y")
    fronts, handles = [], []
    for index in range(doors):
        centre = (index + 0.5) * width / doors - width / 2
        door = width / doors
        fronts.append(transform(_shaker_front(door - 0.005, height - 0.004), (centre, -depth - 0.001, 0.002)))
        side = (1 if index == 0 else -1) if doors == 2 else 1
        handles.append(
            transform(_bar_handle(0.12, True), (centre + side * (door / 2 - 0.035), -depth - _DOOR - 0.009, 0.12))
        )
    return [(body, material), (merge(fronts), material), (merge(handles), CHROME)]


def countertop(
    xs: Sequence[float], ys: Sequence[float], filled: Sequence[Sequence[bool]], material: Material
) -> Pieces:
    """A worktop, its upper side at counter height, made of the filled cells of a grid (see `boxes.slab`)."""
    top = slab(xs, ys, filled, COUNTER_HEIGHT - TOP_THICKNESS, COUNTER_HEIGHT, 1.1)
    return [(without_sides(top, "-z"), material)]


def sink(width: float, depth: float) -> Pieces:
    """A steel basin hanging in a hole of the countertop (width x depth, centred at the origin), with its rim."""
    x, y, rim = width / 2, depth / 2, COUNTER_HEIGHT + 0.0015
    floor = 0.73
    inner_x, inner_y = x - 0.012, y - 0.012
    floor_plate = quad((-inner_x, -inner_y, floor), (2 * inner_x, 0, 0), (0, 2 * inner_y, 0), 1.0)
    # The walls face into the basin.
    walls = [
        quad((-inner_x, inner_y, floor), (2 * inner_x, 0, 0), (0, 0, rim - floor), 1.0),
        quad((inner_x, -inner_y, floor), (-2 * inner_x, 0, 0), (0, 0, rim - floor), 1.0),
        quad((-inner_x, -inner_y, floor), (0, 2 * inner_y, 0), (0, 0, rim - floor), 1.0),
        quad((inner_x, inner_y, floor), (0, -2 * inner_y, 0), (0, 0, rim - floor), 1.0),
    ]
    lip_xs, lip_ys = (-x - 0.015, -inner_x, inner_x, x + 0.015), (-y - 0.015, -inner_y, inner_y, y + 0.015)
    ring = [[True, True, True], [True, False, True], [True, True, True]]
    lip = slab(lip_xs, lip_ys, ring, COUNTER_HEIGHT + 0.0004, rim + 0.0015)
    drain = transform(cylinder(0.03, 0.003, 24, 0.001), (0.0, 0.0, floor + 0.0005))
    return [(merge([floor_plate, *walls, lip]), steel()), (drain, CHROME)]


def faucet() -> Pieces:
    """A tap with a tall curved spout towards -y, standing on z = 0."""
    foot = cylinder(0.027, 0.035, 24)
    curve = arc((0.0, -0.085, 0.25), 0.085, 0, 165, 16, "yz")
    path = [[0.0, 0.0, 0.02], [0.0, 0.0, 0.12], *curve.tolist()]
    lever = tube([[0.02, 0.0, 0.05], [0.04, -0.005, 0.062], [0.085, -0.012, 0.085]], [0.009, 0.007, 0.006], 10)
    return [(merge([foot, tube(path, 0.0125, 14), lever]), CHROME)]


def sideboard(width: float, material: Material, top: Material, depth: float = 0.38, height: float = 0.82) -> Pieces:
    """A low cupboard on legs with two doors and a wooden top."""
    body_low, body_high = 0.14, height - 0.03
    body = box((-width / 2 + 0.01, -depth + 0.02, body_low), (width / 2 - 0.01, -0.01, body_high), 1.4)
    body = without_sides(body, "+y", "+z")
    board = transform(rounded_box((width, depth, 0.028), 0.006, 1, 1.5), (0.0, -depth / 2, height - 0.014))
    door = (width - 0.02) / 2
    fronts, handles = [], []
    for side in (-1, 1):
        front = _shaker_front(door - 0.006, body_high - body_low - 0.01)
        fronts.append(transform(front, (side * door / 2, -depth + 0.019, body_low + 0.005)))
        handles.append(transform(_bar_handle(0.11, True), (side * 0.045, -depth - 0.007, height * 0.6)))
    legs = [
        tube([[x * (width / 2 - 0.05), y, 0.002], [x * (width / 2 - 0.07), y, body_low + 0.001]], [0.014, 0.02], 12)
        for x in (-1, 1)
        for y in (-depth + 0.06, -0.06)
    ]
    return [(body, material), (merge(fronts), material), (merge([board, *legs]), top), (merge(handles), CHROME)]


def shelf(width: float, material: Material, depth: float = 0.22) -> Pieces:
    """A board on two brackets; its upper side is z = 0."""
    board = transform(rounded_box((width, depth, 0.026), 0.004, 1, 1.6), (0.0, -depth / 2, -0.013))
    brackets: Pieces = []
    for x in (-width / 2 + 0.1, width / 2 - 0.1):
        path = [[x, -0.006, -0.18], [x, -0.006, -0.032], [x, -depth + 0.03, -0.032]]
        brace = [[x, -0.006, -0.16], [x, -depth * 0.7, -0.034]]
        brackets.append((merge([tube(path, 0.0055, 8), tube(brace, 0.0045, 8)]), BLACK_PLASTIC))
    return [(board, material), *brackets]


def run_of_cabinets(widths: Sequence[float], material: Material, drawers: Sequence[int]) -> Pieces:
    """Base cabinets side by side, starting at x = 0 towards +x."""
    pieces: Pieces = []
    x = 0.0
    for index, (width, count) in enumerate(zip(widths, drawers, strict=True)):
        hidden = (["-x"] if index > 0 else []) + (["+x"] if index < len(widths) - 1 else [])
        cabinet = base_cabinet(width, material, count, 1 if index % 2 == 0 else -1, hidden_sides=hidden)
        pieces += placed(cabinet, (x + width / 2, 0.0, 0.0))
        x += width
    return pieces
