"""Pieces: what a generator of objects or furniture returns, meshes with their materials, before they get a name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from indoor_rooms.geometry.mesh import Mesh, Vector, transform
from indoor_rooms.materials.material import Material

Pieces: TypeAlias = list[tuple[Mesh, Material]]


def placed(pieces: Pieces, offset: Vector = (0.0, 0.0, 0.0), turn: float = 0.0, scale: float = 1.0) -> Pieces:
    """Moves pieces: scaled, turned about z by `turn` degrees (counter-clockwise from above), then offset (metres)."""
    return [(transform(mesh, offset, (0.0, 0.0, turn), scale), material) for mesh, material in pieces]


def bounds(meshes: Iterable[Mesh]) -> NDArray[np.float64]:
    """(2, 3) lowest and highest corner of meshes, metres."""
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    return np.stack([vertices.min(axis=0), vertices.max(axis=0)])


def footprint(meshes: Iterable[Mesh], up_to: float = 1.4) -> NDArray[np.float64]:
    """(K, 2) convex outline, counter-clockwise, of what lies below `up_to` metres, seen from above."""
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    below = np.round(vertices[vertices[:, 2] <= up_to, :2], 4)
    return below[ConvexHull(below).vertices]


def standing(pieces: Pieces) -> Pieces:
    """Lifts or lowers pieces until the lowest point is at z = 0: slanting legs end in slanting circles."""
    lowest = float(bounds(mesh for mesh, _ in pieces)[0, 2])
    return placed(pieces, (0.0, 0.0, -lowest))
