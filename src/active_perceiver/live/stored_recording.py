"""What the files of a recording hold, and how it is checked when they are read; `recorder.py` explains them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated, Any, TypeVar

import msgspec
import numpy as np
from msgspec import Meta, Struct

from active_perceiver.live.recorder import FRAME_NAME, FRAMES
from active_perceiver.live.recording_header import Floor, RecordingHeader
from active_perceiver.scenes import Action, FloorPlan
from active_perceiver.utils.stored_names import RECORDING, current_names

LARGEST = 1e12
"""No number in a recording is as large; neither is NaN."""

Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
Seconds = Annotated[float, Meta(ge=0, le=LARGEST)]
Points = Annotated[list[tuple[Number, Number]], Meta(min_length=1)]

Stored = TypeVar("Stored")


class StoredFloor(Struct):
    """The room from above: x, z in metres."""

    places: Points
    outline: Points | None
    obstacles: list[tuple[str, Points]]


class StoredHeader(Struct):
    """What of the header is stored otherwise than `RecordingHeader` has it, or in a range; null minutes: no limit."""

    max_steps: Annotated[int, Meta(ge=1)]
    max_minutes: Annotated[float, Meta(gt=0, le=LARGEST)] | None
    floor: StoredFloor | None


class StoredLook(Struct):
    """One look, a line of the log; the score and the box are null where nothing was seen."""

    look: int
    frame: Annotated[str, Meta(pattern=rf"^{FRAMES}/{FRAME_NAME.pattern}\Z")]
    seconds: Seconds
    pose: tuple[Number, Number, Number, Number] | None
    moved: bool | None
    action: Action
    found: bool
    score: Number | None
    box: tuple[Number, Number, Number, Number] | None
    probabilities: list[Number]


class StoredEnd(Struct):
    """How the search ended, the last line of the log."""

    found: bool
    reason: str
    seconds: Seconds


def checked(data: Any, kind: type[Stored]) -> Stored:
    """What was read from JSON, as what it should be; what else is in it is left out.

    Raises:
        ValueError: if something is missing, of a wrong type or out of range; the message says what.
    """
    try:
        return msgspec.convert(data, kind)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from None


def read_header(data: dict[str, Any]) -> RecordingHeader:
    """The header from what `RecordingHeader.as_json` gave, in this version or an earlier one.

    Raises:
        ValueError: see `checked`.
    """
    data = {name: whole_characters(value) for name, value in current_names(data, RECORDING).items()}
    stored = checked(data, StoredHeader)
    minutes = math.inf if stored.max_minutes is None else stored.max_minutes
    header = checked({**data, "max_minutes": minutes, "floor": None}, RecordingHeader)
    return header if stored.floor is None else replace(header, floor=_floor(stored.floor))


def whole_characters(value: Any) -> Any:
    """A text without halves of characters, which JSON can hold and no page can; anything else as it is."""
    return value.encode(errors="replace").decode() if isinstance(value, str) else value


def _floor(stored: StoredFloor) -> Floor:
    plan = None
    if stored.outline is not None:
        obstacles = tuple((label, np.array(polygon)) for label, polygon in stored.obstacles)
        plan = FloorPlan(np.array(stored.outline), obstacles)
    return Floor(np.array(stored.places), plan)
