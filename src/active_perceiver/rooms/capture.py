"""From a room to a scene: every view a robot can have on a lattice of poses, with the targets' boxes and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.files import OutputExistsError
from active_perceiver.progress import Report, progress_bar, quiet
from active_perceiver.rooms.camera import render
from active_perceiver.rooms.free_space import free_positions, without_collisions
from active_perceiver.rooms.layouts import make_room
from active_perceiver.rooms.lighting import BakedRoom, bake
from active_perceiver.rooms.room import Room
from active_perceiver.rooms.studio import SETUPS, TargetError, studio_pictures
from active_perceiver.rooms.workers import run_parallel
from active_perceiver.scenes.images import encode_image
from active_perceiver.scenes.lattice import EIGHT_ACTIONS, lattice_poses, lattice_transitions
from active_perceiver.scenes.scene import FloorPlan, Scene, Target
from active_perceiver.scenes.storage import save_scene

HEADINGS = (0.0, 90.0, 180.0, 270.0)
# An object that covers less of the picture than this cannot be recognised by anyone.
SMALLEST_VISIBLE = 0.0005

Stage = Callable[[str], AbstractContextManager[Report]]


@dataclass(frozen=True)
class CaptureSettings:
    """How a room is cut into states and photographed.

    Attributes:
        spacing: metres between neighbouring positions, and moved by one action.
        robot_radius: metres.
        camera_height: metres above the floor.
        tilts: degrees, evenly spaced; positive looks up.
        image_size: side of the views in pixels.
        fov: field of view in degrees.
        samples: rays per pixel, a square number.
        bake_rays: rays per vertex of the light's computation.
        bounces: how often light is passed on.
        webp_quality: of the encoded views, 0..100.
    """

    spacing: float = 0.35
    robot_radius: float = 0.2
    camera_height: float = 1.25
    tilts: tuple[float, ...] = (-30.0, 0.0, 30.0)
    image_size: int = 300
    fov: float = 75.0
    samples: int = 4
    bake_rays: int = 96
    bounces: int = 4
    webp_quality: int = 88


@dataclass(frozen=True, eq=False)
class _Job:
    """What a worker needs for every view."""

    baked: BakedRoom
    settings: CaptureSettings
    targets: tuple[str, ...]


def _silent(label: str) -> AbstractContextManager[Report]:
    return nullcontext(quiet)


def capture(
    room: Room,
    settings: CaptureSettings | None = None,
    *,
    seed: int = 0,
    workers: int | None = None,
    progress: Stage = _silent,
) -> Scene:
    """Photograph a room from every pose of a lattice, and its targets alone.

    The same room, settings and seed give byte-identical pictures, however many workers there are.

    Args:
        room: what to photograph.
        settings: how; the defaults are those of the bundled scenes.
        seed: of the light's randomness.
        workers: processes; None for one a core.
        progress: opens a progress bar for each of the three stages.

    Raises:
        FreeSpaceError: if the robot finds no place in the room.
        TargetError: if the room lists targets it does not hold, or none.
        WorkerError: if a rendering process was killed.
    """
    settings = settings or CaptureSettings()
    _check_targets(room)
    positions = free_positions(room, settings.spacing, settings.robot_radius)
    poses = lattice_poses(positions, HEADINGS, settings.tilts)
    transitions = lattice_transitions(poses, EIGHT_ACTIONS, settings.spacing)
    polygons = [polygon for _, polygon in room.obstacles]
    transitions = without_collisions(poses, transitions, polygons, settings.robot_radius)
    with progress("light") as report:
        baked = bake(room, settings.bake_rays, settings.bounces, seed, report)
    names = tuple(room.targets)
    with progress("views") as report:
        views = run_parallel(_photograph, _Job(baked, settings, names), poses.tolist(), workers, report)
    del baked
    with progress("target pictures") as report:
        jobs = [(name, setup) for name in names for setup in range(SETUPS)]
        pictures = run_parallel(_photograph_alone, (room, settings, seed), jobs, workers, report)
    targets = []
    for row, name in enumerate(names):
        of_target = [picture for setup in pictures[row * SETUPS : (row + 1) * SETUPS] for picture in setup]
        targets.append(Target(name, tuple(of_target), room.targets[name]))
    return Scene(
        name=room.name,
        actions=EIGHT_ACTIONS,
        views=tuple(view for view, _ in views),
        poses=poses,
        transitions=transitions,
        boxes=np.stack([boxes for _, boxes in views]),
        targets=tuple(targets),
        image_size=settings.image_size,
        fov=settings.fov,
        source=f"active-perceiver room {room.name}, rendered with Embree",
        floor_plan=_floor_plan(room),
    )


def _floor_plan(room: Room) -> FloorPlan:
    """Walls and obstacles from above; what reaches into a wall, as a window does, is cut off there."""
    width, depth, _ = room.size
    outline = np.array([[0, 0], [width, 0], [width, depth], [0, depth]], np.float64)
    return FloorPlan(
        outline, tuple((label, np.clip(polygon, 0, (width, depth))) for label, polygon in room.obstacles)
    )


def render_scene(
    layout: str,
    seed: int,
    out: Path,
    *,
    force: bool = False,
    workers: int | None = None,
    settings: CaptureSettings | None = None,
) -> Scene:
    """Furnish a room, photograph it and write the scene file.

    Args:
        layout: kind of room, a name in `layouts.LAYOUTS`.
        seed: the room and every picture follow from it.
        out: the scene file; written only when everything is done.
        force: replace an existing file.
        workers: processes; None for one a core.
        settings: see `CaptureSettings`.

    Raises:
        LayoutError: if there is no such layout, or the seed is below 1.
        OutputExistsError: if the file exists and `force` is false.
    """
    if out.exists() and not force:
        # Better now than after minutes of rendering.
        raise OutputExistsError(f"{out} exists; give another name, or --force to replace it")
    scene = capture(make_room(layout, seed), settings, seed=seed, workers=workers, progress=progress_bar)
    save_scene(scene, out, force=force)
    return scene


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


def _check_targets(room: Room) -> None:
    known = {part.object_name for part in room.parts}
    if missing := sorted(set(room.targets) - known):
        raise TargetError(f"room '{room.name}' has no objects {missing}; correct its list of targets")
    if not room.targets:
        raise TargetError(f"room '{room.name}' has no targets; there would be nothing to search")


def _photograph(job: _Job, pose: Sequence[float]) -> tuple[bytes, NDArray[np.float32]]:
    """One view, encoded, and its boxes."""
    x, y, heading, tilt = pose
    settings = job.settings
    rendering = render(
        job.baked, (x, y, settings.camera_height), heading, tilt, settings.image_size, settings.fov, settings.samples
    )
    objects = [job.baked.object_names.index(name) for name in job.targets]
    image = encode_image(rendering.image, quality=settings.webp_quality)
    return image, boxes_from_mask(rendering.mask, objects)


def _photograph_alone(shared: tuple[Room, CaptureSettings, int], job: tuple[str, int]) -> list[bytes]:
    room, settings, seed = shared
    target, setup = job
    pictures = studio_pictures(room, target, setup, seed, settings.image_size)
    return [encode_image(picture, quality=settings.webp_quality) for picture in pictures]
