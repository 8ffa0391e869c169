"""Folders of offline AI2-THOR data as SAVN (Wortsman et al., CVPR 2019) and what builds on it use.

Read in https://github.com/allenai/savn, `datasets/offline_controller_with_small_rotation.py`. A folder
`FloorPlan1_physics` (without the suffix for FloorPlan3xx and 4xx) holds `graph.json`, a networkx node-link graph of
states "x|z|rotation|horizon" (metres, degrees, horizon down positive), an edge wherever one action leads;
`images.hdf5`, a dataset (H, W, 3) uint8 per state; `visible_object_map.json`, {object: [state, ...]}; optional
`metadata.json`, {state: AI2-THOR's metadata}, which may carry boxes, `instance_detections2D`. Which action an edge
stands for follows from its two poses, so that headings 45 degrees apart, on which a move goes one cell along both
axes, need no rule of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from active_perceiver.datasets.io import (
    ALL_ACTIONS,
    Imported,
    actions_between,
    boxes_of_corners,
    check_image_size,
    check_pixels,
    dataset,
    encoded_view,
    entry,
    read_json,
    turned,
)
from active_perceiver.datasets.savn.objects import SeenObjects, read_objects
from active_perceiver.datasets.target_pictures import crop_pictures, found_pictures, pictured_target
from active_perceiver.scenes.hdf5 import open_hdf5
from active_perceiver.scenes.hdf5_values import read_whole
from active_perceiver.scenes.lattice import Action
from active_perceiver.scenes.scene import Scene, SceneError, Target
from active_perceiver.utils.progress import ProgressCallback, quiet

SUFFIX = "_physics"


@dataclass(frozen=True, eq=False)
class _States:
    """The states of a folder.

    Attributes:
        keys: (S,) of the images.
        poses: (S, 4).
        row_of: the number of each node of the graph, also of nodes that only differ in how they are written.
    """

    keys: tuple[str, ...]
    poses: NDArray[np.float64]
    row_of: dict[str, int]


def import_savn(
    folder: Path,
    *,
    name: str | None = None,
    image_size: int = 300,
    fov: float = 90.0,
    targets: Sequence[str] = (),
    pictures: Path | None = None,
    progress: ProgressCallback = quiet,
) -> Imported:
    """Make a scene of a folder.

    If `metadata.json` carries boxes, its objects are targets. If not, nobody knows where in a view an object is, and
    so not which views show it largest: the scene has only views to search for, and a note says from which state each
    object is seen best.

    Args:
        folder: of the scene, with or without the suffix "_physics".
        name: of the scene; the folder's without the suffix if not given.
        image_size: side of the views in pixels.
        fov: the camera's field of view in degrees; the files do not say it.
        targets: types of objects, such as "Mug"; all if none are given.
        pictures: folder with pictures of objects, see `found_pictures`; objects without any are cropped from views.
        progress: called with the number of views done and of all.

    Raises:
        SceneError: if a file is missing, damaged or not of this format; the message names it and the place in it.
    """
    check_image_size(image_size)
    folder = scene_folder(folder)
    path = folder / "images.hdf5"
    if not path.is_file() and (folder / "resnet18_featuremap.hdf5").is_file():
        raise SceneError(
            f"{folder} has features but no images.hdf5, and views cannot be made of features; write the images with "
            "the project's ExhaustiveBFSController"
        )
    nodes, edges = read_graph(folder / "graph.json")
    with open_hdf5(path) as images:
        states, notes = _states(nodes, images, folder)
        actions, transitions = _transitions(states, edges, folder / "graph.json", notes)
        objects = read_objects(folder, states.row_of, len(states.keys), targets, notes)
        views, sizes = _views(images, states, path, image_size, progress)
        kept, boxes = _targets(objects, images, states, sizes, image_size, pictures, notes)
    scene = Scene(
        name=name or folder.name.removesuffix(SUFFIX),
        actions=actions,
        views=views,
        poses=states.poses.astype(np.float32),
        transitions=transitions,
        boxes=boxes,
        targets=kept,
        image_size=image_size,
        fov=fov,
        source=f"offline AI2-THOR data, {folder.name}",
    )
    if not kept:
        notes.append(_best_views(objects, states))
    return Imported(scene, tuple(notes))


def scene_folder(folder: Path) -> Path:
    """The folder of a scene, whether or not its name was given with the suffix that some of them have.

    Raises:
        SceneError: if there is neither.
    """
    plain = folder.name.removesuffix(SUFFIX)
    for name in (folder.name, plain, plain + SUFFIX):
        if folder.with_name(name).is_dir():
            return folder.with_name(name)
    raise SceneError(f"there is no folder {folder}, nor {plain} or {plain}{SUFFIX} beside it")


def read_graph(path: Path) -> tuple[list[str], list[tuple[str, str]]]:
    """Nodes and edges of a networkx node-link graph.

    The edges are called "links" or, since networkx 3.4, "edges"; before networkx 2 they named nodes by their number;
    a graph that is not directed has each both ways.

    Raises:
        SceneError: if the file is none.
    """
    graph = read_json(path)
    nodes = [
        entry(node, "id", str, f"{path}, node {i}") for i, node in enumerate(entry(graph, "nodes", list, str(path)))
    ]
    if len(set(nodes)) != len(nodes) or not nodes:
        raise SceneError(f"{path} has no nodes, or names one twice")
    key = "links" if "links" in graph else "edges"
    known = set(nodes)
    edges = []
    for number, link in enumerate(entry(graph, key, list, str(path))):
        ends = []
        for end in ("source", "target"):
            node = entry(link, end, (str, int), f"{path}, {key} {number}")
            if isinstance(node, int) and 0 <= node < len(nodes):
                node = nodes[node]
            if node not in known:
                raise SceneError(f"{path}, {key} {number}: there is no node {node!r:.60}")
            ends.append(node)
        edges.append((ends[0], ends[1]))
    if graph.get("directed", True) is False:
        edges += [(end, start) for start, end in edges]
    return nodes, edges


def parsed_state(node: str) -> tuple[float, float, float, float] | None:
    """The pose that a state's name stands for, in this software's frame; None if it is no such name."""
    try:
        x, z, rotation, horizon = (float(part) for part in node.split("|"))
    except ValueError:
        return None
    if not np.isfinite([x, z, rotation, horizon]).all() or max(abs(x), abs(z)) > 1e4:
        return None
    # Adding zero makes 0.0 of -0.0: "-0.00" and "0.00" are the same place. Horizons count downwards.
    return round(x, 2) + 0.0, round(z, 2) + 0.0, rotation % 360, turned(np.array(-horizon)).item() + 0.0


def _states(nodes: Sequence[str], images: h5py.File, folder: Path) -> tuple[_States, list[str]]:
    keys: list[str] = []
    rows: dict[tuple[float, ...], int] = {}
    row_of = {}
    poses = {}
    for node in nodes:
        pose = parsed_state(node)
        if pose is None:
            raise SceneError(f"{folder / 'graph.json'}: node '{node:.60}' is no state x|z|rotation|horizon")
        poses[node] = pose
        if node in images and pose not in rows:
            rows[pose] = len(keys)
            keys.append(node)
    for node, pose in poses.items():
        if pose in rows:
            row_of[node] = rows[pose]
    notes = []
    if not keys:
        raise SceneError(f"{folder / 'images.hdf5'} has an image of none of the {len(nodes)} nodes of graph.json")
    if missing := len(nodes) - len(row_of):
        notes.append(
            f"{missing} nodes of graph.json have no image in images.hdf5; they are left out, with their moves"
        )
    if twice := len(row_of) - len(keys):
        notes.append(
            f"{twice} nodes of graph.json are the same poses as others, written otherwise; they are one state"
        )
    return _States(tuple(keys), np.array(list(rows)), row_of), notes


def _transitions(
    states: _States, edges: Sequence[tuple[str, str]], path: Path, notes: list[str]
) -> tuple[tuple[Action, ...], NDArray[np.int32]]:
    pairs = np.array(
        [(states.row_of[a], states.row_of[b]) for a, b in edges if a in states.row_of and b in states.row_of],
        np.int64,
    ).reshape(-1, 2)
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    before, after = states.poses[pairs[:, 0]], states.poses[pairs[:, 1]]
    action = actions_between(before, after)
    if unknown := int((action < 0).sum()):
        notes.append(f"{unknown} of {len(pairs)} edges of graph.json are no move, turn or look; they are left out")
    actions = tuple(ALL_ACTIONS[number] for number in np.unique(action[action >= 0]))
    if not actions:
        raise SceneError(f"{path}: no edge is a move between two states with images; a robot could not move")
    # Where two edges stand for the same action, the shorter one is written last.
    change = after - before
    length = np.hypot(change[:, 0], change[:, 1]) + np.abs(turned(change[:, 2])) + np.abs(change[:, 3])
    transitions = np.tile(np.arange(len(states.keys), dtype=np.int32)[:, None], (1, len(actions)))
    taken = 0
    for column, name in enumerate(actions):
        rows = np.flatnonzero(action == ALL_ACTIONS.index(name))
        rows = rows[np.argsort(-length[rows], kind="stable")]
        transitions[pairs[rows, 0], column] = pairs[rows, 1]
        taken += len(np.unique(pairs[rows, 0]))
    if longer := int((action >= 0).sum()) - taken:
        notes.append(f"{longer} edges of graph.json do the same as a shorter one; they are left out")
    return actions, transitions


def _views(
    images: h5py.File, states: _States, path: Path, size: int, progress: ProgressCallback
) -> tuple[tuple[bytes, ...], NDArray[np.int64]]:
    """Encoded views and (S, 2) width and height of the images."""
    views, sizes = [], []
    for key in states.keys:
        image = _image(images, key, path)
        views.append(encoded_view(image, size))
        sizes.append((image.shape[1], image.shape[0]))
        progress(len(views), len(states.keys))
    return tuple(views), np.array(sizes)


def _image(images: h5py.File, key: str, path: Path) -> NDArray[np.uint8]:
    found = dataset(images, key, (None, None, 3), "u", path)
    check_pixels(found.shape, f"{path}: '{key}'")
    if found.dtype != np.uint8:
        raise SceneError(f"{path}: '{key}' is of type {found.dtype}, expected uint8")
    return np.asarray(read_whole(found, f"{path}: "))


def _targets(
    objects: SeenObjects,
    images: h5py.File,
    states: _States,
    sizes: NDArray[np.int64],
    image_size: int,
    folder: Path | None,
    notes: list[str],
) -> tuple[tuple[Target, ...], NDArray[np.float32]]:
    """What can be searched for, and its boxes."""
    none = np.zeros((len(states.keys), 0, 4), np.float32)
    if objects.corners is None:
        notes.append(
            "there are no boxes (metadata.json with instance_detections2D): where in a view an object is, is not "
            "known, so the scene has no objects to search for, only views (train --task view)"
        )
        if folder is not None:
            notes.append(f"pictures in {folder} were not used: without boxes there are no objects to search for")
        return (), none
    pictures = found_pictures(folder, objects.names) if folder is not None else {}
    left = [name for name in objects.names if name not in pictures]
    columns = [objects.names.index(name) for name in left]
    path = Path(images.filename)
    cropped = crop_pictures(
        left, objects.corners[:, columns], sizes, lambda row: _image(images, states.keys[row], path)
    )
    pictures |= cropped
    if cropped:
        notes.append(f"the pictures of {', '.join(cropped)} are cropped from the views that are searched")
    if bare := [name for name in objects.names if name not in pictures]:
        notes.append(f"{', '.join(bare)} have neither a picture nor a clean box to crop one from; they are left out")
    kept = [index for index, name in enumerate(objects.names) if name in pictures]
    targets = tuple(
        pictured_target(objects.names[index], pictures[objects.names[index]], objects.types[index]) for index in kept
    )
    return targets, boxes_of_corners(objects.corners[:, kept], sizes, image_size)


def _best_views(objects: SeenObjects, states: _States) -> str:
    """A note on which state shows each object best: near, and in the middle."""
    best: dict[str, Any] = {}
    for name, rows, place in zip(objects.names, objects.visible, objects.places, strict=True):
        if len(rows):
            poses = states.poses[rows]
            toward = np.array(place) - poses[:, :2]
            off = np.abs(turned(np.degrees(np.arctan2(toward[:, 0], toward[:, 1])) - poses[:, 2]))
            best[name] = int(rows[np.argmin(np.hypot(toward[:, 0], toward[:, 1]) * (1 + off / 30.0))])
    if not best:
        return "no object is said to be visible from any state"
    shown = ", ".join(f"{name} {state}" for name, state in sorted(best.items()))
    return f"the states from which objects are seen best, for --targets of train --task view: {shown}"
