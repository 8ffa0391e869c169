"""Searching a known room for a target that is not where it was."""

from active_perceiver.exploring.explorer import Explorer
from active_perceiver.exploring.room_map import RoomMap, map_file

__all__ = ["Explorer", "RoomMap", "map_file"]
