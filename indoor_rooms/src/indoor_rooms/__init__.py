"""Photo-real rooms as functions of a seed, rendered on a CPU.

A room is plain data (`Room`): `make_room` furnishes one, `bake` computes its light, `render` photographs it from any
pose. What needs Embree (`bake`, `render`, `room_problems`, `studio_pictures`) is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from indoor_rooms.errors import RoomError
from indoor_rooms.free_space import free_positions
from indoor_rooms.layouts import LAYOUTS, make_room
from indoor_rooms.objects import OBJECTS
from indoor_rooms.room import Lamp, Part, Room, Sun

if TYPE_CHECKING:
    from indoor_rooms.renderer.camera import Quality, Rendering, render
    from indoor_rooms.renderer.lighting import BakedRoom, bake
    from indoor_rooms.studio.studio_pictures import studio_pictures
    from indoor_rooms.validation import room_problems

__version__ = "0.2.0"

_LAZY = {
    "BakedRoom": "indoor_rooms.renderer.lighting",
    "Quality": "indoor_rooms.renderer.camera",
    "Rendering": "indoor_rooms.renderer.camera",
    "bake": "indoor_rooms.renderer.lighting",
    "render": "indoor_rooms.renderer.camera",
    "room_problems": "indoor_rooms.validation",
    "studio_pictures": "indoor_rooms.studio.studio_pictures",
}
"""Public name -> the module that holds it."""

__all__ = [
    "BakedRoom",
    "LAYOUTS",
    "Lamp",
    "OBJECTS",
    "Part",
    "Quality",
    "Rendering",
    "Room",
    "RoomError",
    "Sun",
    "bake",
    "free_positions",
    "make_room",
    "render",
    "room_problems",
    "studio_pictures",
]


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'indoor_rooms' has no attribute '{name}'")
    return getattr(import_module(_LAZY[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_LAZY})
