"""Where a round robot may stand and move: exact distances to the polygons of what stands on the floor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from indoor_rooms.errors import RoomError
from indoor_rooms.room import Room

# Ahead, back, left and right of a robot that looks along y.
_MOVES = ((0, 1), (0, -1), (-1, 0), (1, 0))
# The lattice is shifted in this many steps along each axis to where most positions are free.
SHIFTS = 7


class FreeSpaceError(RoomError, ValueError):
    """A room in which the robot finds no place."""


def free_positions(
    room: Room, spacing: float = 0.35, radius: float = 0.2, places: int | None = None
) -> NDArray[np.float64]:
    """Positions of a square lattice a robot can stand on and reach from each other.

    The lattice is laid where it has most positions; of several islands only the largest is kept.

    Args:
        room: its walls and obstacles.
        spacing: metres between neighbours.
        radius: of the robot, metres; nothing comes closer to its centre.
        places: keep only this many, those around the middle that can be reached from each other; None for all.

    Returns:
        (P, 2) x, y in metres.

    Raises:
        FreeSpaceError: if there is no free position, or fewer than `places`, or spacing or radius are not positive.
    """
    if not (spacing > 0 and radius > 0):
        raise FreeSpaceError(f"spacing and robot radius must be positive, got {spacing} and {radius}")
    polygons = [polygon for _, polygon in room.obstacles]
    shifts = np.arange(SHIFTS) * spacing / SHIFTS
    best = np.zeros((0, 2))
    for shift_x in shifts:
        for shift_y in shifts:
            x = np.arange(radius + shift_x, room.size[0] - radius + 1e-9, spacing)
            y = np.arange(radius + shift_y, room.size[1] - radius + 1e-9, spacing)
            lattice = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
            if len(lattice) <= len(best):
                continue
            free = lattice[clearance(lattice, lattice, polygons, radius) >= radius]
            if len(free) > len(best):
                free = _largest_island(free, polygons, spacing, radius)
                best = free if len(free) > len(best) else best
    if len(best) == 0:
        raise FreeSpaceError(
            f"room '{room.name}' has no free position for a robot of radius {radius} m; use a smaller radius"
        )
    if places is None:
        return best
    if places > len(best):
        raise FreeSpaceError(
            f"room '{room.name}' has {len(best)} positions {spacing:g} m apart, not {places}; ask for fewer places "
            "or a smaller spacing"
        )
    return best[_around_the_middle(best, _moves(best, polygons, spacing, radius), places)]


def _largest_island(
    positions: NDArray[np.float64], polygons: Sequence[NDArray[np.float64]], spacing: float, radius: float
) -> NDArray[np.float64]:
    moves = _moves(positions, polygons, spacing, radius)
    start = np.repeat(np.arange(len(positions)), len(_MOVES))
    graph = sparse.csr_array((np.ones(len(start)), (start, moves.ravel())), shape=(len(positions), len(positions)))
    _, labels = csgraph.connected_components(graph, connection="strong")
    return positions[labels == np.bincount(labels).argmax()]


def _moves(
    positions: NDArray[np.float64], polygons: Sequence[NDArray[np.float64]], spacing: float, radius: float
) -> NDArray[np.int32]:
    """Where each of `_MOVES` leads from each position, (P, 4); its own number where the move is blocked."""
    cells = np.round((positions - positions.min(axis=0)) / spacing).astype(np.int64)
    number = {tuple(cell): position for position, cell in enumerate(cells.tolist())}
    neighbours = [
        [number.get((x + right, y + ahead), position) for right, ahead in _MOVES]
        for position, (x, y) in enumerate(cells.tolist())
    ]
    return without_collisions(positions, np.array(neighbours, np.int32), polygons, radius)


def _around_the_middle(positions: NDArray[np.float64], moves: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """Numbers of `count` connected positions, in ascending order.

    They grow from the position nearest the middle of all, each time by the neighbour nearest to the middle.
    """
    distance = np.linalg.norm(positions - positions.mean(axis=0), axis=1).round(6)
    chosen = {int(distance.argmin())}
    while len(chosen) < count:
        edge = {int(place) for place in moves[sorted(chosen)].ravel()} - chosen
        chosen.add(min(edge, key=lambda place: (distance[place], place)))
    return np.array(sorted(chosen))


def without_collisions(
    poses: NDArray[np.floating],
    transitions: NDArray[np.int32],
    polygons: Sequence[NDArray[np.float64]],
    radius: float,
) -> NDArray[np.int32]:
    """Block the moves on whose way a robot would touch an obstacle though both ends are free.

    Args:
        poses: (S, 2) or more columns, of which the first two are x, y in metres.
        transitions: (S, A).
        polygons: (K, 2) each, metres.
        radius: of the robot, metres.

    Returns:
        (S, A) transitions, a state's own index where the move is blocked.
    """
    places = poses[:, :2].astype(np.float64)
    state, action = np.nonzero((places[transitions] != places[:, None]).any(-1))
    ends = transitions[state, action]
    touches = clearance(places[state], places[ends], polygons, radius) < radius - 1e-6
    result = transitions.copy()
    result[state[touches], action[touches]] = state[touches]
    return result


def clearance(
    starts: NDArray[np.float64],
    ends: NDArray[np.float64],
    polygons: Sequence[NDArray[np.float64]],
    reach: float = np.inf,
) -> NDArray[np.float64]:
    """Distance of straight ways from the nearest polygon, (N,) metres; 0 where they touch or enter one.

    Args:
        starts: (N, 2).
        ends: (N, 2); equal to `starts` for the clearance of points.
        polygons: (K, 2) each, filled, convex or not.
        reach: metres from which on a distance does not matter; such a one may come out as any that is no smaller,
            infinity too. In a furnished room most edges are out of reach of most ways, and need not be looked at.
    """
    nearest = np.full(len(starts), np.inf)
    if not len(starts) or not len(polygons):
        return nearest
    corners = np.concatenate(polygons).astype(np.float64)
    following = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons]).astype(np.float64)
    way, edge = np.nonzero(_boxes_within(reach, starts, ends, corners, following))
    distance = _segment_distance(starts[way], ends[way], corners[edge], following[edge])
    np.minimum.at(nearest, way, distance)
    first_edges = np.cumsum([0, *(len(polygon) for polygon in polygons[:-1])])
    nearest[_inside(starts, corners, following, first_edges)] = 0
    return nearest


def _boxes_within(
    reach: float,
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    c: NDArray[np.float64],
    d: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Whether the boxes around N segments ab and E segments cd are within reach of each other, (N, E)."""
    reach = reach + 1e-6  # rounding must not make a distance look longer than it is computed to be
    low, high = np.minimum(a, b) - reach, np.maximum(a, b) + reach
    other_low, other_high = np.minimum(c, d), np.maximum(c, d)
    along_x, along_y = (
        (low[:, None, axis] <= other_high[:, axis]) & (high[:, None, axis] >= other_low[:, axis]) for axis in (0, 1)
    )
    return along_x & along_y


def _inside(
    points: NDArray[np.float64],
    corners: NDArray[np.float64],
    following: NDArray[np.float64],
    first_edges: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Whether points lie in one of some polygons (N,): an odd number of its edges lie to their right.

    Args:
        points: (N, 2).
        corners: (E, 2), where the edges of all the polygons start, those of one after those of another.
        following: (E, 2), where they end.
        first_edges: number of each polygon's first edge.
    """
    x, y = points[:, 0], points[:, 1]
    spans = (corners[:, 1] > y[:, None]) != (following[:, 1] > y[:, None])
    point, edge = np.nonzero(spans)
    start, end = corners[edge], following[edge]
    crossing = start[:, 0] + (y[point] - start[:, 1]) / (end[:, 1] - start[:, 1]) * (end[:, 0] - start[:, 0])
    spans[point, edge] = crossing > x[point]
    return (np.add.reduceat(spans, first_edges, axis=1, dtype=np.int64) % 2 == 1).any(axis=1)


def _segment_distance(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], d: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Distance between segments ab and cd, (N,); each is (N, 2) x, y."""
    ends = np.minimum.reduce(
        [_point_distance(a, c, d), _point_distance(b, c, d), _point_distance(c, a, b), _point_distance(d, a, b)]
    )
    crosses = (_side(c, d, a) * _side(c, d, b) < 0) & (_side(a, b, c) * _side(a, b, d) < 0)
    return np.where(crosses, 0.0, ends)


def _point_distance(
    point: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.float64]:
    along, to = end - start, point - start
    length = np.maximum((along**2).sum(-1), 1e-18)
    share = np.clip((to * along).sum(-1) / length, 0, 1)
    return np.sqrt(((to - share[..., None] * along) ** 2).sum(-1))


def _side(start: NDArray[np.float64], end: NDArray[np.float64], point: NDArray[np.float64]) -> NDArray[np.float64]:
    along, to = end - start, point - start
    return along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0]
