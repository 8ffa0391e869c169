"""The room seen from above: walls, what stands on the floor, where a robot can be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class FloorPlan:
    """The room seen from above, for figures.

    Attributes:
        outline: (K, 2) x, z in metres, the walls.
        obstacles: (label, (K, 2) polygon) pairs, what stands in the room.
    """

    outline: NDArray[np.float64]
    obstacles: tuple[tuple[str, NDArray[np.float64]], ...] = ()


class HasFloorPlan(Protocol):
    """What is drawn of a room; a `Scene` has it."""

    @property
    def poses(self) -> NDArray[np.floating]:
        """(S, 4): x, z in metres of where a robot can stand; heading and tilt."""
        ...

    @property
    def floor_plan(self) -> FloorPlan | None:
        """Walls and obstacles, if known."""
        ...
