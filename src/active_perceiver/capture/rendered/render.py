"""`scenes render`: furnish rooms, photograph them and write the scene files; resumable, and timed."""

from __future__ import annotations

import hashlib
import logging
import re
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.capture.rendered.capture_scene import capture
from active_perceiver.capture.rendered.config import CaptureConfig, CaptureError, layout_config
from active_perceiver.parallel.executor import Executor
from active_perceiver.parallel.process_pool import ProcessExecutor
from active_perceiver.parallel.run_store import RunStore, part_folder
from active_perceiver.scenes.scene import Scene
from active_perceiver.scenes.storage import save_scene
from active_perceiver.utils.files import OutputExistsError, check_output, files_there
from active_perceiver.utils.progress import ProgressBar, ProgressCallback, progress_bar
from indoor_rooms.layouts import make_room
from indoor_rooms.room import Room

LOG = logging.getLogger(__name__)

RENDERED_HERE = re.compile(r"active-perceiver room (\w+)_(\d+), rendered with Embree(; .*)?")


@dataclass
class Timing:
    """Where the time of rendering went.

    Attributes:
        workers: processes that rendered.
        seconds: wall time by stage: "room", "light", "views", "target pictures", "file".
        done: pieces of work done in this run, by stage; what was found finished does not count.
    """

    workers: int
    seconds: dict[str, float] = field(default_factory=dict)
    done: dict[str, int] = field(default_factory=dict)

    @contextmanager
    def stage(self, label: str) -> Iterator[None]:
        """Add the time that the block takes."""
        started = time.monotonic()
        try:
            yield
        finally:
            self.seconds[label] = self.seconds.get(label, 0.0) + time.monotonic() - started

    def timed(self, progress: ProgressBar) -> ProgressBar:
        """The same progress, with every stage timed and its reports counted."""

        @contextmanager
        def stage(label: str) -> Iterator[ProgressCallback]:
            with self.stage(label), progress(label) as report:

                def counted(done: int, total: int, note: str = "") -> None:
                    self.done[label] = self.done.get(label, 0) + 1
                    report(done, total, note)

                yield counted

        return stage

    def text(self) -> str:
        """A few lines for people."""
        total, views = sum(self.seconds.values()), self.done.get("views", 0)
        stages = ", ".join(f"{label} {seconds:.1f} s" for label, seconds in self.seconds.items())
        lines = [f"{total:.1f} s: {stages}"]
        if views:
            alone, overall = views / self.seconds["views"], views / total
            lines.append(
                f"{views} views by {self.workers} processes: {alone:.2f} views/s while rendering them "
                f"({alone / self.workers:.2f} per process), {overall:.2f} over all ({overall / self.workers:.2f} per "
                "process)"
            )
        return "\n".join(lines)


@dataclass(frozen=True)
class RoomChange:
    """In what a room is not as its seed says; see `layouts.make_room`.

    Attributes:
        hour: of the day; the seed's own if None.
        moved: which other arrangement of the things; the room's own if None.
    """

    hour: str | None = None
    moved: int | None = None

    def words(self) -> list[str]:
        """Say what is different: "hour dusk", "moved 2"."""
        return [f"{name} {value}" for name, value in asdict(self).items() if value is not None]


UNCHANGED = RoomChange()


def render_scene(
    layout: str,
    seed: int,
    out: Path,
    *,
    force: bool = False,
    resume: bool = False,
    executor: Executor | None = None,
    settings: CaptureConfig | None = None,
    change: RoomChange = UNCHANGED,
) -> Timing:
    """Furnish a room, photograph it and write the scene file.

    What is finished is kept in the folder `OUT.part` until the scene file is written.

    Args:
        layout: kind of room, a name in `layouts.LAYOUTS`.
        seed: the room and every picture follow from it.
        out: the scene file; written only when everything is done. Its stem becomes the scene's name.
        force: replace an existing file, and begin anew where a rendering was interrupted.
        resume: go on with an interrupted rendering.
        executor: does the work; None for a process a core.
        settings: None for those of the layout, see `layout_config`.
        change: in what the room is not as its seed says.

    Returns:
        Where the time went.

    Raises:
        LayoutError: if there is no such layout or hour, or a number is below 1.
        OutputExistsError: if the file, or an interrupted rendering of it, exists and nothing says what to do with it.
        RunStoreError: if the interrupted rendering was begun with other settings.
    """
    check_scene_output(out, force=force)
    settings = settings or layout_config(layout)
    executor = executor or ProcessExecutor()
    timing = Timing(executor.workers)
    with timing.stage("room"):
        room = make_room(layout, seed, hour=change.hour, moved=change.moved)
    noted = noted_origin(layout, seed, settings, room)
    store = RunStore.begin(part_folder(out), noted, force=force, resume=resume)
    scene = capture(room, settings, seed=seed, executor=executor, progress=timing.timed(progress_bar), store=store)
    with timing.stage("file"):
        changed = "".join(f"; {word}" for word in change.words())
        save_scene(replace(scene, name=out.stem, source=f"{scene.source}{changed}"), out, force=force)
    store.remove()
    return timing


def render_scenes(
    layout: str,
    seeds: Sequence[int],
    folder: Path,
    *,
    force: bool = False,
    resume: bool = False,
    change: RoomChange = UNCHANGED,
    **options: Any,
) -> Iterator[tuple[Path, Timing | None]]:
    """Render a room for each seed, in a folder; files are named as by `default_name`.

    Args:
        layout: kind of room.
        seeds: of the rooms.
        folder: is made.
        force: replace files that are there.
        resume: leave files that are there as they are, and go on with an interrupted rendering.
        change: see `render_scene`.
        options: see there as well.

    Yields:
        Each file when it is done, and where its time went; None for one that was there.

    Raises:
        OutputExistsError: before anything is rendered, if a file exists and nothing says what to do with it.
    """
    files = [folder / default_name(layout, seed, change) for seed in seeds]
    there = files_there(files, force=force, resume=resume)
    for number, (seed, path) in enumerate(zip(seeds, files, strict=True), 1):
        if path in there and resume:
            yield path, None
        else:
            LOG.info("%s (%d of %d)", path, number, len(files))
            yield path, render_scene(layout, seed, path, force=force, resume=resume, change=change, **options)


def default_name(layout: str, seed: int, change: RoomChange = UNCHANGED) -> str:
    """What a room's scene file is called: "kitchen_1.h5", "kitchen_1_hour_dusk.h5"."""
    return f"{'_'.join([layout, str(seed), *change.words()])}.h5".replace(" ", "_")


def origin_of(scene: Scene) -> tuple[str, int]:
    """Layout and seed of the room that a scene was rendered from.

    Raises:
        CaptureError: if it was not rendered here.
    """
    found = RENDERED_HERE.fullmatch(scene.source)
    if not found:
        raise CaptureError(
            f"scene '{scene.name}' was not rendered by this software, so neither it nor its things can be rendered "
            "again; give a scene made by `scenes render`"
        )
    return found[1], int(found[2])


def check_scene_output(out: Path, *, force: bool) -> None:
    """Better now than after minutes of rendering."""
    if out.suffix != ".h5":
        raise CaptureError(f"{out} does not end in .h5; give a scene file as --out, or --count for a folder of them")
    if out.is_dir():
        raise OutputExistsError(f"{out} is a folder; give another name")
    check_output(out, force)


def noted_origin(layout: str, seed: int, settings: CaptureConfig, room: Room) -> dict[str, Any]:
    """What every picture follows from. The room's fingerprint tells a change of the code that makes rooms."""
    return {
        "layout": layout,
        "seed": seed,
        "settings": {**asdict(settings), "actions": [action.value for action in settings.actions]},
        "room": room_fingerprint(room),
    }


def room_fingerprint(room: Room) -> str:
    """Hex digest of everything in a room."""
    digest = hashlib.sha256(repr((room.name, room.size, room.targets, room.sun, room.sky, room.lamps)).encode())
    known: dict[int, bytes] = {}
    for part in room.parts:
        digest.update(part.object_name.encode())
        for thing in (part.mesh, part.material):
            for name, value in sorted(vars(thing).items()):
                digest.update(name.encode())
                if isinstance(value, np.ndarray):
                    # Textures are large, and shared by many parts.
                    digest.update(known.setdefault(id(value), hashlib.sha256(value.tobytes()).digest()))
                else:
                    digest.update(repr(value).encode())
    for label, polygon in room.obstacles:
        digest.update(label.encode())
        digest.update(np.asarray(polygon, np.float64).tobytes())
    return digest.hexdigest()[:24]
