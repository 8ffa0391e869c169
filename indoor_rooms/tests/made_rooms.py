"""Rooms that several tests look at, each made once: the tests about a layout are in one xdist group."""

from __future__ import annotations

from functools import cache

import pytest

from indoor_rooms import make_room
from indoor_rooms.room import Room


@cache
def made_room(layout: str, seed: int) -> Room:
    """The room of a seed. It is shared: look at it, and change nothing."""
    return make_room(layout, seed)


def together(layout: str) -> pytest.MarkDecorator:
    """Marks a parameter whose tests need rooms of a layout, so that they run where these have been made."""
    return pytest.mark.xdist_group(f"rooms of {layout}")
