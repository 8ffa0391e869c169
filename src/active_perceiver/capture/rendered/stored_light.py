"""A room's light as arrays that a store keeps: baking it takes longer than reading it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.config import CaptureError
from indoor_rooms.renderer.compiled import Surfaces
from indoor_rooms.renderer.lighting import BakedRoom
from indoor_rooms.room import Room

# The surfaces follow from the room.
LIGHT_FIELDS = tuple(field.name for field in fields(BakedRoom) if field.name not in ("room", "surfaces"))


def light_arrays(baked: BakedRoom) -> dict[str, NDArray[Any]]:
    """A room's light as arrays for a store."""
    return {name: np.asarray(getattr(baked, name)) for name in LIGHT_FIELDS}


def lit_room(room: Room, surfaces: Surfaces, arrays: Mapping[str, NDArray[Any]]) -> BakedRoom:
    """A room with the light that `light_arrays` kept.

    Raises:
        CaptureError: if it is the light of another room.
    """
    if len(arrays["total"]) != len(surfaces.positions):
        raise CaptureError(f"what is kept is not the light of room '{room.name}'; begin anew with --force")
    light: dict[str, Any] = {name: arrays[name] for name in LIGHT_FIELDS}
    return BakedRoom(
        room=room, surfaces=surfaces, **{name: value if value.ndim else value.item() for name, value in light.items()}
    )
