"""Round meshes: lathes, tubes along a path, cylinders, discs, leaves, and the curves they are made from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_rooms.geometry.mesh import Mesh, Vector, grid_faces, merge, smooth_normals, without_slivers

Profile = Sequence[tuple[float, float]] | NDArray[np.float64]


def smooth_profile(points: ArrayLike, rounds: int = 2) -> NDArray[np.float64]:
    """Rounds a polyline's corners by Chaikin's corner cutting; its ends stay. (K, D) in and out."""
    line = np.asarray(points, dtype=np.float64)
    for _ in range(rounds):
        cut = np.empty((2 * len(line) - 2, line.shape[1]))
        cut[0::2] = 0.75 * line[:-1] + 0.25 * line[1:]
        cut[1::2] = 0.25 * line[:-1] + 0.75 * line[1:]
        line = np.concatenate([line[:1], cut, line[-1:]])
    return line


def _profile_normals(profile: NDArray[np.float64]) -> NDArray[np.float64]:
    """Outward normals of a profile; a point given twice is a sharp edge."""
    steps = np.diff(profile, axis=0)
    lengths = np.linalg.norm(steps, axis=1, keepdims=True)
    segment = np.stack([steps[:, 1], -steps[:, 0]], axis=1) / np.maximum(lengths, 1e-12)
    normals = np.concatenate([segment, segment[-1:]])
    normals[1:-1] += segment[:-1]
    for index in np.flatnonzero(lengths[:, 0] < 1e-9):
        normals[index], normals[index + 1] = segment[index - 1], segment[min(index + 1, len(segment) - 1)]
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def lathe(profile: Profile, segments: int = 36, repeats: tuple[float, float] = (1.0, 1.0)) -> Mesh:
    """A profile turned about the z axis.

    Args:
        profile: (K, 2) radius and z in metres, running from the bottom's centre up the outside (and down the inside
            of a hollow thing); the outside is to the right of the way. A point given twice makes a sharp edge.
        segments: pieces around.
        repeats: how often the texture repeats around and along the profile.
    """
    line = np.asarray(profile, dtype=np.float64)
    normals = _profile_normals(line)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    angles = np.linspace(0.0, 2 * np.pi, segments + 1)
    cos, sin = np.cos(angles), np.sin(angles)

    def turn(values: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K, 2) radial and z components to ((segments + 1) * K, 3)."""
        radial, height = values[:, 0], values[:, 1]
        rows = [np.outer(cos, radial), np.outer(sin, radial), np.broadcast_to(height, (len(cos), len(height)))]
        return np.stack(rows, axis=-1).reshape(-1, 3)

    u, v = np.meshgrid(angles / (2 * np.pi) * repeats[0], along / along[-1] * repeats[1], indexing="ij")
    mesh = Mesh(
        turn(line), turn(normals), np.stack([u, v], axis=-1).reshape(-1, 2), grid_faces(segments + 1, len(line))
    )
    return without_slivers(mesh)


def cylinder(radius: float, height: float, segments: int = 28, bevel: float = 0.002) -> Mesh:
    """A closed cylinder standing on z = 0 with slightly rounded rims; metres."""
    b = min(bevel, radius / 2, height / 2)
    profile = [(0.0, 0.0), (radius - b, 0.0), (radius, b), (radius, height - b), (radius - b, height), (0.0, height)]
    return lathe(smooth_profile(profile, 1) if bevel else profile, segments)


def sphere(radius: float, segments: int = 28, squash: float = 1.0) -> Mesh:
    """A sphere standing on z = 0, `squash` times as high as wide; metres."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, segments // 2 + 1)
    profile = np.stack([radius * np.cos(angle), radius * squash * (np.sin(angle) + 1)], axis=1)
    profile[[0, -1], 0] = 0.0
    return lathe(profile, segments)


def disc(radius: float, height: float = 0.0, segments: int = 36, repeats: float = 1.0) -> Mesh:
    """A flat disc facing up at z = `height`; the texture's middle is its centre."""
    angles = np.linspace(0.0, 2 * np.pi, segments, endpoint=False)
    rim = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    flat = np.concatenate([[[0.0, 0.0]], rim])
    vertices = np.concatenate([flat * radius, np.full((segments + 1, 1), height)], axis=1)
    around = np.arange(segments)
    faces = np.stack([np.zeros_like(around), around + 1, (around + 1) % segments + 1], axis=1)
    return Mesh(vertices, np.tile([0.0, 0.0, 1.0], (segments + 1, 1)), flat * repeats / 2 + 0.5, faces)


def arc(
    centre: Vector,
    radius: float,
    start: float,
    stop: float,
    points: int = 14,
    plane: Literal["xy", "xz", "yz"] = "xz",
) -> NDArray[np.float64]:
    """(points, 3) along a circle in a plane, from angle `start` to `stop` in degrees."""
    angles = np.radians(np.linspace(start, stop, points))
    first, second = ("xyz".index(axis) for axis in plane)
    path = np.zeros((points, 3))
    path[:, first], path[:, second] = radius * np.cos(angles), radius * np.sin(angles)
    return path + np.asarray(centre)


def tube(path: ArrayLike, radius: ArrayLike, sides: int = 12, capped: bool = True) -> Mesh:
    """A round tube along a path; u runs around it, v from its start to its end.

    Args:
        path: (K, 3) points in metres, no two neighbours equal.
        radius: metres, one for all or several, spread evenly over the path's points.
        sides: of the cross-section.
        capped: close both ends.
    """
    points = np.asarray(path, dtype=np.float64)
    stations = np.atleast_1d(np.asarray(radius, dtype=np.float64))
    radii = np.interp(np.linspace(0, 1, len(points)), np.linspace(0, 1, len(stations)), stations)
    steps = np.diff(points, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    tangents = np.concatenate([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    angles = np.linspace(0.0, 2 * np.pi, sides + 1)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    side = np.eye(3)[int(np.argmin(np.abs(tangents[0])))]
    rings = []
    for tangent in tangents:
        # Carrying the frame along (instead of making it anew) keeps the tube from twisting.
        side = side - tangent * (tangent @ side)
        side /= np.linalg.norm(side)
        rings.append(np.outer(np.cos(angles), side) + np.outer(np.sin(angles), np.cross(tangent, side)))
    outwards = np.stack(rings)
    u, v = np.meshgrid(angles / (2 * np.pi), along / along[-1])
    mesh = Mesh(
        (points[:, None] + radii[:, None, None] * outwards).reshape(-1, 3),
        outwards.reshape(-1, 3),
        np.stack([u, v], axis=-1).reshape(-1, 2),
        grid_faces(len(points), sides + 1)[:, ::-1],
    )
    pieces = [without_slivers(mesh)]
    if capped:
        around = np.arange(sides)
        for end, sign in ((0, -1), (-1, 1)):
            ring = points[end] + radii[end] * outwards[end, :-1]
            faces = np.stack([np.full(sides, sides), around, (around + 1) % sides], axis=1)
            pieces.append(
                Mesh(
                    np.concatenate([ring, points[end][None]]),
                    np.tile(sign * tangents[end], (sides + 1, 1)),
                    np.full((sides + 1, 2), [0.5, 0.0 if end == 0 else 1.0]),
                    faces if sign > 0 else faces[:, ::-1],
                )
            )
    return merge(pieces)


def leaf(length: float, width: float, bend: float, pieces: int = 6, droop: float = 0.0) -> Mesh:
    """A thin pointed leaf growing from the origin upwards and bending towards +x.

    Args:
        length: along the leaf, metres.
        width: at its widest, metres.
        bend: 0 straight up .. 1 bent over to the horizontal.
        pieces: along it.
        droop: how far the tip hangs below, as a fraction of the length.
    """
    t = np.linspace(0.0, 1.0, pieces + 1)
    x = length * bend * t**1.4
    z = length * t * np.sqrt(1 - 0.72 * bend**2) - length * droop * t**3
    half = width / 2 * np.sin(np.pi * np.clip(0.06 + 0.94 * t, 0.0, 0.999)) ** 0.8
    rows = [
        np.stack([x - 0.25 * half, half * side, z + 0.25 * half * abs(side)], axis=1) for side in (-1.0, 0.0, 1.0)
    ]
    vertices = np.stack(rows, axis=1).reshape(-1, 3)
    uvs = np.stack(np.broadcast_arrays(np.array([0.0, 0.5, 1.0])[None], t[:, None]), axis=-1).reshape(-1, 2)
    top = smooth_normals(vertices, uvs, grid_faces(pieces + 1, 3))
    # Two sheets back to back, or the underside would be lit as if it were the top.
    under = Mesh(top.vertices - 0.0006 * top.normals, -top.normals, top.uvs, top.faces[:, ::-1])
    return merge([top, under])
