"""Building a room: collecting parts under object names, and laying things out on ledges without overlaps."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.geometry.mesh import Vector
from indoor_rooms.geometry.pieces import Pieces, bounds, footprint, placed
from indoor_rooms.layouts.walls import Wall
from indoor_rooms.room import Part

# Things rest this far above what they lie on: touching faces would flicker and be baked black. Metres.
LIFT = 0.0008
GAP = 0.045


def stream(seed: int, label: str) -> np.random.Generator:
    """Random numbers that depend on the seed and a label only, so that changing one thing leaves the others."""
    return np.random.default_rng([seed, zlib.crc32(label.encode())])


class RoomBuilder:
    """Collects a room's parts and obstacles, and where its walls have no skirting board."""

    def __init__(self) -> None:
        self.parts: list[Part] = []
        self.obstacles: list[tuple[str, NDArray[np.float64]]] = []
        self._bare: dict[str, list[tuple[float, float]]] = {}

    def add(
        self,
        name: str,
        pieces: Pieces,
        offset: Vector = (0.0, 0.0, 0.0),
        turn: float = 0.0,
        obstacle: bool = False,
    ) -> None:
        """Adds pieces as (part of) an object; with `obstacle` its convex outline is where no robot can stand."""
        moved = placed(pieces, offset, turn)
        self.parts += [Part(name, mesh, material) for mesh, material in moved]
        if obstacle:
            self.obstacles.append((name, footprint(mesh for mesh, _ in moved)))

    def block(self, name: str, low: tuple[float, float], high: tuple[float, float]) -> None:
        """Adds a rectangular obstacle between two corners."""
        (x0, y0), (x1, y1) = low, high
        self.obstacles.append((name, np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])))

    def bare(self, wall: Wall, start: float, end: float) -> None:
        """A door or a fitted cabinet stands at a wall: no skirting board from `start` to `end` along it, metres."""
        self._bare.setdefault(wall.name, []).append((start, end))

    def bare_stretches(self, wall: Wall) -> list[tuple[float, float]]:
        """Where a wall has no skirting board."""
        return self._bare.get(wall.name, [])


@dataclass(frozen=True)
class Ledge:
    """A straight line on a surface along which things may stand in a row.

    Attributes:
        furniture: the piece of furniture it belongs to.
        kind: what sort of surface it is, see `things.SURFACES`.
        start: (x, y) of one end, metres.
        end: (x, y) of the other end; seen from the room's side the line runs from left to right.
        height: z of its surface.
        depth: its width across the line.
        headroom: height of what may stand on it, metres.
    """

    furniture: str
    kind: str
    start: tuple[float, float]
    end: tuple[float, float]
    height: float
    depth: float
    headroom: float = np.inf

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))

    @property
    def turn(self) -> float:
        """Degrees by which a thing whose front is -y is turned to face the room."""
        return float(np.degrees(np.arctan2(self.end[1] - self.start[1], self.end[0] - self.start[0])))


@dataclass(frozen=True)
class Item:
    """A thing to be laid out.

    Attributes:
        name: of the object.
        pieces: turned as they shall stand on a ledge along +x.
        surfaces: kinds of ledges it may stand on.
    """

    name: str
    pieces: Pieces
    surfaces: tuple[str, ...] = ()

    @cached_property
    def extent(self) -> NDArray[np.float64]:
        """(2, 3) bounds of the pieces."""
        return bounds(mesh for mesh, _ in self.pieces)

    @property
    def width(self) -> float:
        """Along the ledge, metres."""
        low, high = self.extent
        return float(high[0] - low[0])

    @property
    def depth(self) -> float:
        """Across the ledge, metres."""
        low, high = self.extent
        return float(high[1] - low[1])

    @property
    def height(self) -> float:
        """Metres."""
        low, high = self.extent
        return float(high[2] - low[2])


class NoRoomError(RuntimeError):
    """Something that has to be in a room finds no place in it."""


def assign(
    items: Sequence[Item],
    ledges: Sequence[Ledge],
    required: Sequence[str],
    rng: np.random.Generator,
    attempts: int = 60,
) -> list[list[Item]]:
    """Decides which ledge each item stands on.

    Args:
        items: what to lay out.
        ledges: where.
        required: names of the items that must be there, each on another piece of furniture than the others as long
            as there are enough of them; other items are left out if no room is left.
        rng: random choice.
        attempts: how often to start over if a required item finds no room.

    Returns:
        For each ledge its items.

    Raises:
        NoRoomError: if no attempt found room for every required item.
    """
    first = sorted((item for item in items if item.name in required), key=lambda item: (-item.width, item.name))
    others = [item for item in items if item.name not in required]
    rest = sorted(others, key=lambda item: (-item.width, item.name))
    for _ in range(attempts):
        free = [ledge.length - GAP for ledge in ledges]
        chosen: list[list[Item]] = [[] for _ in ledges]
        taken: set[str] = set()
        missing = []
        for item in (*first, *rest):
            fitting = [
                row
                for row, ledge in enumerate(ledges)
                if ledge.kind in item.surfaces
                and free[row] >= item.width + GAP
                and ledge.depth >= item.depth
                and ledge.headroom >= item.height
            ]
            if item.name in required:
                fitting = [row for row in fitting if ledges[row].furniture not in taken] or fitting
            if not fitting:
                missing.append(item.name)
                if item.name in required:
                    break
                continue
            # Room that is left attracts: the things spread over the whole room.
            weight = np.array([free[row] for row in fitting])
            row = fitting[int(rng.choice(len(fitting), p=weight / weight.sum()))]
            chosen[row].append(item)
            free[row] -= item.width + GAP
            if item.name in required:
                taken.add(ledges[row].furniture)
        if not set(missing) & set(required):
            return chosen
    raise NoRoomError(f"no room for {', '.join(missing)} on any of {len(ledges)} ledges")


def lay_out(
    items: Sequence[Item], ledge: Ledge, rng: np.random.Generator, put: Callable[[str, Pieces, Vector, float], None]
) -> None:
    """Stands items in a random order in one row on a ledge, calling `put(name, pieces, offset, turn)` for each."""
    slack = ledge.length - sum(item.width for item in items) - GAP * (len(items) + 1)
    shares = rng.dirichlet(np.full(len(items) + 1, 2.0)) * max(slack, 0.0)
    direction = np.array([ledge.end[0] - ledge.start[0], ledge.end[1] - ledge.start[1]]) / ledge.length
    backwards = np.array([-direction[1], direction[0]])
    along = 0.0
    for index, order in enumerate(rng.permutation(len(items))):
        item = items[int(order)]
        low, high = item.extent
        along += GAP + shares[index]
        play = max((ledge.depth - item.depth) / 2, 0.0)
        across = rng.uniform(-play, play) * 0.8
        middle = (low + high) / 2
        place = (
            np.asarray(ledge.start)
            + direction * (along + item.width / 2 - middle[0])
            + backwards * (across - middle[1])
        )
        put(item.name, item.pieces, (float(place[0]), float(place[1]), ledge.height + LIFT), ledge.turn)
        along += item.width
