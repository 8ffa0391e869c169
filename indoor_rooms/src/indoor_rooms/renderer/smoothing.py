"""Smoothing values over a mesh, and filling in vertices that have none."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from indoor_rooms.renderer.vectors import dot

# Neighbours farther than this hardly count; metres.
REACH = 0.08
# Vertices whose normals differ by more than about 25 degrees do not share light.
SIMILAR_NORMALS = 0.9


class SurfaceGraph:
    """Which vertices are neighbours on a smooth surface.

    Vertices at one place with one normal (seams of texture coordinates, quads side by side) count as one.

    Args:
        positions: (V, 3) metres.
        normals: (V, 3) unit vectors.
        faces: (F, 3).
    """

    def __init__(
        self, positions: NDArray[np.float32], normals: NDArray[np.float32], faces: NDArray[np.int32]
    ) -> None:
        self._group, first = _weld(positions, normals)
        places, directions = positions[first], normals[first]
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        edges = np.sort(self._group[edges], axis=1)
        edges = np.stack(np.divmod(np.unique(edges[:, 0] * len(first) + edges[:, 1]), len(first)), axis=1)
        alike = dot(directions[edges[:, 0]], directions[edges[:, 1]]) > SIMILAR_NORMALS
        edges = edges[alike & (edges[:, 0] != edges[:, 1])]
        length = np.linalg.norm(places[edges[:, 0]] - places[edges[:, 1]], axis=1)
        weight = np.exp(-((length / REACH) ** 2) / 2) + 1e-6
        count = len(first)
        rows, columns = edges.T
        self._weights = sparse.csr_array(
            (
                np.concatenate([weight, weight]).astype(np.float32),
                (np.concatenate([rows, columns]), np.concatenate([columns, rows])),
            ),
            shape=(count, count),
        )

    def smooth(self, values: NDArray[np.float32], trust: NDArray[np.float32], rounds: int) -> NDArray[np.float32]:
        """Replace every vertex's value by a weighted mean with its neighbours'.

        Args:
            values: (V, K).
            trust: (V,) weight of each value: 1 sound, 0 unknown; unknown vertices are filled from sound ones.
            rounds: how often; each round reaches one edge farther.

        Returns:
            (V, K) float32; where nothing sound is connected, the value given.
        """
        count = self._weights.shape[0]
        weight = np.bincount(self._group, trust, count).astype(np.float32)
        mixed = np.empty((count, values.shape[1]), np.float32)
        for channel in range(values.shape[1]):
            mixed[:, channel] = np.bincount(self._group, trust * values[:, channel], count)
        # Premultiplied by their trust, unknown values spread nothing and the division at the end fills them.
        size = np.maximum(np.bincount(self._group, minlength=count), 1).astype(np.float32)
        mixed /= size[:, None]
        weight /= size
        total = 1 + np.asarray(self._weights.sum(axis=1)).ravel()
        for _ in range(rounds):
            mixed = (mixed + self._weights @ mixed) / total[:, None]
            weight = (weight + self._weights @ weight) / total
        known = weight > 1e-6
        mixed[known] /= weight[known, None]
        return np.where(known[self._group, None], mixed[self._group], values).astype(np.float32)


def _weld(
    positions: NDArray[np.float32], normals: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Group of each vertex (V,), and one vertex of each group."""
    cells = np.hstack([np.round(positions * 5000), np.round(normals * 3)]).astype(np.int64)
    # A 64-bit hash instead of sorting rows of six: a hundred times faster, and a collision is harmless.
    key = np.zeros(len(cells), np.uint64)
    for column in cells.T.astype(np.uint64):
        key = (key ^ column) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    return group.ravel().astype(np.int64), first
