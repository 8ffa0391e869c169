"""Active Object Perceiver: give a robot a picture of an object; it searches the room and draws a box on it.

An implementation of Ye, Lin, Li, Zheng, Yang, "Active Object Perceiver: Recognition-guided Policy Learning for
Object Searching on Mobile Robots", IROS 2018 (https://arxiv.org/abs/1807.11174).

The names of `__all__` are what most programs need. Importing this package imports nothing but its version: each name
is loaded when it is first asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from active_perceiver.version import __version__

if TYPE_CHECKING:  # the same names, for type checkers and editors
    from active_perceiver.agent.perceiver import ActivePerceiver as ActivePerceiver
    from active_perceiver.envs import SearchEnv as SearchEnv
    from active_perceiver.live import SearchConfig as SearchConfig
    from active_perceiver.live import search as search
    from active_perceiver.robots import RecordedRobot as RecordedRobot
    from active_perceiver.scenes import Scene as Scene
    from active_perceiver.scenes import open_scene as open_scene
    from active_perceiver.scenes import read_image as read_image

_HOMES = {
    "ActivePerceiver": "agent.perceiver",
    "RecordedRobot": "robots",
    "Scene": "scenes",
    "SearchConfig": "live",
    "SearchEnv": "envs",
    "open_scene": "scenes",
    "read_image": "scenes",
    "search": "live",
}
"""Name -> the module that it is loaded from."""

__all__ = ["__version__", *_HOMES]

if not TYPE_CHECKING:  # or type checkers would take any name for one that is there

    def __getattr__(name: str) -> object:
        """Load a name of `__all__` when it is first asked for (PEP 562)."""
        if name not in _HOMES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        """What there is, loaded or not."""
        return sorted({*globals(), *_HOMES})
