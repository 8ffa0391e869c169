"""Looking at rooms before they are photographed."""

from __future__ import annotations

import numpy as np
import pytest

from box_room import box_room
from indoor_rooms.free_space import FreeSpaceError
from indoor_rooms.layouts import LayoutError
from indoor_rooms.preview import Look, look_at_rooms, preview, preview_sheet


def look(name: str, problems: tuple[str, ...] = (), views: int = 2, size: int = 40) -> Look:
    return Look(name, list(problems), 20, 60, [np.full((size, size, 3), 90, np.uint8)] * views)


def test_pictures_are_taken_from_different_corners() -> None:
    pictures = preview(box_room(), 2, 32, rays=4)
    assert [picture.shape for picture in pictures] == [(32, 32, 3)] * 2
    assert np.abs(pictures[0].astype(int) - pictures[1]).mean() > 5
    np.testing.assert_array_equal(pictures[0], preview(box_room(), 1, 32, rays=4)[0])


def test_a_room_without_a_place_is_explained() -> None:
    room = box_room()
    block = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    with pytest.raises(FreeSpaceError):
        preview(type(room)(**{**vars(room), "obstacles": (("block", block),)}), 1, 16, rays=1)


def test_generated_rooms_are_looked_at_in_their_order() -> None:
    looks = look_at_rooms(("kitchen",), (1, 2))
    assert [item.name for item in looks] == ["kitchen_1", "kitchen_2"]
    assert all(item.problems == [] and item.places >= 30 and item.pictures == [] for item in looks)
    with pytest.raises(LayoutError, match="castle"):
        look_at_rooms(("castle",), (1,))


def test_the_sheet_holds_all_rooms() -> None:
    sheet = preview_sheet([look(f"room_{number}") for number in range(4)], columns=3)
    assert sheet.width > 3 * 80
    assert sheet.height > 2 * 40
    assert (np.asarray(sheet) == 90).all(axis=2).sum() == 4 * 2 * 40 * 40
