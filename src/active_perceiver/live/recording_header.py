"""What a search was asked to do, and where: what a recording and a report say of it besides what was seen."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes import Action, FloorPlan
from active_perceiver.scenes.floor_plan import HasFloorPlan


@dataclass(frozen=True, eq=False)
class Floor:
    """A room from above, all that figures need of it; a recording keeps it, so that it needs no scene file.

    Attributes:
        places: (P, 2) x, z in metres of where a robot can stand.
        floor_plan: walls and obstacles, if known.
    """

    places: NDArray[np.float64]
    floor_plan: FloorPlan | None = None

    @property
    def poses(self) -> NDArray[np.float64]:
        """(P, 4), a pose at each place; heading and tilt mean nothing."""
        return np.hstack([self.places, np.zeros_like(self.places)])

    @classmethod
    def of(cls, room: HasFloorPlan) -> Floor:
        """The floor of a scene."""
        return cls(np.unique(np.round(room.poses[:, :2].astype(float), 3), axis=0), room.floor_plan)

    def as_json(self) -> dict[str, Any]:
        """Plain data, as `stored_recording.py` reads it."""
        plan = self.floor_plan
        return {
            "places": self.places.tolist(),
            "outline": None if plan is None else plan.outline.tolist(),
            "obstacles": [] if plan is None else [[label, polygon.tolist()] for label, polygon in plan.obstacles],
        }


@dataclass(frozen=True)
class RecordingHeader:
    """What a search was asked to do.

    Attributes:
        picture: name of the file that shows what is searched.
        agent: folder of the agent, as it was given.
        robot: as it was given, such as "scene:kitchen_1".
        place: name of the scene or room.
        start: where the robot began, in words.
        scene: policy branch that was asked for, if any.
        actions: those of the policy, in the order of the probabilities.
        max_steps: limit, actions (of a dry run, looks).
        max_minutes: limit, may be infinite.
        seed: the agent's draws follow from it; None for none.
        confirm: whether two views had to agree for found.
        explore: whether the agent was to look round the room when lost.
        dry_run: whether it only looked and decided.
        started: date and time, ISO 8601 with its zone.
        software: its version.
        floor: the room from above, if known.
    """

    picture: str
    agent: str
    robot: str
    place: str
    start: str
    scene: str | None
    actions: tuple[Action, ...]
    max_steps: int
    max_minutes: float
    seed: int | None
    confirm: bool
    explore: bool
    dry_run: bool
    started: str
    software: str
    floor: Floor | None = field(default=None, repr=False)

    @property
    def label(self) -> str:
        """What is searched, for people."""
        return Path(self.picture).stem

    def as_json(self) -> dict[str, Any]:
        """Plain data, as `stored_recording.py` reads it."""
        return {
            **{entry.name: getattr(self, entry.name) for entry in fields(self)},
            "actions": [action.value for action in self.actions],
            "max_minutes": self.max_minutes if math.isfinite(self.max_minutes) else None,
            "floor": None if self.floor is None else self.floor.as_json(),
        }
