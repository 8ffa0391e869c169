"""The rooms there are: LAYOUTS maps a layout's name to the function that makes it from a seed."""

from __future__ import annotations

from collections.abc import Callable

from active_perceiver.errors import UserError
from active_perceiver.rooms.kitchen import kitchen
from active_perceiver.rooms.room import Room


class LayoutError(UserError, ValueError):
    """A room that cannot be made."""


LAYOUTS: dict[str, Callable[[int], Room]] = {"kitchen": kitchen}


def make_room(layout: str, seed: int = 1) -> Room:
    """A furnished room.

    Args:
        layout: a name in LAYOUTS.
        seed: at least 1; each seed is another room of that layout.

    Raises:
        LayoutError: if there is no such layout, or the seed is below 1.
    """
    if layout not in LAYOUTS:
        raise LayoutError(f"there is no room layout '{layout}'; choose one of: {', '.join(sorted(LAYOUTS))}")
    if seed < 1:
        raise LayoutError(f"a room's seed must be at least 1, not {seed}")
    return LAYOUTS[layout](seed)
