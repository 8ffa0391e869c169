"""The command `active-perceiver scenes capture ...`: scenes of rooms that something else draws or drives through.

As in `cli.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tyro.conf import OmitArgPrefixes, Positional

from active_perceiver.errors import UserError


@dataclass
class CaptureThor:
    """A room of AI2-THOR."""

    room: Positional[str | None] = None
    """AI2-THOR's name of the room, FloorPlan1 for example."""
    scenes: Literal["kitchens", "living_rooms", "bedrooms", "bathrooms"] | None = None
    """Instead of a room: all 30 of a kind."""
    out: Path | None = None
    """The scene file to write, ROOM.h5 if not given; with --scenes the folder for them, here if not given."""
    grid: float = 0.25
    """Metres between neighbouring places."""
    headings: float = 90.0
    """Degrees between neighbouring headings, 90 or 45."""
    tilts: tuple[float, ...] = (-30.0, 0.0, 30.0)
    """Degrees, up positive; the agent can do -60 to 30."""
    targets: tuple[str, ...] = ()
    """AI2-THOR's types of the objects, Mug for example; all that can be picked up if not given. Of several objects of
    a type each is a target: Mug_1, Mug_2."""
    image_size: int = 300
    """Side of the views in pixels."""
    fov: float = 75.0
    """Field of view in degrees."""
    force: bool = False
    """Replace what is there, and begin anew where a capture was interrupted."""
    resume: bool = False
    """Go on where a capture was interrupted; with --scenes also leave files that are done as they are."""

    def run(self) -> int:
        from active_perceiver.capturing.thor import ThorCapture
        from active_perceiver.capturing.thor_scenes import Captured, capture_room, capture_rooms, rooms_of
        from active_perceiver.robots.ai2thor import ThorSettings

        if (self.room is None) == (self.scenes is None):
            raise UserError("give the name of a room, FloorPlan1 for example, or --scenes kitchens, one of the two")
        settings = ThorSettings(self.grid, self.headings, self.tilts, self.image_size, self.fov)
        if self.room is not None:
            path = self.out or Path(f"{self.room}.h5")
            captured = capture_room(
                self.room, path, settings, types=self.targets, force=self.force, resume=self.resume
            )
            done: Iterable[tuple[Path, Captured]] = [(path, captured)]
        else:
            done = capture_rooms(
                rooms_of(self.scenes or "kitchens"), self.out or Path(), settings, types=self.targets,
                force=self.force, resume=self.resume,
            )  # fmt: skip
        for path, result in done:
            if not isinstance(result, ThorCapture):
                print(f"scene: {path}\nwas there" if result is None else f"left out: {path}\n{result}")
                continue
            views, targets = len(result.scene), len(result.scene.targets)
            print(f"scene: {path}\n{views} views, {result.failed} poses out of reach, {targets} targets")
            for note in result.notes:
                print(note)
        return 0


@dataclass
class ScenesCapture:
    """Make a scene of a room that something else draws."""

    what: Positional[Literal["thor"]]
    """By what: thor is AI2-THOR (needs the `thor` extra)."""
    thor: OmitArgPrefixes[CaptureThor]

    def run(self) -> int:
        return self.thor.run()
