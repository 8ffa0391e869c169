"""Box-like meshes: sharp and rounded boxes, and slabs with openings (walls with windows, countertops with sinks)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.geometry.mesh import Mesh, Vector, grid_faces, merge, quad, transform


def _side_uvs(points: NDArray[np.float64], axis: int, sign: int) -> NDArray[np.float64]:
    """Texture coordinates in metres, upright on the sides of a box and seen unmirrored from outside."""
    if axis == 2:
        return np.stack([points[:, 0], points[:, 1] * sign], axis=1)
    along = points[:, 1] * sign if axis == 0 else -points[:, 0] * sign
    return np.stack([along, points[:, 2]], axis=1)


def rounded_box(
    size: Vector,
    radius: float = 0.004,
    segments: int = 1,
    repeats_per_metre: float = 1.0,
    base: bool = False,
) -> Mesh:
    """A box with rounded edges.

    Args:
        size: outer width, depth, height in metres.
        radius: of the edges, metres; cut down to half the smallest side.
        segments: pieces each rounding is made of on one face; more than 2 is seldom seen.
        repeats_per_metre: scale of the texture.
        base: stand it on z = 0 instead of centring it at the origin.
    """
    half = np.asarray(size, dtype=np.float64) / 2
    radius = min(radius, float(half.min()) * 0.99)
    faces = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        rounding = np.linspace(0.0, radius, segments + 1)
        lines = [np.concatenate([-half[k] + rounding, half[k] - rounding[::-1]]) for k in (first, second)]
        a, b = np.meshgrid(*lines, indexing="ij")
        for sign in (1, -1):
            flat = np.zeros((a.size, 3))
            flat[:, first], flat[:, second], flat[:, axis] = a.ravel(), b.ravel(), sign * half[axis]
            core = np.clip(flat, radius - half, half - radius)
            normals = flat - core
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            # Opposite and neighbouring faces get another piece of the texture each.
            uvs = _side_uvs(flat, axis, sign) * repeats_per_metre + 0.37 * axis + 0.19 * sign
            triangles = grid_faces(*a.shape)
            faces.append(Mesh(core + radius * normals, normals, uvs, triangles if sign > 0 else triangles[:, ::-1]))
    box_mesh = merge(faces)
    return transform(box_mesh, (0.0, 0.0, float(half[2]))) if base else box_mesh


def box(low: Vector, high: Vector, repeats_per_metre: float = 1.0) -> Mesh:
    """A sharp box between two corners (metres), 12 triangles."""
    return slab((low[0], high[0]), (low[1], high[1]), [[True]], low[2], high[2], repeats_per_metre)


def slab(
    xs: Sequence[float],
    ys: Sequence[float],
    filled: Sequence[Sequence[bool]],
    bottom: float,
    top: float,
    repeats_per_metre: float = 1.0,
) -> Mesh:
    """A flat slab made of the filled cells of a grid, closed all round, with no faces between neighbours.

    Args:
        xs: (M + 1,) rising grid lines, metres.
        ys: (N + 1,) rising grid lines, metres.
        filled: (M, N), which cells exist; the rest is holes.
        bottom: z of the lower face.
        top: z of the upper face.
        repeats_per_metre: scale of the texture, continuous over the whole slab.
    """
    cells = np.pad(np.asarray(filled, dtype=bool), 1)
    height = top - bottom
    pieces: list[Mesh] = []

    def add(corner: Vector, right: Vector, up: Vector, axis: int, sign: int) -> None:
        face = quad(corner, right, up)
        uvs = _side_uvs(face.vertices, axis, sign) * repeats_per_metre
        pieces.append(Mesh(face.vertices, face.normals, uvs, face.faces))

    for i, (x0, x1) in enumerate(pairwise(xs)):
        for j, (y0, y1) in enumerate(pairwise(ys)):
            if not cells[i + 1, j + 1]:
                continue
            width, depth = x1 - x0, y1 - y0
            add((x0, y0, top), (width, 0, 0), (0, depth, 0), 2, 1)
            add((x0, y1, bottom), (width, 0, 0), (0, -depth, 0), 2, -1)
            if not cells[i, j + 1]:
                add((x0, y1, bottom), (0, -depth, 0), (0, 0, height), 0, -1)
            if not cells[i + 2, j + 1]:
                add((x1, y0, bottom), (0, depth, 0), (0, 0, height), 0, 1)
            if not cells[i + 1, j]:
                add((x0, y0, bottom), (width, 0, 0), (0, 0, height), 1, -1)
            if not cells[i + 1, j + 2]:
                add((x1, y1, bottom), (-width, 0, 0), (0, 0, height), 1, 1)
    return merge(pieces)
