"""How long a room takes to make, to light and to photograph, and where the time of a view goes."""

from __future__ import annotations

import cProfile
import pstats
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.benchmarks.config import RenderSpeedConfig
from active_perceiver.benchmarks.render.report import format_timing
from active_perceiver.benchmarks.runner import Benchmark, ResultBody
from active_perceiver.capture.rendered.config import DEFAULT_CONFIGS, CaptureConfig
from active_perceiver.parallel.executor import Executor, tell
from active_perceiver.parallel.fresh_process import FreshProcessExecutor
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.utils.memory import peak_memory
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet
from indoor_rooms.free_space import free_positions
from indoor_rooms.layouts import LAYOUTS, make_room
from indoor_rooms.renderer import camera, pixels, shading, tone
from indoor_rooms.renderer.camera import Quality, render
from indoor_rooms.renderer.compiled import compile_room
from indoor_rooms.renderer.lighting import BakedRoom, bake
from indoor_rooms.room import Room
from indoor_rooms.studio.studio_pictures import studio_pictures

HEADINGS = (0.0, 90.0, 180.0, 270.0)
# The functions in which the stages of a view spend their time; none calls another of them.
STAGES = {
    "camera rays": ((camera, "_cast"),),
    "textures": ((pixels, "_colour"), (pixels, "_pixel_colour")),
    "sun and lamps": ((shading, "_light_samples"),),
    "reflections and contact shadows": ((shading, "_reflected"), (shading, "_near_field")),
    "denoising": ((tone, "remove_noise"),),
    "tone mapping": ((tone, "tone_map"),),
}
REST = "rest"


@dataclass(frozen=True)
class RenderBenchmark(Benchmark):
    """How long rooms take to make, to light and to photograph."""

    name = "render"
    layouts: tuple[str, ...]
    settings: RenderSpeedConfig
    executor: Executor = field(default_factory=FreshProcessExecutor)

    def prepare(self) -> None:
        """See `Benchmark`."""

    def measure(self, store: RunStore) -> ResultBody:
        """Each room in a process of its own, with one thread and nothing cached; see `measure_rendering`."""
        layouts = self.layouts or tuple(LAYOUTS)
        with progress_bar("rooms") as report:
            rooms = list(self.executor.map(_measure_layout, layouts, self.settings, report))
        return {"protocol": {"cores": 1, "threads": 1, "views": self.settings.views}, "rooms": rooms}

    def report(self, body: ResultBody) -> str:
        """See `format_timing`."""
        return "\n\n".join(format_timing(room) for room in body["rooms"])


def _measure_layout(settings: RenderSpeedConfig, layout: str) -> ResultBody:
    return measure_rendering(
        lambda: make_room(layout, settings.seed),
        settings.views,
        settings=DEFAULT_CONFIGS.get(layout),
        progress=lambda done, total, note="": tell(f"{done}/{total} {note}"),
    )


def measure_rendering(
    make: Callable[[], Room],
    views: int = 12,
    image_size: int = 300,
    *,
    settings: CaptureConfig | None = None,
    seed: int = 0,
    progress: ProgressCallback = quiet,
) -> dict[str, Any]:
    """Time the rendering of a room in this process, on one core.

    Start the process with `OMP_NUM_THREADS=1`, as rendering processes are.

    Args:
        make: furnishes the room.
        views: how many to take, from random free positions, headings and tilts by turns.
        image_size: side of the views and of the target pictures in pixels.
        settings: camera, lattice of positions and light; `image_size` replaces theirs.
        seed: of the light and of the choice of views.
        progress: called with the pieces of work done and to do.

    Returns:
        Plain data. "room", "compile", "light" (which compiles again), and "target picture" (None for a room without
        targets): {"cpu": seconds, "wall": seconds}; "view": {"median", "worst", "wall_median": seconds,
        "per_second": of a core, "stages": name -> share of the CPU time}; what was measured: "name", "views",
        "image_size", "samples", "bake_rays", "triangles", "vertices", "lamps"; "peak_memory_gib" of the process so
        far, None where the system does not tell.

    Raises:
        ValueError: if `views` is less than 1.
    """
    if views < 1:
        raise ValueError(f"at least one view is to be measured, got {views}")
    settings = settings or CaptureConfig()
    steps = iter(range(1, 2 * views + 5))

    def report(note: str) -> None:
        progress(next(steps), 2 * views + 4, note)

    with _clock() as room_time:
        room = make()
    report("room made")
    with _clock() as compile_time:
        compile_room(room)
    report("compiled")
    with _clock() as light_time:
        baked = bake(room, settings.bake_rays, settings.bounces, seed)
    report("lit")
    poses = _poses(room, views, settings, seed)

    def take(pose: NDArray[np.float64]) -> None:
        x, y, heading, tilt = pose.tolist()
        place = (x, y, settings.camera_height)
        render(baked, place, heading, tilt, image_size, settings.fov, quality=Quality(settings.samples))

    # The first view also sets up what all need: rays, sun shafts, the denoiser.
    take(poses[0])
    times = []
    for pose in poses:
        with _clock() as view_time:
            take(pose)
        times.append(view_time)
        report("views")
    profile = cProfile.Profile(time.process_time)
    for pose in poses:
        profile.runcall(take, pose)
        report("stages of a view")
    picture_time = _target_picture(room, seed, image_size)
    report("target picture")
    return {
        "name": room.name,
        "views": views,
        "image_size": image_size,
        "samples": settings.samples,
        "bake_rays": settings.bake_rays,
        **_size(baked),
        "room": room_time,
        "compile": compile_time,
        "light": light_time,
        "view": _summary(times, profile),
        "target picture": picture_time,
        "peak_memory_gib": peak_memory(),
    }


@contextmanager
def _clock() -> Iterator[dict[str, float]]:
    """CPU and wall seconds of a block; the dictionary is filled when it ends."""
    seconds: dict[str, float] = {}
    cpu, wall = time.process_time(), time.perf_counter()
    yield seconds
    seconds.update(cpu=time.process_time() - cpu, wall=time.perf_counter() - wall)


def _poses(room: Room, views: int, settings: CaptureConfig, seed: int) -> NDArray[np.float64]:
    """(views, 4) x, y, heading, tilt: places at random, directions by turns."""
    places = free_positions(room, settings.spacing, settings.robot_radius)
    chosen = places[np.random.default_rng(seed).integers(len(places), size=views)]
    directions = [(heading, tilt) for tilt in settings.tilts for heading in HEADINGS]
    return np.hstack([chosen, [directions[view % len(directions)] for view in range(views)]])


def _target_picture(room: Room, seed: int, image_size: int) -> dict[str, float] | None:
    """Seconds a picture of the first target takes, its share of the studio's light included."""
    if not room.targets:
        return None
    with _clock() as seconds:
        pictures = studio_pictures(room, next(iter(room.targets)), 0, seed, image_size)
    return {key: value / len(pictures) for key, value in seconds.items()}


def _size(baked: BakedRoom) -> dict[str, int]:
    surfaces = baked.surfaces
    return {
        "triangles": len(surfaces.faces),
        "vertices": len(surfaces.positions),
        "lamps": len(baked.room.lamps),
    }


def _summary(times: list[dict[str, float]], profile: cProfile.Profile) -> dict[str, Any]:
    cpu = np.array([seconds["cpu"] for seconds in times])
    return {
        "median": float(np.median(cpu)),
        "worst": float(cpu.max()),
        "wall_median": float(np.median([seconds["wall"] for seconds in times])),
        "per_second": float(1 / max(np.median(cpu), 1e-9)),
        "stages": _stages(profile),
    }


def _stages(profile: cProfile.Profile) -> dict[str, float]:
    """Share of the time of `render` in each stage; they add up to 1."""
    cumulative: dict[tuple[str, str], float] = {}
    statistics: dict[tuple[str, int, str], tuple[Any, ...]] = pstats.Stats(profile).stats  # type: ignore[attr-defined]
    for (file, _, name), entry in statistics.items():
        cumulative[file, name] = cumulative.get((file, name), 0.0) + entry[3]
    whole = max(cumulative[str(camera.__file__), "render"], 1e-9)
    shares = {
        stage: sum(cumulative.get((str(module.__file__), name), 0.0) for module, name in functions) / whole
        for stage, functions in STAGES.items()
    }
    return {**shares, REST: 1 - sum(shares.values())}
