"""Building a room: collecting parts under object names, and laying things out on ledges without overlaps."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.rooms.geometry import Vector
from active_perceiver.rooms.pieces import Pieces, bounds, footprint, placed
from active_perceiver.rooms.room import Part

# Things rest this far above what they lie on: touching faces would flicker and be baked black. Metres.
LIFT = 0.0008
GAP = 0.045


def stream(seed: int, label: str) -> np.random.Generator:
    """Random numbers that depend on the seed and a label only, so that changing one thing leaves the others."""
    return np.random.default_rng([seed, zlib.crc32(label.encode())])


class RoomBuilder:
    """Collects a room's parts and obstacles."""

    def __init__(self) -> None:
        self.parts: list[Part] = []
        self.obstacles: list[tuple[str, NDArray[np.float64]]] = []

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


@dataclass(frozen=True)
class Ledge:
    """A strip of a table, counter, shelf or sill on which things stand in one row, none behind another.

    Attributes:
        name: for tables of what may stand where; its first word names the piece of furniture.
        start: (x, y) of one end of its middle line, metres.
        end: (x, y) of the other end; seen from the room's side the line runs from left to right.
        height: z of its surface.
        depth: its width across the line.
    """

    name: str
    start: tuple[float, float]
    end: tuple[float, float]
    height: float
    depth: float

    @property
    def furniture(self) -> str:
        """The piece of furniture this is a part of."""
        return self.name.split()[0]

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
    """A thing to be laid out: its name, pieces (turned as it shall stand on a ledge along +x), and size on it."""

    name: str
    pieces: Pieces

    @property
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


def assign(
    items: Sequence[Item],
    ledges: Sequence[Ledge],
    allowed: Mapping[str, Sequence[str]],
    apart: Sequence[str],
    rng: np.random.Generator,
    attempts: int = 200,
) -> dict[str, list[Item]]:
    """Decides which ledge each item stands on.

    Args:
        items: what to lay out.
        ledges: where.
        allowed: names of the ledges each item may stand on.
        apart: names of items of which no two may stand on the same furniture.
        rng: random choice.
        attempts: how often to start over if the last items find no room.

    Returns:
        Ledge name -> items.

    Raises:
        RuntimeError: if no attempt found room for everything.
    """
    by_size = sorted(items, key=lambda item: (item.name not in apart, -item.width, item.name))
    by_name = {ledge.name: ledge for ledge in ledges}
    for _ in range(attempts):
        free = {ledge.name: ledge.length - GAP for ledge in ledges}
        chosen: dict[str, list[Item]] = {ledge.name: [] for ledge in ledges}
        taken: set[str] = set()
        for item in by_size:
            fitting = [
                name
                for name in allowed[item.name]
                if free[name] >= item.width + GAP
                and by_name[name].depth >= item.depth
                and not (item.name in apart and by_name[name].furniture in taken)
            ]
            if not fitting:
                break
            # Room that is left attracts: the things spread over the whole kitchen.
            weight = np.array([max(free[name], 0.0) for name in fitting]) ** 2
            name = fitting[int(rng.choice(len(fitting), p=weight / weight.sum()))]
            chosen[name].append(item)
            if item.name in apart:
                taken.add(by_name[name].furniture)
            free[name] -= item.width + GAP
        else:
            return chosen
    raise RuntimeError("no room for all objects; allow more ledges for " + ", ".join(item.name for item in by_size))


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
