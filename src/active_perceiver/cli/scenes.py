"""The commands `active-perceiver scenes ...`: what scenes there are, are they sound, make one.

As in `cli/main.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, subcommand

from active_perceiver.cli.capture import ScenesCapture
from active_perceiver.cli.help import help_text
from active_perceiver.cli.importing import ScenesExport, ScenesImport, print_problems
from active_perceiver.cli.label import ScenesLabel
from active_perceiver.errors import UserError


@dataclass
class ScenesList:
    """The bundled scenes."""

    def run(self) -> int:
        from active_perceiver.scenes import bundled_names, open_scene

        for name in bundled_names():
            scene = open_scene(name)
            print(f"{name:<16} {len(scene):>5} views  {len(scene.actions)} actions  {len(scene.targets)} targets")
        return 0


@dataclass
class ScenesInfo:
    """What a scene holds."""

    scene: Positional[str]
    """Bundled name or file."""
    picture: Path | None = None
    """Write a contact sheet with the floor plan and goal states here (PNG or JPEG)."""
    force: bool = False
    """Replace an existing picture."""

    def run(self) -> int:
        from active_perceiver.reports.scene_report import describe, write_contact_sheet
        from active_perceiver.scenes import open_scene

        scene = open_scene(self.scene)
        print(describe(scene))
        if self.picture is not None:
            write_contact_sheet(scene, self.picture, force=self.force)
            print(f"contact sheet: {self.picture}")
        return 0


@dataclass
class ScenesCheck:
    """What is wrong with a scene, and what that means."""

    scene: Positional[str]
    """Bundled name or file."""

    def run(self) -> int:
        from active_perceiver.scenes import open_scene

        return print_problems(open_scene(self.scene))


@dataclass
class ScenesRender:
    """Make scenes from generated 3D rooms."""

    layout: Positional[str]
    """Kind of room: kitchen, living_room or conference_room."""
    seed: int = 1
    """The room follows from it: the same seed gives the same scene."""
    count: int | None = None
    """Make so many rooms, of this seed and those after it."""
    hour: str | None = None
    """The same room at another hour: morning, noon, afternoon, low sun, overcast or dusk; left to the seed if not
    given."""
    moved: int | None = None
    """The same room with the same things lying elsewhere; each number (1, 2, ...) is another arrangement."""
    out: Path | None = None
    """The scene file to write, LAYOUT_SEED.h5 if not given (LAYOUT_SEED_hour_dusk.h5, LAYOUT_SEED_moved_1.h5); with
    --count the folder for them, here if not given."""
    image_size: int | None = None
    """Side of the views in pixels; the layout's own (300) if not given."""
    spacing: float | None = None
    """Metres between neighbouring places; the layout's own if not given."""
    places: int | None = None
    """Keep only so many places, around the middle of the room; the layout's own if not given."""
    workers: int | None = None
    """Processes; all cores if not given."""
    force: bool = False
    """Replace what is there, and begin anew where a rendering was interrupted."""
    resume: bool = False
    """Go on where a rendering was interrupted; with --count also leave files that are done as they are."""

    def run(self) -> int:
        from active_perceiver.capture.rendered.config import layout_config
        from active_perceiver.capture.rendered.render import RoomChange, default_name, render_scene, render_scenes
        from active_perceiver.parallel.process_pool import ProcessExecutor

        if self.count is not None and self.count < 1:
            raise UserError(f"--count must be at least 1, got {self.count}")
        settings = layout_config(self.layout, image_size=self.image_size, spacing=self.spacing, places=self.places)
        executor, change = ProcessExecutor(self.workers), RoomChange(self.hour, self.moved)
        if self.count is None:
            path = self.out or Path(default_name(self.layout, self.seed, change))
            timing = render_scene(
                self.layout, self.seed, path, force=self.force, resume=self.resume, executor=executor,
                settings=settings, change=change,
            )  # fmt: skip
            print(f"scene: {path}\n{timing.text()}")
            return 0
        rendered = render_scenes(
            self.layout, range(self.seed, self.seed + self.count), self.out or Path(), force=self.force,
            resume=self.resume, executor=executor, settings=settings, change=change,
        )  # fmt: skip
        for path, taken in rendered:
            print(f"scene: {path}\n{taken.text() if taken else 'was there'}")
        return 0


@dataclass
class ScenesPreview:
    """Make rooms without photographing them: are they sound, how do they look?"""

    layouts: Positional[tuple[str, ...]] = ()
    """Kinds of rooms; all if not given."""
    seed: int = 1
    """The first room of each kind."""
    count: int = 4
    """How many rooms of each kind."""
    picture: Path | None = None
    """Write pictures of all rooms side by side here (PNG or JPEG)."""
    views: int = 2
    """Pictures of each room, 1 to 4."""
    out: Path | None = None
    """Write what was found here, as JSON."""
    image_size: int = 300
    """Side of each picture in pixels."""
    workers: int | None = None
    """Processes; all cores if not given."""
    force: bool = False
    """Replace an existing picture or result."""

    def run(self) -> int:
        from active_perceiver.parallel.process_pool import ProcessExecutor
        from active_perceiver.utils.files import check_output, replacing
        from active_perceiver.utils.progress import progress_bar
        from active_perceiver.utils.result import write_result
        from indoor_rooms.layouts import LAYOUTS
        from indoor_rooms.preview import look_at_rooms, preview_sheet

        if self.count < 1 or not 1 <= self.views <= 4:
            raise UserError(f"--count is at least 1 and --views 1 to 4, got {self.count} and {self.views}")
        for path in (self.picture, self.out):
            if path is not None:
                check_output(path, self.force)
        seeds = range(self.seed, self.seed + self.count)
        executor = ProcessExecutor(self.workers)
        with progress_bar("rooms") as report:
            looks = look_at_rooms(
                self.layouts or tuple(LAYOUTS), seeds, self.views if self.picture else 0, self.image_size, report,
                run=lambda work, shared, jobs, progress: list(executor.map(work, jobs, shared, progress)),
            )  # fmt: skip
        for look in looks:
            print(f"{look.name}: {look.places} places, {look.targets} targets", *look.problems, sep="\n  ")
        unsound = sum(bool(look.problems) for look in looks)
        print(f"{len(looks) - unsound} of {len(looks)} rooms are sound")
        if self.out is not None:
            rooms = [
                {"name": look.name, "places": look.places, "targets": look.targets, "problems": look.problems}
                for look in looks
            ]
            write_result(self.out, "scenes preview", {"sound": len(looks) - unsound, "rooms": rooms})
            print(f"result: {self.out}")
        if self.picture is not None:
            with replacing(self.picture, self.force) as temporary:
                preview_sheet(looks).save(temporary)
            print(f"pictures: {self.picture}")
        return 1 if unsound else 0


@dataclass
class ScenesElsewhere:
    """Photograph the targets of a scene in other rooms, to train a recogniser that has not seen the scene."""

    scene: Positional[str]
    """Bundled name or file of a scene made by `scenes render`."""
    out: Path
    """The scene file to write: photographs without moves between them, to train on, not to search in."""
    pictures: int = 150
    """Photographs of each target; 150 in the paper."""
    targets: tuple[str, ...] = ()
    """Names of the targets to photograph; all if not given. Others that are in a photograph are annotated too."""
    rooms: int = 6
    """In how many other rooms they are photographed."""
    workers: int | None = None
    """Processes; all cores if not given."""
    force: bool = False
    """Replace what is there, and begin anew where the work was interrupted."""
    resume: bool = False
    """Go on where the work was interrupted."""

    def run(self) -> int:
        from active_perceiver.capture.rendered.elsewhere import render_elsewhere
        from active_perceiver.parallel.process_pool import ProcessExecutor
        from active_perceiver.scenes import open_scene

        photographs = render_elsewhere(
            open_scene(self.scene), self.out, pictures=self.pictures, targets=self.targets, rooms=self.rooms,
            force=self.force, resume=self.resume, executor=ProcessExecutor(self.workers),
        )  # fmt: skip
        print(f"scene: {self.out}\nrooms: {', '.join(photographs.rooms)}")
        for name, count in sorted(photographs.seen.items(), key=lambda item: -item[1]):
            print(f"{name:<16} {photographs.taken.get(name, 0):>5} photographs taken of it, seen in {count}")
        return 0


ScenesCommand = (
    Annotated[ScenesList, subcommand("list", description=help_text("The bundled scenes.", "scenes list"))]
    | Annotated[
        ScenesInfo,
        subcommand(
            "info",
            description=help_text(
                "What a scene holds: views, moves, targets, how often each is seen, how many pictures are held out.",
                "scenes info kitchen_1",
                "scenes info kitchen_1 --picture kitchen.png",
            ),
        ),
    ]
    | Annotated[
        ScenesCheck,
        subcommand(
            "check",
            description=help_text(
                "What is wrong with a scene and what that means; exit code 1 if it, or one of its objects, cannot be "
                "searched. Islands of states are no reason: a search starts where a goal can be reached.",
                "scenes check kitchen_1",
                "scenes check my_room.h5",
            ),
        ),
    ]
    | Annotated[
        ScenesPreview,
        subcommand(
            "preview",
            description=help_text(
                "Make rooms without photographing them: is each sound (nothing floats or intersects, all is reached),"
                " and how does it look? Exit code 1 if one is not sound.",
                "scenes preview kitchen --count 40",
                "scenes preview --count 4 --picture rooms.png",
            ),
        ),
    ]
    | Annotated[
        ScenesRender,
        subcommand(
            "render",
            description=help_text(
                "Make scenes from generated 3D rooms (needs the `rooms` extra); what is finished survives an "
                "interruption.",
                "scenes render kitchen --seed 1 --out my_kitchen.h5",
                "scenes render living_room --seed 10 --count 5 --out rooms --resume",
                "scenes render kitchen --seed 1 --hour dusk",
                "scenes render kitchen --seed 1 --moved 2",
            ),
        ),
    ]
    | Annotated[
        ScenesImport,
        subcommand(
            "import",
            description="Make a scene of photographs, or of other projects' files (each has its own --help).",
        ),
    ]
    | Annotated[
        ScenesExport,
        subcommand("export", description="Write a scene for a labelling tool or other projects (own --help each)."),
    ]
    | Annotated[
        ScenesLabel,
        subcommand(
            "label",
            description=help_text(
                "Say where the targets are in the views of a scene: draw boxes on a page in the browser, take them "
                "from a COCO file, or have an agent propose them.",
                "scenes label my_room.h5",
                "scenes label my_room.h5 --propose kitchen_agent",
                "scenes label my_room.h5 --from result_coco.json",
                "scenes label kitchen_1 --out my_kitchen.h5",
            ),
        ),
    ]
    | Annotated[
        ScenesCapture,
        subcommand(
            "capture",
            description="Make a scene of a room of AI2-THOR, or photographs of a generated room (own --help each).",
        ),
    ]
    | Annotated[
        ScenesElsewhere,
        subcommand(
            "elsewhere",
            description=help_text(
                "Photograph the targets of a scene lying in other rooms (needs the `rooms` extra), to train a "
                "recogniser that has not seen the scene; what is finished survives an interruption.",
                "scenes elsewhere conference_room --out elsewhere.h5 --targets scissors stapler mug bag",
                "train --scenes conference_room --targets record --recogniser-scenes elsewhere.h5 --out agent",
            ),
        ),
    ]
)


@dataclass
class Scenes:
    """What scenes there are, are they sound, make one."""

    command: ScenesCommand

    def run(self) -> int:
        return self.command.run()
