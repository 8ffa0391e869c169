"""The four walls of a room with coordinates of their own, and what already stands where, seen from above."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from indoor_rooms.geometry.mesh import Vector

Rectangle: TypeAlias = tuple[float, float, float, float]
"""x from, y from, x to, y to; metres."""

# Furniture along a wall stands this far from it, in front of the skirting board.
WALL_GAP = 0.02
TRIES = 60


@dataclass(frozen=True)
class Wall:
    """One wall, seen by somebody who faces it from inside the room.

    Attributes:
        name: "north" (+y), "east" (+x), "south" or "west".
        length: metres.
        left: x, y of its left end.
        turn: degrees by which a thing whose front is -y is turned to have its back to this wall.
    """

    name: str
    length: float
    left: tuple[float, float]
    turn: float

    def point(self, along: float, out: float = 0.0, height: float = 0.0) -> Vector:
        """A point `along` metres from the left end, `out` metres into the room."""
        cos, sin = np.cos(np.radians(self.turn)), np.sin(np.radians(self.turn))
        return (
            float(self.left[0] + cos * along + sin * out),
            float(self.left[1] + sin * along - cos * out),
            height,
        )

    def rectangle(self, along: float, width: float, out: float, depth: float) -> Rectangle:
        """The floor under something `width` wide with its middle at `along`, from `out` to `out + depth`."""
        first, second = self.point(along - width / 2, out), self.point(along + width / 2, out + depth)
        return (
            min(first[0], second[0]),
            min(first[1], second[1]),
            max(first[0], second[0]),
            max(first[1], second[1]),
        )


def four_walls(width: float, depth: float) -> dict[str, Wall]:
    """The walls of a room of `width` (x) by `depth` (y) metres, by name."""
    return {
        "north": Wall("north", width, (0.0, depth), 0.0),
        "east": Wall("east", depth, (width, depth), -90.0),
        "south": Wall("south", width, (width, 0.0), 180.0),
        "west": Wall("west", depth, (0.0, 0.0), 90.0),
    }


class FloorLayout:
    """What stands where. Everything random about it comes from the generator that is given.

    Args:
        width: of the room along x, metres.
        depth: of the room along y, metres.
    """

    def __init__(self, width: float, depth: float) -> None:
        self.width, self.depth = width, depth
        self.walls = four_walls(width, depth)
        self._floor: list[Rectangle] = []
        self._hung: dict[str, list[tuple[float, float]]] = {name: [] for name in self.walls}

    def take(self, rectangle: Rectangle) -> None:
        """Nothing else may stand here."""
        self._floor.append(rectangle)

    def fits(self, rectangle: Rectangle, gap: float = 0.0) -> bool:
        """Whether a rectangle lies in the room and at least `gap` from all that is taken."""
        x0, y0, x1, y1 = rectangle
        if min(x0, y0) < 0 or x1 > self.width or y1 > self.depth:
            return False
        return all(
            x1 + gap <= a0 or a1 + gap <= x0 or y1 + gap <= b0 or b1 + gap <= y0 for a0, b0, a1, b1 in self._floor
        )

    def against(
        self,
        wall: Wall,
        width: float,
        depth: float,
        rng: np.random.Generator,
        *,
        gap: float = 0.05,
        tall: bool = False,
    ) -> float | None:
        """Find and take a place for furniture along a wall.

        Args:
            wall: with its back to which it stands.
            width: along the wall, metres.
            depth: into the room, metres; it begins `WALL_GAP` from the wall.
            rng: chooses among the places.
            gap: from other furniture, metres.
            tall: whether it covers what hangs there, so that it needs and takes the wall above too.

        Returns:
            Its middle along the wall, or None if no place was found.
        """
        low, high = 0.03 + width / 2, wall.length - 0.03 - width / 2
        if low > high:
            return None
        for along in rng.uniform(low, high, TRIES).tolist():
            rectangle = wall.rectangle(along, width, WALL_GAP, depth)
            if self.fits(rectangle, gap) and not (tall and not self._free_above(wall, along, width, gap)):
                self.take(rectangle)
                if tall:
                    self.hang(wall, along, width)
                return along
        return None

    def somewhere(
        self, walls: Sequence[Wall], width: float, depth: float, rng: np.random.Generator, *, tall: bool = False
    ) -> tuple[Wall, float] | None:
        """Like `against`, trying some walls in a random order: the wall and the place along it, or None."""
        for index in rng.permutation(len(walls)):
            wall = walls[int(index)]
            along = self.against(wall, width, depth, rng, tall=tall)
            if along is not None:
                return wall, along
        return None

    def hang(self, wall: Wall, along: float, width: float) -> None:
        """A stretch of the wall above furniture is taken, by a window, a picture, a tall case."""
        self._hung[wall.name].append((along - width / 2, along + width / 2))

    def hanging_place(
        self,
        wall: Wall,
        width: float,
        rng: np.random.Generator,
        gap: float = 0.12,
        out: float = 0.0,
    ) -> float | None:
        """Find and take a stretch of a wall above furniture; its middle, or None.

        Args:
            wall: on which it hangs.
            width: metres.
            rng: chooses among the places.
            gap: from what hangs there, metres.
            out: how far it reaches into the room where nothing may stand below it, metres.
        """
        if width + 0.2 > wall.length:
            return None
        for along in rng.uniform(0.1 + width / 2, wall.length - 0.1 - width / 2, TRIES).tolist():
            below = wall.rectangle(along, width, 0.0, out)
            if self._free_above(wall, along, width, gap) and (out == 0 or self.fits(below)):
                self.hang(wall, along, width)
                return along
        return None

    def in_the_open(
        self, width: float, depth: float, rng: np.random.Generator, gap: float = 0.6
    ) -> tuple[float, float] | None:
        """Find a place (x, y of its middle) for something free-standing, `gap` from everything, or None.

        It is not taken yet: what stands around it may need more room.
        """
        margin_x, margin_y = width / 2 + gap, depth / 2 + gap
        if 2 * margin_x > self.width or 2 * margin_y > self.depth:
            return None
        for _ in range(TRIES):
            x, y = rng.uniform(margin_x, self.width - margin_x), rng.uniform(margin_y, self.depth - margin_y)
            if self.fits((x - width / 2, y - depth / 2, x + width / 2, y + depth / 2), gap):
                return float(x), float(y)
        return None

    def _free_above(self, wall: Wall, along: float, width: float, gap: float) -> bool:
        low, high = along - width / 2 - gap, along + width / 2 + gap
        return all(high <= start or end <= low for start, end in self._hung[wall.name])
