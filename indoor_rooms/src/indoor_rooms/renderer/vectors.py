"""Arithmetic on rows of vectors.

Functions here return (N, 3) arrays whose three columns lie one after the other in memory (NumPy's order "F"): NumPy
is several times faster on them than on rows of three numbers, and arithmetic keeps that order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def columns(*values: NDArray[np.floating]) -> NDArray[np.float32]:
    """An (N, K) array of K columns (N,), each contiguous in memory."""
    result = np.empty((len(values), len(values[0])), np.float32)
    for row, value in zip(result, values, strict=True):
        row[:] = value
    return result.T


def rows(vectors: NDArray[np.float32], index: NDArray[np.integer]) -> NDArray[np.float32]:
    """Some rows of an (N, K) array, (M, K), each column contiguous in memory."""
    result = np.empty((vectors.shape[1], len(index)), np.float32)
    for column, row in zip(vectors.T, result, strict=True):
        np.take(column, index, out=row, mode="clip")
    return result.T


def put(target: NDArray[np.float32], index: NDArray[np.integer], values: NDArray[np.float32]) -> None:
    """Replace some rows (M,) of an (N, K) array by (M, K) values."""
    for column, value in zip(target.T, values.T, strict=True):
        column[index] = value


def dot(first: NDArray[np.floating], second: NDArray[np.floating]) -> NDArray[np.float32]:
    """Dot product of each row, (N,) from two (N, 3); one of them may be a single row (1, 3)."""
    result = first[:, 0] * second[:, 0]
    result += first[:, 1] * second[:, 1]
    result += first[:, 2] * second[:, 2]
    return np.asarray(result, np.float32)


def unit(vectors: NDArray[np.floating]) -> NDArray[np.float32]:
    """Each row scaled to length 1, (N, 3); zero stays zero."""
    return np.asarray(vectors * (1 / np.maximum(np.sqrt(dot(vectors, vectors)), 1e-9))[:, None], np.float32)


def tangents(normals: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Two unit vectors (N, 3) that make a right-handed frame with each unit normal (Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.where(z >= 0, np.float32(1), np.float32(-1))
    scale = -1 / (sign + z)
    mixed = x * y * scale
    return columns(1 + sign * x * x * scale, sign * mixed, -sign * x), columns(mixed, sign + y * y * scale, -y)


def cosine_directions(
    normals: NDArray[np.float32], share: NDArray[np.float32], turn: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Directions about normals, as dense as the cosine to them.

    Args:
        normals: (N, 3) unit vectors.
        share: (N,) in 0..1, squared sine of the angle to the normal.
        turn: (N,) in 0..1, turns about the normal.
    """
    side, other = tangents(normals)
    radius, angle = np.sqrt(share), np.float32(2 * np.pi) * turn
    height = np.sqrt(np.maximum(1 - share, 0))
    side *= (radius * np.cos(angle))[:, None]
    other *= (radius * np.sin(angle))[:, None]
    side += other
    side += normals * height[:, None]
    return side
