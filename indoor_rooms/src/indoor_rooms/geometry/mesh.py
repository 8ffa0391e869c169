"""Triangle meshes and the primitives everything in a room is made of.

Frame: x east, y north, z up, metres (right-handed). A scene's floor position (x, z) is a room's (x, y).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh with smooth normals and texture coordinates.

    Attributes:
        vertices: (V, 3) float64, metres.
        normals: (V, 3) float64, unit length.
        uvs: (V, 2) float64, texture coordinates; they wrap at 1.
        faces: (F, 3) int64, indices into the vertices, counter-clockwise seen from outside.
    """

    vertices: NDArray[np.float64]
    normals: NDArray[np.float64]
    uvs: NDArray[np.float64]
    faces: NDArray[np.int64]


def merge(meshes: Iterable[Mesh]) -> Mesh:
    """Joins meshes into one, without welding their vertices."""
    parts = list(meshes)
    starts = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    return Mesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.uvs for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]),
    )


def rotation(about_x: float = 0.0, about_y: float = 0.0, about_z: float = 0.0) -> NDArray[np.float64]:
    """The (3, 3) matrix turning about x, then y, then z; degrees, counter-clockwise seen from the axis' tip."""
    (cx, sx), (cy, sy), (cz, sz) = (
        (np.cos(angle), np.sin(angle)) for angle in np.radians([about_x, about_y, about_z])
    )
    turn_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    turn_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    turn_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return turn_z @ turn_y @ turn_x


def transform(
    mesh: Mesh,
    offset: Vector = (0.0, 0.0, 0.0),
    rotate: Vector = (0.0, 0.0, 0.0),
    scale: float | Vector = 1.0,
) -> Mesh:
    """Scales, then rotates, then moves a mesh.

    Args:
        mesh: what to move.
        offset: metres along x, y, z.
        rotate: degrees about x, y and z, applied in this order.
        scale: positive factor, one for all axes or one for each.

    Returns:
        The moved mesh, normals still unit length and windings unchanged.
    """
    factors = np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,))
    matrix = rotation(*rotate)
    normals = mesh.normals / factors
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh((mesh.vertices * factors) @ matrix.T + np.asarray(offset), normals @ matrix.T, mesh.uvs, mesh.faces)


def shear(mesh: Mesh, y_per_z: float) -> Mesh:
    """Slants a mesh: each metre of height shifts it by `y_per_z` metres along y; what is level stays level."""
    vertices, normals = mesh.vertices.copy(), mesh.normals.copy()
    vertices[:, 1] += y_per_z * vertices[:, 2]
    normals[:, 2] -= y_per_z * normals[:, 1]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(vertices, normals, mesh.uvs, mesh.faces)


def with_uvs(mesh: Mesh, uvs: NDArray[np.float64]) -> Mesh:
    """The same mesh with other texture coordinates, (V, 2)."""
    return replace(mesh, uvs=np.asarray(uvs, dtype=np.float64))


def grid_faces(rows: int, columns: int) -> NDArray[np.int64]:
    """Triangles of a rows x columns lattice of vertices; front side where (d/drow) x (d/dcolumn) points."""
    row, column = np.divmod(np.arange((rows - 1) * (columns - 1)), columns - 1)
    corner = row * columns + column
    first = np.stack([corner, corner + columns, corner + 1], axis=1)
    second = np.stack([corner + 1, corner + columns, corner + columns + 1], axis=1)
    return np.concatenate([first, second]).astype(np.int64)


def without_slivers(mesh: Mesh, smallest_area: float = 1e-11) -> Mesh:
    """Drops triangles without area (square metres), such as those at the poles of a lathe."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return replace(mesh, faces=mesh.faces[area > smallest_area])


def without_sides(mesh: Mesh, *sides: str) -> Mesh:
    """Drops the triangles facing along given axes ("+x", "-z", ...): what no one can ever see need not be lit."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-15)
    keep = np.ones(len(mesh.faces), dtype=bool)
    for side in sides:
        keep &= normals[:, "xyz".index(side[1])] * (1 if side[0] == "+" else -1) < 0.99
    used, faces = np.unique(mesh.faces[keep], return_inverse=True)
    return Mesh(mesh.vertices[used], mesh.normals[used], mesh.uvs[used], faces.reshape(-1, 3))


def smooth_normals(vertices: NDArray[np.float64], uvs: NDArray[np.float64], faces: NDArray[np.int64]) -> Mesh:
    """A mesh whose normals average the faces around each place; seams in the texture do not show."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    face_normals = np.cross(b - a, c - a)
    _, place = np.unique(np.round(vertices, 6), axis=0, return_inverse=True)
    place = place.ravel()
    sums = np.zeros((int(place.max()) + 1, 3))
    for corner in range(3):
        np.add.at(sums, place[faces[:, corner]], face_normals)
    normals = sums[place]
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-15)
    return without_slivers(Mesh(vertices, normals, uvs, faces))


def quad(corner: Vector, right: Vector, up: Vector, repeats_per_metre: float | None = None) -> Mesh:
    """A flat parallelogram facing right x up.

    Args:
        corner: its lower left corner, where u = v = 0.
        right: edge along u, metres.
        up: edge along v, metres.
        repeats_per_metre: how often the texture repeats; None stretches it once over the whole.
    """
    start, along_u, along_v = (np.asarray(vector, dtype=np.float64) for vector in (corner, right, up))
    normal = np.cross(along_u, along_v)
    normal /= np.linalg.norm(normal)
    width, height = (
        (1.0, 1.0)
        if repeats_per_metre is None
        else (float(np.linalg.norm(edge)) * repeats_per_metre for edge in (along_u, along_v))
    )
    return Mesh(
        np.array([start, start + along_u, start + along_u + along_v, start + along_v]),
        np.tile(normal, (4, 1)),
        np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
