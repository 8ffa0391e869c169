"""In which order a robot looks from many poses so that it drives and turns little, and round what is in its way.

Ways lead from a place to its neighbours: those with no third place between them, as of a Gabriel graph, which on a
square grid are the four around it; none is longer than `LONGEST`. A way that was found blocked is not tried again.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from active_perceiver.errors import UserError
from active_perceiver.scenes.angles import signed_angle
from active_perceiver.scenes.lattice import lattice_poses

# Short ways are dearer than one long one only if it is hardly longer: where places were marked one can walk.
LENGTH_POWER = 3
# A place is given up when so many ways to it were found blocked.
TRIES = 2
# Metres of the longest way: no room has one, but a table in centimetres has.
LONGEST = 10.0


class PlacesError(UserError, ValueError):
    """Poses that a robot cannot photograph."""


class Tour:
    """A robot's way through all places.

    Args:
        poses: (S, 4) x, z in metres, heading and tilt in degrees, as `NavigatingRobot.go_to` has them.

    Attributes:
        places: (P, 2) the different places among them, x, z in metres.
        place_of: (S,) the place of each pose.
        given_up: places that cannot be reached.
    """

    def __init__(self, poses: NDArray[np.float64]) -> None:
        self._poses = poses
        _, first, place_of = np.unique(poses[:, :2].round(3), axis=0, return_index=True, return_inverse=True)
        rank = np.argsort(np.argsort(first))  # in the order of the table
        self.places: NDArray[np.float64] = poses[np.sort(first), :2]
        self.place_of: NDArray[np.int64] = rank[place_of.reshape(-1)]
        self.given_up: set[int] = set()
        self._lengths = neighbours(self.places)
        self._lengths[self._lengths > LONGEST] = 0.0
        self._failures = np.zeros(len(self.places), int)

    def way(self, here: int, wanted: set[int]) -> list[int] | None:
        """The places to go through from one to the nearest wanted one, which is the last.

        Args:
            here: number of the place where the robot is.
            wanted: numbers of places.

        Returns:
            Numbers of places, none if one that is wanted is here; None if there is no way to any.
        """
        targets = sorted(wanted - self.given_up)
        costs, before = self._shortest(here)
        if not targets or not np.isfinite(costs[targets]).any():
            return None
        place = min(targets, key=lambda target: (round(float(costs[target]), 6), target))
        way = []
        while place != here:
            way.append(place)
            place = int(before[place])
        return way[::-1]

    def cut_off(self, here: int) -> NDArray[np.int64]:
        """Numbers of the places to which no way leads from one."""
        return np.flatnonzero(~np.isfinite(self._shortest(here)[0]))

    def _shortest(self, here: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        costs, before = dijkstra(
            csr_array(self._lengths**LENGTH_POWER), indices=here, directed=False, return_predecessors=True
        )
        return costs, before

    def reached(self, place: int) -> None:
        """Take note that a place can be reached, whatever stands in some of the ways to it."""
        self._failures[place] = -len(self.places)

    def blocked(self, start: int, end: int) -> None:
        """Take note that there is no way from a place to its neighbour."""
        self._lengths[start, end] = self._lengths[end, start] = 0.0
        self._failures[end] += 1
        if self._failures[end] >= TRIES:
            self.given_up.add(end)
            self._lengths[end] = self._lengths[:, end] = 0.0

    def views(self, chosen: list[int], heading: float, tilt: float) -> list[int]:
        """The order in which a robot at a place looks.

        Args:
            chosen: numbers of poses, all of one place.
            heading: degrees at which it arrives, counted on and on: 360 after a whole turn.
            tilt: degrees at which its camera is.

        Returns:
            All of them: each heading with its tilts. It turns as little as it can, and, as every turn is a little too
            long or too short, to that side which undoes earlier turns.
        """
        headings = np.unique(self._poses[chosen, 2] % 360)
        best: tuple[int, float, list[float]] | None = None
        for start in headings:
            for sense in (1.0, -1.0):
                order = headings[np.argsort((sense * (headings - start)) % 360)].tolist()
                turned = signed_angle(np.diff([heading, *order]))
                candidate = (round(float(np.abs(turned).sum())), abs(heading + float(turned.sum())), order)
                best = candidate if best is None else min(best, candidate)
        assert best is not None  # a place has a heading
        ordered: list[int] = []
        for one in best[2]:
            here = [number for number in chosen if self._poses[number, 2] % 360 == one]
            here.sort(key=lambda number: self._poses[number, 3])
            if abs(self._poses[here[-1], 3] - tilt) < abs(self._poses[here[0], 3] - tilt):
                here.reverse()
            tilt = float(self._poses[here[-1], 3])
            ordered += here
        return ordered


def neighbours(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, P) metres between places that have no third one in the circle over the line between them; else 0."""
    squares = ((places[:, None] - places[None]) ** 2).sum(-1)
    lengths = np.sqrt(squares)
    for start in range(len(places)):
        between = squares[start, :, None] + squares <= squares[start] + 1e-9  # [third, end]
        np.fill_diagonal(between, False)
        between[start] = False
        lengths[start, between.any(axis=0)] = 0.0
    return lengths


def seen_from(poses: NDArray[np.float64], first: int) -> NDArray[np.float64]:
    """Poses (S, 4) as a robot sees them that stands at one: x to its right, z ahead, headings from its own."""
    seen = poses.copy()
    angle = math.radians(poses[first, 2])
    x, z = (poses[:, :2] - poses[first, :2]).T
    seen[:, 0] = x * math.cos(angle) - z * math.sin(angle)
    seen[:, 1] = x * math.sin(angle) + z * math.cos(angle)
    seen[:, 2] = (poses[:, 2] - poses[first, 2]) % 360
    return seen


def grid_poses(across: int, along: int, step: float, headings: int, tilts: tuple[float, ...]) -> NDArray[np.float64]:
    """Poses (S, 4) on a rectangular grid of places: x, z in metres from its corner, headings and tilts in degrees.

    Args:
        across: places along x, to the right of who stands in the corner and looks along the grid.
        along: places along z, ahead.
        step: metres between neighbouring places.
        headings: at each place, evenly round.
        tilts: degrees at each heading.

    Raises:
        PlacesError: if there is no such grid.
    """
    checks = {
        f"across must be in 1..100 places, got {across}": 1 <= across <= 100,
        f"along must be in 1..100 places, got {along}": 1 <= along <= 100,
        f"step must be in 0.05..10 metres, got {step:g}": 0.05 <= step <= 10,
        f"headings must be in 1..36, got {headings}": 1 <= headings <= 36,
        "tilts must be different ones in -90..90 degrees, at least one": 0 < len(set(tilts)) == len(tilts)
        and all(abs(tilt) <= 90 for tilt in tilts),
    }
    for rule, kept in checks.items():
        if not kept:
            raise PlacesError(rule)
    places = [(x * step, z * step) for x in range(across) for z in range(along)]
    return lattice_poses(np.array(places), [360 / headings * turn for turn in range(headings)], tilts).astype(float)
