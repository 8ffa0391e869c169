"""Photographs of a scene's targets in other rooms: what a recogniser is trained on before it sees the scene.

The paper trains the recogniser of its conference room on 150 pictures of each target that were taken elsewhere.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.capture_scene import photograph
from active_perceiver.capture.rendered.config import CaptureConfig, CaptureError, layout_config
from active_perceiver.capture.rendered.other_rooms import OtherRoom, plan_rooms, shared_out
from active_perceiver.capture.rendered.render import check_scene_output, origin_of
from active_perceiver.capture.rendered.stored_light import light_arrays, lit_room
from active_perceiver.capture.rendered.vantage import Eye, poses_towards
from active_perceiver.parallel.executor import Executor
from active_perceiver.parallel.process_pool import ProcessExecutor
from active_perceiver.parallel.run_missing import run_missing
from active_perceiver.parallel.run_store import RunStore, part_folder
from active_perceiver.scenes.lattice import TURTLEBOT_ACTIONS
from active_perceiver.scenes.scene import Scene
from active_perceiver.scenes.storage import save_scene
from active_perceiver.utils.progress import progress_bar
from indoor_rooms.layouts import LAYOUTS
from indoor_rooms.layouts.placement import stream
from indoor_rooms.renderer.compiled import compile_room
from indoor_rooms.renderer.lighting import BakedRoom, bake

LOG = logging.getLogger(__name__)

# Rays per vertex: photographs of a moment need no better light.
BAKE_RAYS = 48
# Metres between the rooms' corners in the file, so that no two photographs seem to be taken at one place.
APART = 20.0


@dataclass(frozen=True)
class Photographs:
    """What `render_elsewhere` made.

    Attributes:
        taken: how many photographs were taken of each target.
        seen: in how many photographs each target of the scene is seen, by name.
        rooms: names of the rooms they were taken in.
    """

    taken: Mapping[str, int]
    seen: Mapping[str, int]
    rooms: tuple[str, ...]


@dataclass(eq=False)
class _Studio:
    """What a process needs; it keeps the room it was last in."""

    rooms: tuple[OtherRoom, ...]
    settings: CaptureConfig
    names: tuple[str, ...]
    store: RunStore
    _last: tuple[int, BakedRoom] | None = field(default=None, init=False)

    def baked(self, number: int) -> BakedRoom:
        """A room with its light, which an earlier stage has baked."""
        if self._last is None or self._last[0] != number:
            self._last = None  # two rooms at a time would not be memory well spent
            room = self.rooms[number].furnished()
            light = self.store.loaded(self.rooms[number].key)
            self._last = (number, lit_room(room, compile_room(room), light))
        return self._last[1]


def render_elsewhere(
    scene: Scene,
    out: Path,
    *,
    pictures: int = 150,
    targets: Sequence[str] = (),
    rooms: int = 6,
    force: bool = False,
    resume: bool = False,
    executor: Executor | None = None,
) -> Photographs:
    """Photograph the targets of a scene lying in other rooms, and write the photographs as a scene file.

    The objects are the very ones of the scene; the rooms, the light and the poses are others. What is finished is
    kept in the folder `OUT.part` until the file is written; the same arguments give the same file, whatever does the
    work and however often the work was interrupted.

    The photographs are single ones, without moves between them: a recogniser can be trained on the file, but it
    cannot be searched, and `scenes check` says so.

    Args:
        scene: rendered by `scenes render`, whose layout and seed are read from it.
        out: the scene file; its stem becomes the name.
        pictures: photographs taken of each target. Others that happen to be in one are annotated too.
        targets: names of those to photograph; all if none are given.
        rooms: in how many other rooms.
        force: replace an existing file, and begin anew where the work was interrupted.
        resume: go on with interrupted work.
        executor: does the work; None for a process a core.

    Raises:
        CaptureError: if the scene was not rendered here, a number is below 1, a target can be photographed in no
            room, or the interrupted work was begun with other settings.
        SceneError: if the scene has no target of one of the names.
        OutputExistsError: if the file, or interrupted work on it, exists and nothing says what to do with it.
    """
    check_scene_output(out, force=force)
    layout, seed = origin_of(scene)
    if pictures < 1 or rooms < 1:
        raise CaptureError(f"there must be at least 1 picture and 1 room, got {pictures} and {rooms}")
    rows = [scene.target_index(name) for name in dict.fromkeys(targets or scene.target_names)]
    wanted = tuple(scene.target_names[row] for row in rows)
    settings = layout_config(layout, image_size=scene.image_size, fov=scene.fov, bake_rays=BAKE_RAYS)
    executor = executor or ProcessExecutor()
    with progress_bar("other rooms") as report:
        plan, fingerprints = plan_rooms(scene.target_names, wanted, LAYOUTS[layout].things + seed, pictures, rooms)
        noted = _noted(scene, wanted, pictures, settings, fingerprints)
        store = RunStore.begin(part_folder(out), noted, force=force, resume=resume)
        studio = _Studio(plan, settings, scene.target_names, store)
        run_missing(executor, store, _prepare, {room.key: room for room in plan}, studio, report)
    shots = _shots(plan, store, wanted, pictures)
    taken_from = {f"photograph-{number:05}": (room, pose) for number, (room, _, pose) in enumerate(shots)}
    with progress_bar("photographs") as report:
        run_missing(executor, store, _photograph, taken_from, studio, report)
    seen = [store.loaded(key) for key in taken_from]
    names = tuple(room.name for room in plan)
    taken = Scene(
        name=out.stem,
        actions=TURTLEBOT_ACTIONS,
        views=tuple(view["image"].tobytes() for view in seen),
        poses=np.array([(x + APART * room, *rest) for room, _, (x, *rest) in shots], np.float32),
        transitions=np.repeat(np.arange(len(shots), dtype=np.int32)[:, None], len(TURTLEBOT_ACTIONS), axis=1),
        boxes=np.stack([view["boxes"] for view in seen]),
        targets=scene.targets,
        image_size=settings.image_size,
        fov=settings.fov,
        source=f"photographs of what {layout}_{seed} holds, taken in other rooms of active-perceiver "
        f"({', '.join(names)}); rendered with Embree, no moves between them",
    )
    save_scene(taken, out, force=force)
    store.remove()
    return Photographs(
        taken={name: sum(target == name for _, target, _ in shots) for name in wanted},
        seen=dict(zip(scene.target_names, (taken.areas > 0).sum(axis=0).tolist(), strict=True)),
        rooms=names,
    )


def _noted(
    scene: Scene, wanted: Sequence[str], pictures: int, settings: CaptureConfig, fingerprints: Sequence[str]
) -> dict[str, Any]:
    """What the photographs follow from."""
    return {
        "scene": [scene.source, scene.content_hash, scene.target_names],
        "targets": wanted,
        "pictures": pictures,
        "settings": {**asdict(settings), "actions": [action.value for action in settings.actions]},
        "rooms": list(fingerprints),
    }


def _prepare(studio: _Studio, job: tuple[str, OtherRoom]) -> None:
    """A room's light, and poses from which the targets in it are seen."""
    key, other = job
    settings, room = studio.settings, other.furnished()
    baked = bake(room, settings.bake_rays, settings.bounces, other.seed)
    eye = Eye(settings.camera_height, settings.fov, settings.robot_radius)
    poses = {
        _of(target): poses_towards(room, baked.surfaces, target, eye, count, stream(other.seed, f"poses {target}"))
        for target, count in other.wanted.items()
    }
    studio.store.save(key, **light_arrays(baked), **poses)


def _of(target: str) -> str:
    """Name of a target's poses beside a room's light."""
    return f"poses of {target}"


def _shots(
    plan: Sequence[OtherRoom], store: RunStore, wanted: Sequence[str], pictures: int
) -> list[tuple[int, str, list[float]]]:
    """Room number, target and pose of each photograph, ordered by room."""
    kept = [store.loaded(room.key) for room in plan]
    shots = []
    for name in wanted:
        poses: list[NDArray[np.float64]] = [arrays.get(_of(name), np.zeros((0, 4))) for arrays in kept]
        shares = shared_out(pictures, [len(of_room) for of_room in poses])
        if not any(shares):
            raise CaptureError(
                f"'{name}' cannot be seen well from anywhere in {len(plan)} other rooms; ask for more --rooms, or "
                "for other --targets"
            )
        if sum(shares) < pictures:
            LOG.warning("note: only %d photographs of %s: it is hard to see", sum(shares), name)
        for room, share in enumerate(shares):
            shots += [(room, name, pose) for pose in poses[room][:share].tolist()]
    return sorted(shots, key=lambda shot: shot[0])


def _photograph(studio: _Studio, job: tuple[str, tuple[int, Sequence[float]]]) -> None:
    """One photograph and the boxes of all targets."""
    key, (number, pose) = job
    seed = studio.rooms[number].seed
    studio.store.save(key, **photograph(studio.baked(number), studio.settings, pose, studio.names, seed))
