"""Searching a known room for a target that is not where it was."""

from active_perceiver.agent.exploration.explorer import Explorer
from active_perceiver.agent.exploration.view_map import ViewMap, map_file

__all__ = ["Explorer", "ViewMap", "map_file"]
