"""The command `active-perceiver scenes capture ...`: scenes of rooms that something else draws or drives through.

As in `cli.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from active_perceiver.cli_help import help_text
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
class CaptureRoom:
    """Photographs of a generated 3D room."""

    layout: Positional[str]
    """Kind of room: kitchen, living_room or conference_room."""
    out: Path
    """The folder of photographs to write."""
    seed: int = 1
    """The room and all mistakes follow from it: the same seed gives the same photographs."""
    places: int | None = None
    """How many marks are on the floor, around the middle of the room; the layout's own number if not given."""
    targets: tuple[str, ...] = ()
    """Names of the objects that are marked and photographed alone; all in the room if not given."""
    width: int = 400
    """Width of the photographs in pixels; they are three quarters as high."""
    jitter_cm: float = 5.0
    """Each photograph is taken up to so many centimetres beside its mark, in x and in z."""
    jitter_degrees: float = 4.0
    """Each is taken up to so many degrees away from the intended heading and tilt."""
    error_cm: float = 2.0
    """Places are written down with an error of up to so many centimetres, in x and in z."""
    error_degrees: float = 2.0
    """Headings and tilts are written down with an error of up to so many degrees."""
    noise: float = 4.0
    """Standard deviation of the camera's noise where it is white, in grey levels of 255."""
    workers: int | None = None
    """Processes; all cores if not given."""
    force: bool = False
    """Replace an earlier folder of photographs, and begin anew where the work was interrupted."""
    resume: bool = False
    """Go on where the work was interrupted."""

    def run(self) -> int:
        from active_perceiver.rooms.capturing.photographs import PhotographSettings, take_photographs

        photographer = PhotographSettings(
            width=self.width, jitter_cm=self.jitter_cm, jitter_degrees=self.jitter_degrees, error_cm=self.error_cm,
            error_degrees=self.error_degrees, noise=self.noise, targets=self.targets,
        )  # fmt: skip
        count = take_photographs(
            self.layout, self.seed, self.out, photographer, places=self.places, force=self.force, resume=self.resume,
            workers=self.workers,
        )  # fmt: skip
        print(f"folder: {self.out}, {count} photographs\nto a scene: see docs/your-own-room.md")
        return 0


CaptureCommand = (
    Annotated[
        CaptureThor,
        subcommand(
            "thor",
            description=help_text(
                "Make a scene of a room of AI2-THOR (needs the `thor` extra and its simulator, see docs/ai2thor.md): "
                "the agent looks from every pose it can reach; what is finished survives an interruption.",
                "scenes capture thor FloorPlan1 --targets Mug Bread",
                "scenes capture thor FloorPlan1 --tilts -30 0 30 --out kitchen.h5 --resume",
                "scenes capture thor --scenes kitchens --targets Mug Bread --out thor_kitchens --resume",
            ),
        ),
    ]
    | Annotated[
        CaptureRoom,
        subcommand(
            "room",
            description=help_text(
                "Take photographs of a generated room as a person would (needs the `rooms` extra), imprecise and "
                "noisy, to try `scenes import photos` without a camera; what is finished survives an interruption.",
                "scenes capture room conference_room --seed 4 --targets mug bag --out photos",
                "scenes capture room kitchen --places 20 --jitter-cm 8 --noise 8 --out photos",
            ),
        ),
    ]
)


@dataclass
class ScenesCapture:
    """Make a scene of a room of AI2-THOR, or photographs of a generated room."""

    command: CaptureCommand

    def run(self) -> int:
        return self.command.run()
