"""The command `active-perceiver scenes capture ...`: scenes of rooms that something else draws or drives through.

As in `cli/main.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from active_perceiver.cli.help import help_text
from active_perceiver.cli.interrupts import stopped_like_interrupted
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
        from active_perceiver.capture.thor import ThorCapture
        from active_perceiver.capture.thor_scenes import Captured, capture_room, capture_rooms, rooms_of
        from active_perceiver.robots.ai2thor import ThorConfig

        if (self.room is None) == (self.scenes is None):
            raise UserError("give the name of a room, FloorPlan1 for example, or --scenes kitchens, one of the two")
        settings = ThorConfig(self.grid, self.headings, self.tilts, self.image_size, self.fov)
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
        from active_perceiver.capture.rendered.config import layout_config
        from active_perceiver.capture.rendered.photographs import PhotographConfig, take_photographs
        from active_perceiver.parallel.process_pool import ProcessExecutor

        photographer = PhotographConfig(
            width=self.width, jitter_cm=self.jitter_cm, jitter_degrees=self.jitter_degrees, error_cm=self.error_cm,
            error_degrees=self.error_degrees, noise=self.noise, targets=self.targets,
        )  # fmt: skip
        count = take_photographs(
            self.layout, self.seed, self.out, photographer, force=self.force, resume=self.resume,
            executor=ProcessExecutor(self.workers), settings=layout_config(self.layout, places=self.places),
        )  # fmt: skip
        print(f"folder: {self.out}, {count} photographs\nto a scene: see docs/your-own-room.md")
        return 0


@dataclass
class CaptureRobot:
    """Photographs that a robot takes."""

    robot: Positional[str]
    """ros:ws://HOST:PORT for a robot behind rosbridge, or room:NAME for a simulated TurtleBot in a rendered room."""
    places: Path
    """Table of the poses, file,x,z,heading,tilt as poses.csv in docs/your-own-room.md; without names of files the
    photographs are called IMG_0001.jpg and so on."""
    out: Path
    """The folder of photographs to write."""
    robot_config: str | None = None
    """What a ros robot is like: turtlebot2, turtlebot3, turtlebot4, or a YAML file."""
    start: int | None = None
    """State of the rendered room at which the simulated TurtleBot stands at first; 0 if not given."""
    at: str | None = None
    """Name of the photograph at whose pose the robot stands now; the first of the table if not given."""
    at_once: int | None = None
    """End after so many places, at the next one: put the robot exactly on that mark by hand, and go on with --resume
    --at, so that what its odometry gets wrong does not add up."""
    seed: int | None = None
    """What is random about the simulated TurtleBot follows from it."""
    force: bool = False
    """Take all photographs of an earlier capture anew."""
    resume: bool = False
    """Take those that are missing; the robot must stand at the first pose again, or that of --at."""

    def run(self) -> int:
        from active_perceiver.capture.robot import photograph_places
        from active_perceiver.datasets.photos.pose_table import read_poses
        from active_perceiver.live.robot_factory import robot_at
        from active_perceiver.robots import NavigatingRobot
        from active_perceiver.scenes import TURTLEBOT_ACTIONS

        kind = self.robot.partition(":")[0]
        if kind not in ("room", "ros"):
            raise UserError(
                f"'{self.robot}' cannot drive to poses; give ros:ws://HOST:PORT, or room:NAME for a simulated one"
            )
        table = read_poses(self.places, naming=True)
        if kind == "room" and self.start is None and self.at not in (None, table.files[0]):
            raise UserError(f"say with --start at which state of the room the robot stands for {self.at}")
        start = 0 if kind == "room" and self.start is None else self.start
        place = robot_at(self.robot, lambda name: TURTLEBOT_ACTIONS, start, self.seed, self.robot_config)
        assert isinstance(place.robot, NavigatingRobot)  # of these kinds all are
        print(f"the robot stands at {place.start}; that is taken for the pose of {self.at or table.files[0]}")
        with stopped_like_interrupted(), place.robot as robot:
            done = photograph_places(
                robot, table, self.out, at=self.at, at_once=self.at_once, force=self.force, resume=self.resume
            )
        print(f"folder: {self.out}, {done.there} of {len(table.files)} photographs, {done.taken} of them taken now")
        if done.blocked:
            print(
                f"no way was found to the places of {len(done.blocked)}: {_some(done.blocked)}; if the robot can "
                "stand there, put it on one of their marks, and go on with --resume --at and the photograph's name"
            )
        if done.next is not None:
            name, (x, z, heading, _) = table.files[done.next], table.poses[done.next]
            print(
                f"{len(done.left)} are still to be taken: put the robot exactly to x {x:g} m, z {z:g} m, heading "
                f"{heading:g}, near which it stands, and go on with --resume --at {name}"
            )
        else:
            print(
                "the robot is back where it began: so far as it is beside its mark now, the last photographs were "
                f"beside theirs\nnext: pictures of the objects in {self.out / 'targets'}, see docs/your-own-room.md"
            )
        return 0


@dataclass
class CaptureGrid:
    """The table of poses of a rectangular grid of places."""

    across: int
    """Places from left to right, along x."""
    along: int
    """Places ahead, along z."""
    out: Path
    """The table to write, poses.csv for example."""
    step: float = 0.75
    """Metres between neighbouring places."""
    headings: int = 4
    """How many headings at each place, evenly round."""
    tilts: tuple[float, ...] = (-25.0, 0.0)
    """Degrees at each heading, up positive."""
    force: bool = False
    """Replace an existing table."""

    def run(self) -> int:
        from active_perceiver.capture.tour import grid_poses
        from active_perceiver.datasets.photos.pose_table import photograph_name, write_poses
        from active_perceiver.utils.files import replacing

        poses = grid_poses(self.across, self.along, self.step, self.headings, self.tilts)
        with replacing(self.out, self.force) as temporary:
            write_poses(temporary, [photograph_name(number) for number in range(1, len(poses) + 1)], poses)
        print(
            f"table: {self.out}, {self.across * self.along} places, {len(poses)} poses; take out those where the "
            "robot cannot stand"
        )
        return 0


def _some(names: Sequence[str], most: int = 8) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


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
    | Annotated[
        CaptureRobot,
        subcommand(
            "robot",
            description=help_text(
                "Let a robot drive to the poses of a table and take the photographs, for `scenes import photos` "
                "(needs the `ros` or the `rooms` extra). It must stand at the first pose, or at that of --at. Ctrl-C "
                "stops it; what was taken is kept.",
                "scenes capture robot ros:ws://HOST:9090 --robot-config turtlebot2 --places poses.csv --out photos",
                "scenes capture robot room:conference_room --places poses.csv --out photos",
            ),
        ),
    ]
    | Annotated[
        CaptureGrid,
        subcommand(
            "grid",
            description=help_text(
                "Write the poses of a rectangular grid of places, the first in its left near corner and looking "
                "along it, as `scenes capture robot` wants them.",
                "scenes capture grid --across 4 --along 5 --step 0.75 --headings 4 --tilts -25 0 --out poses.csv",
            ),
        ),
    ]
)


@dataclass
class ScenesCapture:
    """Make a scene of a room of AI2-THOR, or photographs of a generated room or with a robot."""

    command: CaptureCommand

    def run(self) -> int:
        return self.command.run()
