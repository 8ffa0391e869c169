"""From a room to a scene: every view a robot can have on a lattice of poses, with the targets' boxes and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.config import CaptureConfig
from active_perceiver.capture.rendered.stored_light import light_arrays, lit_room
from active_perceiver.parallel.executor import Executor
from active_perceiver.parallel.process_pool import ProcessExecutor
from active_perceiver.parallel.run_missing import run_missing
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.scenes.floor_plan import FloorPlan
from active_perceiver.scenes.images import encode_image
from active_perceiver.scenes.lattice import lattice_poses, lattice_transitions
from active_perceiver.scenes.scene import Scene, Target
from active_perceiver.utils.progress import ProgressBar, ProgressCallback, quiet
from indoor_rooms.free_space import free_positions, without_collisions
from indoor_rooms.renderer.camera import Quality, render
from indoor_rooms.renderer.camera_faults import view_rng, with_faults
from indoor_rooms.renderer.compiled import compile_room
from indoor_rooms.renderer.lighting import BakedRoom, bake
from indoor_rooms.room import Room
from indoor_rooms.studio.studio_pictures import HELD_OUT, SETUPS, TargetError, studio_pictures

HEADINGS = (0.0, 90.0, 180.0, 270.0)
# An object that covers less of the picture than this cannot be recognised by anyone.
SMALLEST_VISIBLE = 0.0005
LIGHT = "light"


@dataclass(eq=False)
class Studio:
    """What a process needs for every picture; it reads the light from the store when it takes its first view.

    Attributes:
        room: what is photographed.
        settings: how.
        seed: of the light's randomness, the camera's faults and the target pictures.
        store: where finished work is kept.
    """

    room: Room
    settings: CaptureConfig
    seed: int
    store: RunStore

    @cached_property
    def baked(self) -> BakedRoom:
        """The room with the light that an earlier stage has baked."""
        return lit_room(self.room, compile_room(self.room), self.store.loaded(LIGHT))


def _silent(label: str) -> AbstractContextManager[ProgressCallback]:
    return nullcontext(quiet)


def capture(
    room: Room,
    settings: CaptureConfig | None = None,
    *,
    seed: int = 0,
    executor: Executor | None = None,
    progress: ProgressBar = _silent,
    store: RunStore | None = None,
) -> Scene:
    """Photograph a room from every pose of a lattice, and its targets alone.

    The same room, settings and seed give byte-identical pictures, whatever does the work and however often
    the work was interrupted.

    Args:
        room: what to photograph.
        settings: how; the defaults are those of the bundled rooms.
        seed: of the light's randomness, the camera's faults and the target pictures.
        executor: does the work; None for a process a core.
        progress: opens a progress bar for each of the three stages: "light", "views", "target pictures".
        store: where finished work is kept, and looked for; a temporary folder if None.

    Raises:
        FreeSpaceError: if the robot finds no place in the room, or not as many as wanted.
        TargetError: if the room lists targets it does not hold, or none.
        WorkerError: if a rendering process was killed.
    """
    settings, executor = settings or CaptureConfig(), executor or ProcessExecutor()
    check_targets(room)
    if store is None:
        with TemporaryDirectory(prefix="active-perceiver-") as folder:
            own = RunStore(Path(folder))
            return capture(room, settings, seed=seed, executor=executor, progress=progress, store=own)
    positions = free_positions(room, settings.spacing, settings.robot_radius, settings.places)
    poses = lattice_poses(positions, HEADINGS, settings.tilts)
    transitions = lattice_transitions(poses, settings.actions, settings.spacing)
    polygons = [polygon for _, polygon in room.obstacles]
    transitions = without_collisions(poses, transitions, polygons, settings.robot_radius)
    studio = Studio(room, settings, seed, store)
    seen = take_views(photograph_view, studio, poses.tolist(), executor, progress)
    targets = take_targets(studio, tuple(room.targets), executor, progress)
    return Scene(
        name=room.name,
        actions=settings.actions,
        views=tuple(view["image"].tobytes() for view in seen),
        poses=poses,
        transitions=transitions,
        boxes=np.stack([view["boxes"] for view in seen]),
        targets=targets,
        image_size=settings.image_size,
        fov=settings.fov,
        source=f"active-perceiver room {room.name}, rendered with Embree",
        floor_plan=_floor_plan(room),
    )


def take_views(
    work: Callable[[Studio, tuple[str, Any]], None],
    studio: Studio,
    jobs: Sequence[Any],
    executor: Executor,
    progress: ProgressBar,
) -> list[dict[str, NDArray[Any]]]:
    """Bake a room's light and take views, as far as the store does not hold them.

    Args:
        work: takes a view and keeps it in the store, given the studio, its key and its job.
        studio: the room and how it is photographed.
        jobs: what differs between the views, as their poses.
        executor: does the work; None for a process a core.
        progress: opens a progress bar for each of the two stages.

    Returns:
        What `work` kept of each.
    """
    store, settings = studio.store, studio.settings
    with progress("light") as report:
        if store.load(LIGHT) is None:
            light = bake(studio.room, settings.bake_rays, settings.bounces, studio.seed, report)
            store.save(LIGHT, **light_arrays(light))
    keys = [f"view-{state:05}" for state in range(len(jobs))]
    with progress("views") as report:
        run_missing(executor, store, work, dict(zip(keys, jobs, strict=True)), studio, report)
    return [store.loaded(key) for key in keys]


def take_targets(
    studio: Studio, names: Sequence[str], executor: Executor, progress: ProgressBar
) -> tuple[Target, ...]:
    """Photograph some of a room's targets alone, as far as the store does not hold the pictures."""
    store = studio.store
    alone = [(name, setup) for name in names for setup in range(SETUPS)]
    keys = [f"target-{number // SETUPS:03}-{number % SETUPS}" for number in range(len(alone))]
    with progress("target pictures") as report:
        run_missing(executor, store, _photograph_alone, dict(zip(keys, alone, strict=True)), studio, report)
    targets = []
    for row, name in enumerate(names):
        of_target = [
            blob.tobytes()
            for key in keys[row * SETUPS : (row + 1) * SETUPS]
            for _, blob in sorted(store.loaded(key).items())
        ]
        targets.append(Target(name, tuple(of_target), studio.room.targets[name], HELD_OUT))
    return tuple(targets)


def _floor_plan(room: Room) -> FloorPlan:
    """Walls and obstacles from above; what reaches into a wall, as a window does, is cut off there."""
    width, depth, _ = room.size
    outline = np.array([[0, 0], [width, 0], [width, depth], [0, depth]], np.float64)
    return FloorPlan(
        outline, tuple((label, np.clip(polygon, 0, (width, depth))) for label, polygon in room.obstacles)
    )


def boxes_from_mask(mask: NDArray[np.int32], objects: Sequence[int]) -> NDArray[np.float32]:
    """Bounding boxes of some objects in an instance mask.

    Args:
        mask: (H, W) object of each pixel.
        objects: (T,) whose boxes.

    Returns:
        (T, 4) float32 centre x, centre y, width, height as fractions of the image; NaN where the object covers less
        than `SMALLEST_VISIBLE` of it.
    """
    height, width = mask.shape
    boxes = np.full((len(objects), 4), np.nan, np.float32)
    for row, number in enumerate(objects):
        y, x = np.nonzero(mask == number)
        if len(x) >= max(1.0, SMALLEST_VISIBLE * mask.size):
            left, right, top, bottom = (
                x.min() / width,
                (x.max() + 1) / width,
                y.min() / height,
                (y.max() + 1) / height,
            )
            boxes[row] = (left + right) / 2, (top + bottom) / 2, right - left, bottom - top
    return boxes


def check_targets(room: Room) -> None:
    """Make sure that a room holds its targets.

    Raises:
        TargetError: if it does not, or lists none.
    """
    known = {part.object_name for part in room.parts}
    if missing := sorted(set(room.targets) - known):
        raise TargetError(f"room '{room.name}' has no objects {missing}; correct its list of targets")
    if not room.targets:
        raise TargetError(f"room '{room.name}' has no targets; there would be nothing to search")


def photograph(
    baked: BakedRoom, settings: CaptureConfig, pose: Sequence[float], targets: Sequence[str], seed: int
) -> dict[str, NDArray[Any]]:
    """What the robot's camera sees, to be kept: "image", encoded, and "boxes"; see `look`."""
    image, boxes = look(baked, settings, pose, targets, seed)
    return {"image": np.frombuffer(encode_image(image, quality=settings.webp_quality), np.uint8), "boxes": boxes}


def look(
    baked: BakedRoom,
    settings: CaptureConfig,
    pose: Sequence[float],
    targets: Sequence[str],
    seed: int,
    height: int | None = None,
) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """What the robot's camera sees.

    Args:
        baked: the room.
        settings: of the camera.
        pose: x, y in metres, heading and tilt in degrees.
        targets: names of those whose boxes are wanted; a room need not hold them all.
        seed: of the camera's faults.
        height: of the picture in pixels, which is cut out of the square one's middle; None for the square one.

    Returns:
        The view (H, W, 3) uint8, and the boxes (T, 4), see `boxes_from_mask`.
    """
    x, y, heading, tilt = pose
    position = (x, y, settings.camera_height)
    rendering = render(
        baked, position, heading, tilt, settings.image_size, settings.fov, quality=Quality(settings.samples)
    )
    height = height or settings.image_size
    top = (settings.image_size - height) // 2
    image, mask = rendering.image[top : top + height], rendering.mask[top : top + height]
    if settings.faults is not None:
        image = with_faults(image, settings.faults, view_rng(seed, pose))
    # A name that no object of the room has is found nowhere in the mask.
    absent = len(baked.object_names)
    objects = [baked.object_names.index(name) if name in baked.room.targets else absent for name in targets]
    return image, boxes_from_mask(mask, objects)


def photograph_view(studio: Studio, job: tuple[str, Sequence[float]]) -> None:
    """One view and its boxes."""
    key, pose = job
    studio.store.save(key, **photograph(studio.baked, studio.settings, pose, tuple(studio.room.targets), studio.seed))


def _photograph_alone(studio: Studio, job: tuple[str, tuple[str, int]]) -> None:
    """The pictures of one target in one setup, encoded."""
    key, (target, setup) = job
    settings = studio.settings
    pictures = studio_pictures(studio.room, target, setup, studio.seed, settings.image_size)
    blobs = [encode_image(picture, quality=settings.webp_quality) for picture in pictures]
    studio.store.save(key, **{f"picture{row:02}": np.frombuffer(blob, np.uint8) for row, blob in enumerate(blobs)})
