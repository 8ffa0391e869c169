"""What several pieces of furniture are built with: moving a mesh, checking sizes, legs, padded shapes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, tube
from indoor_rooms.geometry.mesh import Mesh, grid_faces, merge, smooth_normals, transform, with_uvs

CLOTH_REPEATS = 4.0


def at(mesh: Mesh, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Mesh:
    """A mesh moved by metres along the axes."""
    return transform(mesh, (x, y, z))


def check_range(what: str, value: float, lowest: float, highest: float) -> None:
    """Refuse a size no one would build.

    Raises:
        ValueError: if `value` is not within `lowest` .. `highest` (metres, or a count).
    """
    if not lowest <= value <= highest:
        raise ValueError(f"{what} must be between {lowest:g} and {highest:g}, got {value:g}")


def upright_grain(mesh: Mesh) -> Mesh:
    """The same mesh with its texture turned by 90 degrees: wood's grain runs along u, on a side it runs upwards."""
    return with_uvs(mesh, mesh.uvs[:, ::-1])


def round_top(radius: float, thickness: float, bevel: float = 0.006, segments: int = 56) -> Mesh:
    """A round board, its upper side at z = 0, with wood's grain along x."""
    plate = at(cylinder(radius, thickness, segments, bevel), z=-thickness)
    flat = np.abs(plate.normals[:, 2:]) > 0.9
    return with_uvs(plate, np.where(flat, 1.1 * plate.vertices[:, :2], plate.uvs * [4.0, 0.05]))


def legs(corners: Iterable[tuple[float, float]], bottom: float, top: float, thin: float, thick: float) -> Mesh:
    """Round upright legs, thinner at their feet.

    Args:
        corners: (x, y) of each, metres.
        bottom: z of their feet.
        top: z of their upper ends.
        thin: radius at the feet.
        thick: radius at the upper ends.
    """
    return merge(tube([[x, y, bottom], [x, y, top]], [thin, thick], 12) for x, y in corners)


def four(x: float, y: float) -> list[tuple[float, float]]:
    """The corners (+-x, +-y)."""
    return [(side * x, end * y) for side in (-1, 1) for end in (-1, 1)]


def padded(size: tuple[float, float, float], edge: float, softness: float = 1.0, segments: int = 2) -> Mesh:
    """An upholstered block centred at the origin, its faces flat in the middle.

    Args:
        size: width, depth, height in metres.
        edge: radius of the roundings seen from above, metres.
        softness: height of the roundings over `edge`, above 0.
        segments: pieces of each rounding.
    """
    width, depth, height = size
    block = rounded_box((width, depth, height / softness), edge, segments, CLOTH_REPEATS)
    return transform(block, scale=(1.0, 1.0, softness))


def pillow(size: tuple[float, float, float], around: int = 32, across: int = 10) -> Mesh:
    """A stuffed cushion standing upright, bulging to the front (-y) and the back, centred at the origin.

    Args:
        size: width, thickness, height in metres.
        around: pieces of its outline.
        across: pieces from back to front.
    """
    turn = np.linspace(0.0, 2 * np.pi, around + 1)
    lift = np.linspace(-np.pi / 2, np.pi / 2, across + 1)
    width, thickness, height = size

    def power(wave: np.ndarray, exponent: float) -> np.ndarray:
        return np.sign(wave) * np.abs(wave) ** exponent

    radial = np.maximum(power(np.cos(lift), 0.5), 0.0)[None]
    x = width / 2 * power(np.cos(turn), 0.45)[:, None] * radial
    z = height / 2 * power(np.sin(turn), 0.45)[:, None] * radial
    y = np.broadcast_to(-thickness / 2 * power(np.sin(lift), 0.8)[None], x.shape)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    # The first and last column of the lattice are the same place: rounding makes them equal.
    vertices = np.round(vertices, 9)
    # Slanted along the thickness, so that the pattern goes on around the rim instead of being drawn out.
    uvs = CLOTH_REPEATS * (vertices[:, [0, 2]] + vertices[:, [1]] * [1.0, -1.0])
    return smooth_normals(vertices, uvs, grid_faces(around + 1, across + 1))
