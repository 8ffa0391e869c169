"""Whether two bodies intersect, and how deeply, and what a body stands on: exact on triangles, by Embree.

Two bodies intersect when an edge of one crosses a triangle of the other, or one lies wholly inside the other. How
deeply is how far one has to be moved until they no longer do, in the best of DIRECTIONS: contact is what a
movement of TOLERANCE undoes. So a mug that sinks 1 mm into a table touches it, though the table's long edges pass
through the mug's whole foot, and a leaf without thickness that pierces another does intersect it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
import shapely
from numpy.typing import NDArray

from indoor_rooms.geometry.mesh import Mesh, rotation
from indoor_rooms.renderer.raycast import RayCaster

# Bodies that a movement this long separates do no more than touch; metres.
TOLERANCE = 0.002
# Depths are measured up to here, to within PRECISION; metres.
DEEPEST = 0.256
PRECISION = 0.0002
# Aligned boxes have edges in each other's faces, where crossing is a matter of rounding: nothing is tested exactly
# where it stands, nor moved exactly along an axis.
NUDGE = np.array([0.00007, 0.00005, 0.00003])
_TILT = rotation(2.1, -1.7, 2.6)
_GRID = np.array([step for step in product((-1, 0, 1), repeat=3) if any(step)], np.float64)
DIRECTIONS = (_GRID / np.linalg.norm(_GRID, axis=1, keepdims=True)) @ _TILT.T
# A point is inside when along MOST of the directions it is, for meshes lack hidden sides.
MOST = 0.6
# A body lies inside another when most of about this many of its vertices do.
_SAMPLES = 24
_MOST_LAYERS = 24
_DOWN = np.array([0.0, 0.0, -1.0], np.float32)


class Solid:
    """The triangles of one object.

    Args:
        name: the object's.
        meshes: all that it is made of.
    """

    def __init__(self, name: str, meshes: Iterable[Mesh]) -> None:
        self.name = name
        self.meshes = tuple(meshes)
        self.vertices = np.concatenate([mesh.vertices for mesh in self.meshes])
        self.low, self.high = self.vertices.min(axis=0), self.vertices.max(axis=0)

    @cached_property
    def triangles(self) -> NDArray[np.float64]:
        """(F, 3, 3) corners, metres."""
        return np.concatenate([mesh.vertices[mesh.faces] for mesh in self.meshes])

    @cached_property
    def edges(self) -> NDArray[np.float64]:
        """(E, 2, 3) ends of the triangles' sides, metres, shared ones once."""
        parts = []
        for mesh in self.meshes:
            sides = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
            keys = np.unique(sides[:, 0] * len(mesh.vertices) + sides[:, 1])
            parts.append(mesh.vertices[np.stack(np.divmod(keys, len(mesh.vertices)), axis=1)])
        return np.concatenate(parts)

    @cached_property
    def areas(self) -> NDArray[np.float64]:
        """(F,) square metres."""
        sides = self.triangles[:, 1:] - self.triangles[:, :1]
        return np.asarray(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2)

    @cached_property
    def centre_of_mass(self) -> NDArray[np.float64]:
        """(3,) metres, of a body as heavy everywhere on its surface."""
        return np.average(self.triangles.mean(axis=1), axis=0, weights=self.areas)

    @cached_property
    def caster(self) -> RayCaster:
        """For rays against this body alone."""
        return RayCaster(self.triangles.astype(np.float32))


@dataclass(frozen=True)
class Intersection:
    """How two bodies intersect.

    Attributes:
        depth: metres one has to be moved to come free, at most DEEPEST.
        place: (3,) metres, the middle of where they cross, or of the one inside.
    """

    depth: float
    place: NDArray[np.float64]


def intersection(first: Solid, second: Solid, tolerance: float = TOLERANCE) -> Intersection | None:
    """How two bodies intersect, or None if they are apart or touch: movable apart by `tolerance` metres."""
    # Boxes that this moves apart need no rays.
    if np.minimum(first.high - second.low, second.high - first.low).min() <= tolerance:
        return None
    place = _where(first, second, NUDGE)
    if place is None or len(ways := _freeing(first, second, DIRECTIONS, tolerance)):
        return None
    held = free = tolerance
    while len(ways) == 0 and free < DEEPEST:
        held, free = free, min(2 * free, DEEPEST)
        ways = _freeing(first, second, DIRECTIONS, free)
    while len(ways) and free - held > PRECISION:
        middle = (held + free) / 2
        nearer = _freeing(first, second, ways, middle)
        held, free, ways = (held, middle, nearer) if len(nearer) else (middle, free, ways)
    return Intersection(free, place)


def _freeing(first: Solid, second: Solid, directions: NDArray[np.float64], distance: float) -> NDArray[np.float64]:
    """Those of the directions along which moving the first body by `distance` metres separates the two."""
    return np.array([way for way in directions if _where(first, second, distance * way) is None])


def _where(first: Solid, second: Solid, shift: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The middle (3,) of where two bodies intersect once the first is moved by `shift`; None if they do not."""
    if ((first.high + shift < second.low) | (second.high < first.low + shift)).any():
        return None
    points = np.concatenate([_crossings(first, second, shift), _crossings(second, first, -shift) + shift])
    if len(points):
        return (points.min(axis=0) + points.max(axis=0)) / 2
    for inner, outer, move in ((first, second, shift), (second, first, -shift)):
        # What is larger than another cannot be inside it.
        if ((inner.low + move >= outer.low) & (inner.high + move <= outer.high)).all():
            sample = inner.vertices[:: max(1, len(inner.vertices) // _SAMPLES)] + move
            if inside(outer, sample).mean() > 0.5:
                return (inner.low + inner.high) / 2
    return None


def _crossings(first: Solid, second: Solid, shift: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) points at which edges of the first body, moved by `shift`, cross triangles of the second."""
    edges = first.edges
    near = ((edges.min(axis=1) + shift <= second.high) & (edges.max(axis=1) + shift >= second.low)).all(axis=1)
    start = (edges[near, 0] + shift).astype(np.float32)
    along = (edges[near, 1] - edges[near, 0]).astype(np.float32)
    distance = second.caster.hits(start, along).distance
    reached = distance <= 1
    return np.asarray(start[reached] + along[reached] * distance[reached, None], np.float64)


def inside(body: Solid, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether points (N, 3) lie inside a body (N,).

    Along a ray from inside, one more surface is met from behind than from its front, however many closed shells the
    body is pushed together from. Where a side is missing some rays get away, hence MOST of them decide.
    """
    origins = np.repeat(points, len(DIRECTIONS), axis=0).astype(np.float32)
    directions = np.tile(DIRECTIONS, (len(points), 1)).astype(np.float32)
    layers = np.zeros(len(origins), np.int64)
    going = np.arange(len(origins))
    for _ in range(_MOST_LAYERS):
        hits = body.caster.hits(origins[going], directions[going])
        met = hits.triangle >= 0
        going = going[met]
        if len(going) == 0:
            break
        layers[going] += np.where((hits.normal[met] * directions[going]).sum(axis=1) > 0, 1, -1)
        # A twentieth of a millimetre past the surface, or it would be met again.
        origins[going] += directions[going] * (hits.distance[met, None] + 5e-5)
    return (layers.reshape(len(points), -1) > 0).mean(axis=1) >= MOST


def gaps_below(feet: NDArray[np.float64], others: Sequence[Solid]) -> tuple[NDArray[np.float64], str]:
    """How far points are above what is next below them.

    Args:
        feet: (N, 3) points, metres.
        others: what they may stand on.

    Returns:
        (N,) metres, infinite where nothing is below, and the name of the body that is nearest. A point inside a body
        is not above it; its gap is 0, and intersecting is another matter.
    """
    gaps, nearest = np.full(len(feet), np.inf), "nothing"
    low, high = feet.min(axis=0), feet.max(axis=0)
    # What sinks in a little is above it all the same.
    starts = (feet - TOLERANCE * _DOWN).astype(np.float32)
    for other in others:
        if (other.low[:2] > high[:2]).any() or (other.high[:2] < low[:2]).any() or other.low[2] > high[2] + TOLERANCE:
            continue
        hits = other.caster.hits(starts, np.tile(_DOWN, (len(starts), 1)))
        distance = np.where(hits.normal[:, 2] > 0, np.maximum(hits.distance - TOLERANCE, 0.0), 0.0)
        distance[hits.triangle < 0] = np.inf
        if distance.min() < gaps.min():
            nearest = other.name
        gaps = np.minimum(gaps, distance)
    return gaps, nearest


def distance_from_hull(point: NDArray[np.float64], points: NDArray[np.float64]) -> float:
    """Distance of a point (2,) from the convex hull of others (N, 2), which may be a line or one point; metres."""
    return float(shapely.MultiPoint(points).convex_hull.distance(shapely.Point(point)))
