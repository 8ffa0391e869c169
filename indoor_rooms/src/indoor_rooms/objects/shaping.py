"""Shapes and choices that many kinds of object share: prisms, bulges, folded sheets, keypads, palettes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_rooms.geometry.boxes import box
from indoor_rooms.geometry.curves import cylinder, sphere
from indoor_rooms.geometry.mesh import (
    Mesh,
    Vector,
    grid_faces,
    merge,
    smooth_normals,
    transform,
    with_uvs,
    without_sides,
)

Outline = NDArray[np.float64]

# Colours that things are sold in, from loud to quiet.
PALETTE = (
    "#c22f2a",
    "#e0682a",
    "#eab02e",
    "#8fae3a",
    "#3f8a4c",
    "#2f8f86",
    "#3f9fd0",
    "#2f5fa8",
    "#3a3f78",
    "#7a4f96",
    "#c8588f",
    "#e79aa8",
    "#8a4a32",
    "#c9a77a",
    "#efe6d2",
    "#f2f2ef",
    "#8d9296",
    "#3a3d42",
)
GADGET_COLOURS = ("#26272a", "#26272a", "#3b3e44", "#8f9499", "#d9dadb", "#f2f2ef", "#2d4a78", "#9c2f33")
# Adjacent edges that turn by more than about 37 degrees stay a sharp corner.
_SMOOTH = 0.8


def pick(rng: np.random.Generator, choices: tuple[str, ...]) -> str:
    """One of some words or colours."""
    return choices[int(rng.integers(len(choices)))]


def two_colours(rng: np.random.Generator, palette: tuple[str, ...] = PALETTE) -> tuple[str, str]:
    """Two different colours of a palette."""
    first, second = rng.choice(len(palette), 2, replace=False)
    return palette[int(first)], palette[int(second)]


def rounded_rectangle(width: float, depth: float, radius: float, segments: int = 4) -> Outline:
    """(K, 2) outline about the origin, counter-clockwise; metres."""
    radius = min(radius, 0.49 * min(width, depth))  # no two corners in one place
    corners = []
    for index, (side_x, side_y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angles = np.radians(90 * index + np.linspace(0, 90, segments + 1))
        centre = [side_x * (width / 2 - radius), side_y * (depth / 2 - radius)]
        corners.append(np.stack([np.cos(angles), np.sin(angles)], axis=1) * radius + centre)
    return np.concatenate(corners)


def closed_curve(points: ArrayLike, rounds: int = 2) -> Outline:
    """A closed polygon with its corners cut by Chaikin's method; (K, 2) in, (K * 2 ** rounds, 2) out."""
    line = np.asarray(points, dtype=np.float64)
    for _ in range(rounds):
        following = np.roll(line, -1, axis=0)
        line = np.stack([0.75 * line + 0.25 * following, 0.25 * line + 0.75 * following], axis=1).reshape(-1, 2)
    return line


def mirrored(half: ArrayLike) -> Outline:
    """Completes the right half (x >= 0) of an outline, given from the bottom up, with its mirror image."""
    line = np.asarray(half, dtype=np.float64)
    back = line[::-1][line[::-1, 0] > 1e-9] * [-1.0, 1.0]
    return np.concatenate([line, back])


def cap(outline: ArrayLike, height: float = 0.0) -> Mesh:
    """The flat inside of an outline at z = `height`, facing up; its bounding box carries the texture once."""
    line = np.asarray(outline, dtype=np.float64)
    flat = np.concatenate([line.mean(axis=0, keepdims=True), line])
    low, high = line.min(axis=0), line.max(axis=0)
    around = np.arange(len(line))
    faces = np.stack([np.zeros_like(around), around + 1, (around + 1) % len(line) + 1], axis=1)
    vertices = np.concatenate([flat, np.full((len(flat), 1), height)], axis=1)
    return Mesh(vertices, np.tile([0.0, 0.0, 1.0], (len(flat), 1)), (flat - low) / (high - low), faces)


def prism(outline: ArrayLike, height: float, bevel: float = 0.001, repeats_per_metre: float = 1.0) -> Mesh:
    """An outline raised from z = 0 to `height`, with bevelled rims.

    Args:
        outline: (K, 2) counter-clockwise, every point seen from the mean of all; metres.
        height: metres.
        bevel: of the rims, metres.
        repeats_per_metre: scale of the texture.
    """
    line = np.asarray(outline, dtype=np.float64)
    step = np.roll(line, -1, axis=0) - line
    edge = np.stack([step[:, 1], -step[:, 0]], axis=1) / np.linalg.norm(step, axis=1, keepdims=True)
    before = np.roll(edge, 1, axis=0)
    turning = (edge * before).sum(axis=1, keepdims=True)
    mitre = (edge + before) / np.maximum(1 + turning, 0.4)
    shared = (edge + before) / np.maximum(np.linalg.norm(edge + before, axis=1, keepdims=True), 1e-9)
    starts = np.where(turning > _SMOOTH, shared, edge)
    ends = np.roll(np.where(turning > _SMOOTH, shared, before), -1, axis=0)
    inner = line - bevel * mitre
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(step, axis=1))])
    slope = np.sqrt(0.5)
    rings = (
        (inner, 0.0, slope, -slope),
        (line, bevel, 1.0, 0.0),
        (line, height - bevel, 1.0, 0.0),
        (inner, height, slope, slope),
    )
    vertices, normals, uvs = [], [], []
    for place, z, across, up in rings:
        for points, directions, travelled in (
            (place, starts, along[:-1]),
            (np.roll(place, -1, axis=0), ends, along[1:]),
        ):
            vertices.append(np.column_stack([points, np.full(len(line), z)]))
            normals.append(np.column_stack([across * directions, np.full(len(line), up)]))
            uvs.append(np.column_stack([travelled, np.full(len(line), z)]) * repeats_per_metre)
    count = len(line)
    index = np.arange(count)
    faces = []
    for ring in range(3):
        a, b, c, d = (index + (2 * ring + offset) * count for offset in (0, 1, 3, 2))
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    wall = Mesh(np.concatenate(vertices), np.concatenate(normals), np.concatenate(uvs), np.concatenate(faces))
    top = cap(inner, height)
    top = with_uvs(top, top.vertices[:, :2] * repeats_per_metre)
    floor = Mesh(top.vertices - [0.0, 0.0, height], -top.normals, top.uvs, top.faces[:, ::-1])
    return merge([wall, top, floor])


def bulge(
    outline: ArrayLike,
    above: float,
    below: float,
    flatness: float = 0.6,
    rings: int = 5,
    centre: tuple[float, float] | None = None,
) -> Mesh:
    """An outline swollen like a cushion, resting on z = 0.

    Args:
        outline: (K, 2) counter-clockwise, every point seen from the centre; metres.
        above: how far it rises over the outline, metres.
        below: how far it reaches down from the outline, metres.
        flatness: 1 an ellipsoid, towards 0 flat with round rims.
        rings: on either side of the outline.
        centre: (2,) metres; None for the mean of the outline's points.
    """
    line = np.asarray(outline, dtype=np.float64)
    line = np.concatenate([line, line[:1]])
    middle = line[:-1].mean(axis=0) if centre is None else np.asarray(centre)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 2 * rings + 1)
    reach = np.cos(angle) ** flatness
    reach[[0, -1]] = 0.0
    rise = np.where(angle > 0, above, below) * np.sin(angle) + below
    flat = middle + reach[:, None, None] * (line - middle)
    vertices = np.concatenate([flat, np.broadcast_to(rise[:, None, None], (*flat.shape[:2], 1))], axis=2)
    low, high = line.min(axis=0), line.max(axis=0)
    uvs = ((flat - low) / (high - low)).reshape(-1, 2)
    return smooth_normals(vertices.reshape(-1, 3), uvs, grid_faces(len(rise), len(line))[:, ::-1])


def blob(centre: Vector, radii: Vector, segments: int = 18) -> Mesh:
    """An ellipsoid about its centre; metres."""
    return transform(sphere(1.0, segments), (centre[0], centre[1], centre[2] - radii[2]), scale=radii)


def facing(mesh: Mesh, y: float = 0.0, z: float = 0.0) -> Mesh:
    """Sets a lying shape upright: its top now looks towards -y, its y has become height above `z`."""
    return transform(mesh, (0.0, y, z), (90.0, 0.0, 0.0))


def double_sided(sheet: Mesh, thickness: float = 0.0008) -> Mesh:
    """A sheet and its back: one face alone would be lit wrongly, or not be seen, from behind."""
    back = Mesh(sheet.vertices - thickness * sheet.normals, -sheet.normals, sheet.uvs, sheet.faces[:, ::-1])
    return merge([sheet, back])


def over(mesh: Mesh, width: float, depth: float) -> Mesh:
    """The same mesh with a texture laid over it once from above, `width` x `depth` metres about the origin."""
    return with_uvs(mesh, mesh.vertices[:, :2] / [width, depth] + 0.5)


def keypad(columns: int, rows: int, pitch: tuple[float, float], fill: float, height: float, round_: bool) -> Mesh:
    """Keys in a lattice about the origin on z = 0; one texture lies over all of them, one cell for each key.

    Args:
        columns: of keys.
        rows: of keys.
        pitch: from one key to the next along x and y, metres.
        fill: share of the pitch that a key takes.
        height: of the keys, metres.
        round_: round keys instead of square ones.
    """
    half_x, half_y = fill * pitch[0] / 2, fill * pitch[1] / 2
    if round_:
        key = without_sides(cylinder(min(half_x, half_y), height, 12, 0.0), "-z")
    else:
        key = without_sides(box((-half_x, -half_y, 0.0), (half_x, half_y, height)), "-z")
    places = [
        ((column - (columns - 1) / 2) * pitch[0], (row - (rows - 1) / 2) * pitch[1], 0.0)
        for column in range(columns)
        for row in range(rows)
    ]
    return over(merge([transform(key, place) for place in places]), columns * pitch[0], rows * pitch[1])
