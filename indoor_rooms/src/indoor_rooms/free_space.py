"""Where a round robot may stand and move: exact distances to the polygons of what stands on the floor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from indoor_rooms.errors import RoomError
from indoor_rooms.room import Room

# Ahead, back, left and right of a robot that looks along y.
_MOVES = ((0, 1), (0, -1), (-1, 0), (1, 0))
# The lattice is shifted in this many steps along each axis to where most positions are free.
SHIFTS = 7
# The search for what is near wants a distance above 0.
_NO_REACH = 1e-12


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
        polygons: (K, 2) each, filled, convex or not, whose edges do not cross.
        reach: metres from which on a distance does not matter; such a one may come out as any that is no smaller,
            infinity too. In a furnished room most polygons are out of reach of most ways, and need not be looked at.
    """
    nearest = np.full(len(starts), np.inf)
    if not len(starts) or not len(polygons):
        return nearest
    ways = shapely.linestrings(np.stack([starts, ends], axis=1))
    tree = shapely.STRtree([shapely.Polygon(polygon) for polygon in polygons])
    farthest = max(reach, _NO_REACH) if np.isfinite(reach) else None
    (way, _), distance = tree.query_nearest(ways, farthest, return_distance=True, all_matches=False)
    nearest[way] = distance
    return nearest
