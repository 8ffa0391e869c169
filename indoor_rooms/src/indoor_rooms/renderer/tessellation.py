"""Cutting large triangles into small ones, so that baked light has vertices to live on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MAX_ROUNDS = 40


def tessellate(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], longest: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Bisect the longest edge of every triangle until none is longer than allowed.

    Triangles that share an edge and its limit share the new vertex too: no T-junctions, no cracks.

    Args:
        vertices: (V, K), the first three columns are positions in metres; all columns are interpolated.
        faces: (F, 3) indices into the vertices.
        longest: (F,) the longest edge allowed in metres.

    Returns:
        Vertices (V', K) of which the first V are the given ones, faces (F', 3), and for each new face the index
        of the given face it is cut from (F',).
    """
    source = np.arange(len(faces))
    done_faces, done_source = [], []
    for _ in range(MAX_ROUNDS):
        corners = vertices[faces, :3]
        lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        fits = lengths.max(axis=1) <= longest[source]
        done_faces.append(faces[fits])
        done_source.append(source[fits])
        faces, source, lengths = faces[~fits], source[~fits], lengths[~fits]
        if len(faces) == 0:
            break
        turn = (lengths.argmax(axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(faces, turn, axis=1).T
        key = np.minimum(a, b) * len(vertices) + np.maximum(a, b)
        _, first, edge = np.unique(key, return_index=True, return_inverse=True)
        middle = len(vertices) + edge.ravel()
        vertices = np.concatenate([vertices, (vertices[a[first]] + vertices[b[first]]) / 2])
        faces = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
        source = np.concatenate([source, source])
    return vertices, np.concatenate([*done_faces, faces]), np.concatenate([*done_source, source])
