"""A room of AI2-THOR as a scene: the agent is put at every pose of a lattice over the positions it can reach."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.thor_targets import (
    Instance,
    instance_views,
    object_picture,
    picture_states,
    room_instances,
    training_first,
)
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.robots.ai2thor import (
    Controller,
    ThorConfig,
    ThorError,
    ThorPose,
    captured_source,
    event_image,
    reachable_positions,
    teleport,
)
from active_perceiver.scenes import Action, Scene, Target
from active_perceiver.scenes.images import encode_image
from active_perceiver.scenes.lattice import MOVE_DIRECTION, lattice_poses, lattice_transitions
from active_perceiver.utils.progress import ProgressBar, progress_bar

PLAN = "plan"


@dataclass(frozen=True)
class ThorCapture:
    """What came of a walk.

    Attributes:
        scene: the room.
        failed: poses at which the simulator would not put the agent, as a rule because it would stand in something;
            they are no states of the scene.
        notes: sentences on targets without good pictures.
    """

    scene: Scene
    failed: int
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Walk:
    """What is to be seen, from where.

    Attributes:
        poses: (N, 4) all of the lattice.
        heights: (N,) the agent's y at each.
        instances: the targets.
    """

    poses: NDArray[np.float32]
    heights: NDArray[np.float64]
    instances: tuple[Instance, ...]


def capture_thor(
    controller: Controller,
    name: str,
    settings: ThorConfig,
    store: RunStore,
    *,
    types: Sequence[str] = (),
    all_types: bool = True,
    actions: Sequence[Action],
    progress: ProgressBar = progress_bar,
) -> ThorCapture:
    """Look from every pose of a lattice over the reachable positions.

    Args:
        controller: of the simulator, in the room.
        name: of the room, such as "FloorPlan1", and of the scene.
        settings: of the lattice and the camera; those the simulator was started with.
        store: where finished work is kept and looked for.
        types: AI2-THOR's types of the targets; all that can be picked up if empty.
        all_types: whether each must be in the room.
        actions: of the scene.
        progress: opens a progress bar for each of the two stages: "views", "target pictures".

    Raises:
        ThorError: if the simulator fails, no position can be reached, or no target is ever seen.
    """
    walk = _begin(controller, settings, store, types, all_types)
    keys = {f"view-{number:05}": number for number in range(len(walk.poses))}
    with progress(f"{name}: views") as report:
        for done, key in enumerate(missing := store.missing(keys), 1):
            _look(controller, walk, keys[key], store, key)
            report(len(keys) - len(missing) + done, len(keys))
    kept = [store.loaded(key) for key in keys]
    there = np.flatnonzero([len(view["image"]) > 0 for view in kept])
    if not len(there):
        raise ThorError(f"AI2-THOR's agent could not be put anywhere in {name}; try another --grid")
    poses = walk.poses[there]
    boxes = np.stack([kept[number]["boxes"] for number in there])
    filled = np.stack([kept[number]["filled"] for number in there])
    places = np.unique(poses[:, :2], axis=0, return_inverse=True)[1].ravel()
    targets: list[tuple[int, Target]] = []
    notes = []
    with progress(f"{name}: target pictures") as report:
        for row, instance in enumerate(walk.instances):
            states, clean = picture_states(boxes[:, row], filled[:, row], places, settings.image_size)
            pictures = _pictures(controller, walk, instance, there[states].tolist(), store, f"target-{row:03}")
            if not pictures:
                notes.append(f"{instance.name} is never seen, it is left out")
            else:
                if not clean:
                    notes.append(f"{instance.name} is seen only small, cut or hidden; its picture is a poor one")
                in_order, held_out = training_first(pictures)
                targets.append((row, Target(instance.name, in_order, instance.category, held_out)))
            report(row + 1, len(walk.instances))
    if not targets:
        raise ThorError(f"none of the targets is seen from anywhere in {name}; name other --targets")
    scene = Scene(
        name=name,
        actions=tuple(actions),
        views=tuple(kept[number]["image"].tobytes() for number in there),
        poses=poses,
        transitions=thor_transitions(poses, actions, settings.grid),
        boxes=boxes[:, [row for row, _ in targets]],
        targets=tuple(target for _, target in targets),
        image_size=settings.image_size,
        fov=settings.fov,
        source=captured_source(name, settings, client_version()),
    )
    return ThorCapture(scene, len(keys) - len(there), tuple(notes))


def client_version() -> str:
    """Version of AI2-THOR's client; "unknown" if it is not installed."""
    try:
        return importlib.metadata.version("ai2thor")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def thor_transitions(poses: NDArray[np.float32], actions: Sequence[Action], grid: float) -> NDArray[np.int32]:
    """The moves between poses: to the neighbouring position if it is one of them, else blocked.

    A move along a diagonal heading leads one cell on along both axes, as in SAVN's captures of these rooms.

    Args:
        poses: (S, 4), headings in steps of 90 or 45 degrees.
        actions: the columns of the result.
        grid: metres between neighbouring positions.

    Returns:
        (S, A) int32.
    """
    transitions = lattice_transitions(poses, actions, grid)
    diagonal = np.flatnonzero(np.round(poses[:, 2] / 45) % 2 == 1)
    moves = np.array([column for column, action in enumerate(actions) if action in MOVE_DIRECTION], np.int64)
    if diagonal.size and moves.size:
        # The lattice counts in sixteenths of a step, of which a diagonal one goes round(16 sin 45) = 11 along each
        # axis: with a step of 16/11 cells that is one cell.
        leads = lattice_transitions(poses[diagonal], [actions[column] for column in moves.tolist()], grid * 16 / 11)
        transitions[np.ix_(diagonal, moves)] = diagonal[leads]
    return transitions


def _begin(
    controller: Controller, settings: ThorConfig, store: RunStore, types: Sequence[str], all_types: bool
) -> _Walk:
    """What is to be done, as it was when the work began: what can be reached follows from where the agent stands."""
    plan = store.load(PLAN)
    if plan is None:
        positions = reachable_positions(controller)
        instances = room_instances(controller.last_event.metadata["objects"], types, all_types=all_types)
        names = np.array([[one.name, one.object_id, one.category] for one in instances], np.str_)
        plan = {"positions": positions, "instances": names}
        store.save(PLAN, **plan)
    positions = plan["positions"]
    poses = lattice_poses(positions[:, [0, 2]], settings.headings, settings.tilts)
    heights = np.repeat(positions[:, 1], len(poses) // len(positions))
    instances = tuple(Instance(*(str(word) for word in row)) for row in plan["instances"])
    there = {str(entry["objectId"]) for entry in controller.last_event.metadata["objects"]}
    if gone := [one.name for one in instances if one.object_id not in there]:
        raise ThorError(
            f"the room has no {', '.join(gone)} any more, it is not the one that the work was begun in; begin anew "
            "with --force"
        )
    return _Walk(poses, heights, instances)


def _at(controller: Controller, walk: _Walk, number: int) -> object | None:
    x, z, heading, tilt = (float(value) for value in walk.poses[number])
    pose: ThorPose = (x, z, heading, tilt)
    return teleport(controller, pose, float(walk.heights[number]))


def _look(controller: Controller, walk: _Walk, number: int, store: RunStore, key: str) -> None:
    """Keep one view; an empty image stands for a pose at which the agent cannot be."""
    event = _at(controller, walk, number)
    if event is None:
        store.save(key, image=np.zeros(0, np.uint8))
        return
    seen = instance_views(event, walk.instances)
    blob = np.frombuffer(encode_image(event_image(event)), np.uint8)
    store.save(key, image=blob, boxes=seen.boxes, filled=seen.filled)


def _pictures(
    controller: Controller, walk: _Walk, instance: Instance, numbers: Sequence[int], store: RunStore, key: str
) -> list[bytes]:
    """An object's pictures, from the store or, where it was seen best, by looking once more."""
    arrays = store.load(key)
    if arrays is None:
        arrays = {}
        for number in numbers:
            event = _at(controller, walk, number)
            picture = None if event is None else object_picture(event, instance)
            if picture is not None:
                arrays[f"picture{len(arrays):02}"] = np.frombuffer(encode_image(picture, "png"), np.uint8)
        store.save(key, **arrays)
    # Seen from far the same from two places, a held-out picture would be one of those trained with.
    return list(dict.fromkeys(blob.tobytes() for _, blob in sorted(arrays.items())))
