"""Tables and desk. Centred at the origin on z = 0, except the desk: its back is at y = 0; metres."""

from __future__ import annotations

from typing import Literal

import numpy as np

from indoor_rooms.furniture.building import at, check_range, four, round_top, upright_grain
from indoor_rooms.furniture.seating import TABLE_HEIGHT
from indoor_rooms.geometry.boxes import box, rounded_box
from indoor_rooms.geometry.curves import cylinder, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, grid_faces, merge, smooth_normals, transform, without_slivers
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import BLACK_PLASTIC, CHROME

COFFEE_TABLE_HEIGHT = 0.42
# The upper side of the lower board of a coffee table of shape "shelf".
COFFEE_TABLE_SHELF = 0.16
SIDE_TABLE_HEIGHT = 0.52
DESK_HEIGHT = 0.74
DESK_PEDESTAL = 0.40
CONFERENCE_TABLE_HEIGHT = 0.74
# Width, depth and height above the top of the cable cover in a conference table's middle: nothing should stand there.
CABLE_COVER = (0.46, 0.15, 0.004)

CoffeeTableShape = Literal["rectangle", "round", "shelf"]


def coffee_table(
    width: float, depth: float, top: Material, frame: Material, shape: CoffeeTableShape = "rectangle"
) -> Pieces:
    """A low table, 0.42 m high.

    Args:
        width: metres.
        depth: metres; of a round one both are diameters.
        top: material of the boards.
        frame: material of the legs.
        shape: "rectangle" with four legs, "round" with three splayed ones, "shelf" with a lower board.

    Raises:
        ValueError: if sizes are out of range or the shape is not known.
    """
    check_range("a coffee table's width in metres", width, 0.4, 1.8)
    check_range("a coffee table's depth in metres", depth, 0.4, 1.2)
    under = COFFEE_TABLE_HEIGHT - 0.029
    if shape == "round":
        plate = transform(round_top(0.5, 0.028), scale=(width, depth, 1.0))
        feet = []
        for angle in np.radians([90.0, 210.0, 330.0]):
            x, y = width * np.cos(angle), depth * np.sin(angle)
            feet.append(tube([[0.40 * x, 0.40 * y, 0.004], [0.27 * x, 0.27 * y, under]], [0.013, 0.021], 14))
        hub = at(cylinder(0.29 * min(width, depth), 0.018, 40), z=under - 0.019)
        lowest = min(float(foot.vertices[:, 2].min()) for foot in feet)
        feet = [at(foot, z=-lowest) for foot in feet]
        return [(at(plate, z=COFFEE_TABLE_HEIGHT), top), (merge([*feet, hub]), frame)]
    if shape not in ("rectangle", "shelf"):
        raise ValueError(f"no coffee table of shape '{shape}'; choose rectangle, round or shelf")
    board = at(rounded_box((width, depth, 0.028), 0.006, 2, 1.1), z=COFFEE_TABLE_HEIGHT - 0.014)
    x, y = width / 2 - 0.035, depth / 2 - 0.035
    posts = [at(rounded_box((0.04, 0.04, under), 0.004, 1, 1.0, base=True), px, py) for px, py in four(x, y)]
    rails = []
    for side in (-1, 1):
        rails.append(at(rounded_box((2 * x - 0.042, 0.018, 0.05), 0.003), 0.0, side * y, under - 0.026))
        rails.append(at(rounded_box((0.018, 2 * y - 0.042, 0.05), 0.003), side * x, 0.0, under - 0.026))
    boards = [board]
    if shape == "shelf":
        # Between the legs, its ends a little inside them.
        lower = rounded_box((2 * x - 0.036, depth - 0.034, 0.022), 0.004, 1, 1.1)
        boards.append(at(lower, z=COFFEE_TABLE_SHELF - 0.011))
    return [(merge(boards), top), (merge([*posts, *rails]), frame)]


def side_table(size: float, top: Material, frame: Material) -> Pieces:
    """A small round table on three legs, 0.52 m high, `size` metres across.

    Raises:
        ValueError: if its size is out of range.
    """
    check_range("a side table's size in metres", size, 0.3, 0.7)
    plate = at(round_top(size / 2, 0.022, 0.005, 44), z=SIDE_TABLE_HEIGHT)
    under = SIDE_TABLE_HEIGHT - 0.0225
    feet = []
    for angle in np.radians([90.0, 210.0, 330.0]):
        x, y = size * np.cos(angle), size * np.sin(angle)
        feet.append(tube([[0.42 * x, 0.42 * y, 0.003], [0.24 * x, 0.24 * y, under]], [0.010, 0.016], 12))
    lowest = min(float(foot.vertices[:, 2].min()) for foot in feet)
    ring = at(cylinder(0.27 * size, 0.014, 36), z=under - 0.0145)
    return [(plate, top), (merge([*(at(foot, z=-lowest) for foot in feet), ring]), frame)]


def round_table(radius: float, top: Material, frame: Material) -> Pieces:
    """A round dining table on a turned pedestal, as high as `seating.TABLE_HEIGHT`.

    Raises:
        ValueError: if the radius (metres) is out of range.
    """
    check_range("a round table's radius in metres", radius, 0.35, 0.9)
    plate = at(round_top(radius, 0.030, 0.008, 64), z=TABLE_HEIGHT)
    foot = radius * 0.55
    profile = [
        (0.0, 0.0), (foot, 0.0), (foot, 0.018), (foot * 0.5, 0.05), (0.06, 0.10), (0.045, 0.30),
        (0.052, 0.55), (0.10, 0.69), (0.15, TABLE_HEIGHT - 0.031), (0.0, TABLE_HEIGHT - 0.031),
    ]  # fmt: skip
    return [(plate, top), (lathe(smooth_profile(profile), 44), frame)]


def desk(width: float, depth: float, top: Material, frame: Material) -> Pieces:
    """A writing desk against a wall (back at y = 0), three drawers on the right, 0.74 m high.

    Args:
        width: metres.
        depth: metres.
        top: material of its top and drawer fronts.
        frame: material of legs and pedestal.

    Raises:
        ValueError: if width or depth are out of range.
    """
    check_range("a desk's width in metres", width, 0.9, 2.2)
    check_range("a desk's depth in metres", depth, 0.5, 1.0)
    under = DESK_HEIGHT - 0.029
    board = at(rounded_box((width, depth, 0.028), 0.004, 1, 1.0), 0.0, -depth / 2, DESK_HEIGHT - 0.014)
    # A U of square tubes on the left, a pedestal on the right.
    x = -width / 2 + 0.05
    leg_ys = (-0.06, -depth + 0.06)
    bars = [box((x - 0.02, y - 0.02, 0.0), (x + 0.02, y + 0.02, under - 0.0405)) for y in leg_ys]
    bars.append(box((x - 0.02, leg_ys[1] - 0.02, under - 0.04), (x + 0.02, leg_ys[0] + 0.02, under)))
    left, right = width / 2 - 0.03 - DESK_PEDESTAL, width / 2 - 0.03
    body = box((left, -depth + 0.045, 0.03), (right, -0.02, under), 1.2)
    plinth = box((left + 0.02, -depth + 0.08, 0.0), (right - 0.02, -0.04, 0.0295))
    modesty = box((x + 0.021, -0.05, 0.34), (left - 0.001, -0.034, under - 0.001), 1.2)
    fronts, handles = [], []
    height = (under - 0.03) / 3
    for row in range(3):
        z = 0.03 + (row + 0.5) * height
        front = rounded_box((DESK_PEDESTAL - 0.004, 0.018, height - 0.005), 0.002, 1, 1.2)
        fronts.append(at(front, (left + right) / 2, -depth + 0.0355, z))
        handles.append(bar_pull(0.12, (left + right) / 2, -depth + 0.027, z + height * 0.28))
    return [
        (merge([board, *fronts]), top),
        (merge([*bars, body, modesty]), frame),
        (plinth, BLACK_PLASTIC),
        (merge(handles), CHROME),
    ]


def bar_pull(length: float, x: float, y: float, z: float) -> Mesh:
    """A level bent handle in front of a drawer front at `y`."""
    half = length / 2
    path = smooth_profile(
        [[x - half, y + 0.001, z], [x - half, y - 0.028, z], [x + half, y - 0.028, z], [x + half, y + 0.001, z]], 1
    )
    return tube(path, 0.005, 8)


def soft_plate(width: float, depth: float, thickness: float, squareness: float = 5.0, points: int = 33) -> Mesh:
    """A table top with a soft rectangular outline (a superellipse), its upper side at z = 0, grain along x.

    Args:
        width: metres.
        depth: metres.
        thickness: metres.
        squareness: exponent of the outline: 2 an ellipse, large a rectangle.
        points: along each long side.
    """
    angle = np.linspace(0.0, np.pi, points)
    bow = np.maximum(np.sin(angle), 0.0) ** (2 / squareness)
    along = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** (2 / squareness)
    far = np.stack([width / 2 * along, depth / 2 * bow], axis=1)
    far[[0, -1], 1] = 0.0
    # Counter-clockwise from above: along the far side towards -x, back along the near side.
    outline = np.concatenate([far, (far * [1.0, -1.0])[::-1][1:]])
    bevel = min(0.006, thickness / 3)
    inset = outline * (1 - 2 * bevel / np.array([width, depth]))
    rings = [(inset, -thickness), (outline, bevel - thickness), (outline, -bevel), (inset, 0.0)]
    stacked = np.stack([np.column_stack([ring, np.full(len(ring), z)]) for ring, z in rings], axis=1)
    walk = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(outline, axis=0), axis=1))])
    uvs = np.stack(np.broadcast_arrays(walk[:, None], stacked[..., 2]), axis=-1)
    rim = smooth_normals(stacked.reshape(-1, 3), uvs.reshape(-1, 2), grid_faces(len(outline), 4))
    faces = []
    for z, up in ((0.0, 1.0), (-thickness, -1.0)):
        near = (far * [1.0, -1.0]) * (1 - 2 * bevel / np.array([width, depth]))
        rows = np.stack([near, near * [1.0, -1.0]], axis=1).reshape(-1, 2)
        vertices = np.column_stack([rows, np.full(len(rows), z)])
        triangles = grid_faces(len(far), 2)
        flat = Mesh(vertices, np.tile([0.0, 0.0, up], (len(rows), 1)), rows, triangles[:, :: int(-up)])
        faces.append(without_slivers(flat))
    return merge([rim, *faces])


def conference_table(width: float, depth: float, top: Material, frame: Material) -> Pieces:
    """A long table with a soft outline on two panel legs, a cable cover in its middle, 0.74 m high.

    Args:
        width: along x, metres.
        depth: metres.
        top: material of its top.
        frame: material of its legs.

    Raises:
        ValueError: if width or depth are out of range, or it is deeper than wide.
    """
    check_range("a conference table's width in metres", width, 1.4, 5.0)
    check_range("a conference table's depth in metres", depth, 0.8, min(width, 1.8))
    plate = at(soft_plate(width, depth, 0.036), z=CONFERENCE_TABLE_HEIGHT)
    under = CONFERENCE_TABLE_HEIGHT - 0.0365
    x, reach = width / 2 - 0.24 * width, depth * 0.62
    parts = []
    for side in (-1, 1):
        parts.append(
            upright_grain(at(rounded_box((0.07, reach * 0.6, under - 0.08), 0.008), side * x, 0.0, under / 2))
        )
        parts.append(at(rounded_box((0.10, reach, 0.039), 0.008, 1, 1.0, base=True), side * x))
        parts.append(at(rounded_box((0.10, reach, 0.039), 0.008), side * x, 0.0, under - 0.0195))
    parts.append(at(rounded_box((2 * x - 0.072, 0.03, 0.16), 0.004), 0.0, 0.0, under - 0.14))
    cover_width, cover_depth, cover_height = CABLE_COVER
    cover = at(
        rounded_box((cover_width, cover_depth, 0.008), 0.002), z=CONFERENCE_TABLE_HEIGHT + cover_height - 0.004
    )
    slit = at(rounded_box((cover_width - 0.10, 0.012, 0.002), 0.0005), z=CONFERENCE_TABLE_HEIGHT + cover_height)
    return [(plate, top), (merge(parts), frame), (cover, CHROME), (slit, BLACK_PLASTIC)]
