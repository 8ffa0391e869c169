"""What a search was asked to do, and where: what a recording and a report say of it besides what was seen."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes import Action, FloorPlan
from active_perceiver.scenes.floor_plan import HasFloorPlan
from active_perceiver.utils.stored_names import RECORDING, current_names

# No number in a recording is as large.
_LARGEST = 1e12


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
        """Plain data, see `from_json`."""
        plan = self.floor_plan
        return {
            "places": self.places.tolist(),
            "outline": None if plan is None else plan.outline.tolist(),
            "obstacles": [] if plan is None else [[label, polygon.tolist()] for label, polygon in plan.obstacles],
        }

    @classmethod
    def from_json(cls, data: Any) -> Floor:
        """Read what `as_json` gave.

        Raises:
            ValueError: if it is anything else.
        """
        if not isinstance(data, dict) or not isinstance(data.get("obstacles"), list):
            raise ValueError("the floor is no object with places, outline and obstacles")
        obstacles = []
        for obstacle in data["obstacles"]:
            if not isinstance(obstacle, list) or len(obstacle) != 2 or not isinstance(obstacle[0], str):
                raise ValueError("an obstacle of the floor is not a name and a polygon")
            obstacles.append((obstacle[0], _points(obstacle[1], "an obstacle of the floor")))
        outline = data.get("outline")
        plan = None if outline is None else FloorPlan(_points(outline, "the floor's outline"), tuple(obstacles))
        return cls(_points(data.get("places"), "the floor's places"), plan)


def _points(data: Any, what: str) -> NDArray[np.float64]:
    if not isinstance(data, list) or not data or not all(is_numbers(point, 2) for point in data):
        raise ValueError(f"{what} is not a list of x, z in metres")
    return np.array(data, float)


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
        """Plain data, see `from_json`."""
        return {
            **{entry.name: getattr(self, entry.name) for entry in fields(self)},
            "actions": [action.value for action in self.actions],
            "max_minutes": self.max_minutes if math.isfinite(self.max_minutes) else None,
            "floor": None if self.floor is None else self.floor.as_json(),
        }

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> RecordingHeader:
        """Read what `as_json` gave; what else is in it is left out.

        Raises:
            ValueError: if something is missing or of a wrong type; the message says what.
        """
        data = current_names(data, RECORDING)
        names = [entry.name for entry in fields(cls)]
        if missing := [name for name in names if name not in data]:
            raise ValueError(f"{', '.join(missing)} is missing")
        for name in names:
            right, what = _TYPES.get(name, (_is_text, "a text"))
            if not right(data[name]):
                raise ValueError(f"{name} is not {what}")
        # JSON can hold halves of characters, which no page can.
        given: dict[str, Any] = {
            name: value.encode(errors="replace").decode() if isinstance(value := data[name], str) else value
            for name in names
        }
        given["actions"] = tuple(Action(name) for name in data["actions"])
        given["max_minutes"] = math.inf if data["max_minutes"] is None else float(data["max_minutes"])
        given["floor"] = None if data["floor"] is None else Floor.from_json(data["floor"])
        return cls(**given)


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_whole(value: Any) -> bool:
    return type(value) is int


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and -_LARGEST < value < _LARGEST  # neither NaN nor a whole number without end


def is_numbers(value: Any, count: int) -> bool:
    """Whether a value read from JSON is a list of so many finite numbers."""
    return isinstance(value, list) and len(value) == count and all(_is_number(item) for item in value)


def is_flag(value: Any) -> bool:
    """Whether a value read from JSON is true or false."""
    return type(value) is bool


def is_duration(value: Any) -> bool:
    """Whether a value read from JSON is a number, not negative."""
    return _is_number(value) and value >= 0


def is_actions(value: Any) -> bool:
    """Whether a value read from JSON is a list of actions' names."""
    known = {action.value for action in Action}
    return isinstance(value, list) and bool(value) and all(_is_text(name) and name in known for name in value)


_TYPES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "scene": (lambda value: value is None or _is_text(value), "a text or null"),
    "actions": (is_actions, f"a list of actions, of {', '.join(action.value for action in Action)}"),
    "max_steps": (lambda value: _is_whole(value) and value >= 1, "a whole number from 1 on"),
    "max_minutes": (lambda value: value is None or (_is_number(value) and value > 0), "a number above 0 or null"),
    "seed": (lambda value: value is None or _is_whole(value), "a whole number or null"),
    "confirm": (is_flag, "true or false"),
    "explore": (is_flag, "true or false"),
    "dry_run": (is_flag, "true or false"),
    "floor": (lambda value: value is None or isinstance(value, dict), "an object or null"),
}
