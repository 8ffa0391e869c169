"""Scenes of the Active Vision Dataset (Ammirato et al., ICRA 2017): real rooms, photographed on a grid of places.

Read in https://github.com/ammirato/active_vision_dataset_processing (`data_loading/`, `visualizations/`). A folder
`Home_001_1` holds `jpg_rgb/NAME.jpg`, 1920 x 1080; `annotations.json`, {name: {"bounding_boxes": [[left, top, right,
bottom, instance, difficulty], ...], "forward", "backward", "left", "right", "rotate_cw", "rotate_ccw": the next name,
"" where there is none}}; `image_structs.mat`, see `poses.py`. `instance_id_map.txt`, "<name> <id>" in each line,
lies in the folder or beside it. Moves go 0.3 m, turns 30 degrees; nothing tilts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.datasets.avd.poses import MOVES, place_views, read_poses
from active_perceiver.datasets.io import (
    Imported,
    against_poses,
    boxes_of_corners,
    check_image_size,
    encoded_view,
    entry,
    numbers,
    read_json,
)
from active_perceiver.datasets.target_pictures import crop_pictures, found_pictures, pictured_target
from active_perceiver.scenes.images import read_image
from active_perceiver.scenes.lattice import Action
from active_perceiver.scenes.scene import Scene, SceneError, Target
from active_perceiver.utils.progress import ProgressCallback, quiet

TOO_DIFFICULT = 5
"""Boxes of this difficulty and above are of crowds, or hardly to be seen; the project's own code leaves them out."""
IMAGES, ANNOTATIONS = "jpg_rgb", "annotations.json"
INSTANCE_FILES = ("instance_id_map.txt", "all_instance_id_map.txt")

# Measured poses are askew by some degrees; turns are of 30.
_TOLERANCE = 14.0


@dataclass(frozen=True, eq=False)
class _Boxes:
    """The boxes of all views.

    Attributes:
        names: (T,) of the instances.
        corners: (S, T, 4) left, top, right, bottom in pixels, NaN where not visible.
    """

    names: tuple[str, ...]
    corners: NDArray[np.float64]


def import_avd(
    folder: Path,
    *,
    name: str | None = None,
    image_size: int = 300,
    fov: float = 84.1,
    targets: Sequence[str] = (),
    pictures: Path | None = None,
    progress: ProgressCallback = quiet,
) -> Imported:
    """Make a scene of a folder.

    Args:
        folder: of the scene.
        name: of the scene; the folder's if not given.
        image_size: side of the views in pixels; the photographs, wider than high, are padded to squares.
        fov: the camera's field of view across the width, in degrees; 84.1 is what Kinect v2's is said to be.
        targets: names of instances; all that have boxes if none are given.
        pictures: folder with pictures of instances, see `found_pictures`; those without any are cropped from views.
        progress: called with the number of views done and of all.

    Raises:
        SceneError: if a file is missing, damaged or not of this format; the message names it and the place in it.
        ImageError: if a photograph or picture cannot be read.
    """
    check_image_size(image_size)
    annotations, notes = _annotations(folder)
    names = tuple(annotations)
    moves, transitions = _transitions(annotations, folder / ANNOTATIONS, notes)
    measured = read_poses(folder / "image_structs.mat", names, transitions, moves, notes)
    poses = place_views(measured, transitions, moves, notes)
    kept = np.flatnonzero(np.isfinite(poses).all(1))
    if not len(kept):
        raise SceneError(f"{folder / 'image_structs.mat'} has a pose of none of the {len(names)} photographs")
    poses, transitions = poses[kept], _among(transitions, kept)
    names = tuple(names[row] for row in kept)
    wrong = against_poses(poses, transitions, moves, _TOLERANCE)
    if wrong.any():
        goes = int((transitions != np.arange(len(kept))[:, None]).sum())
        notes.append(f"{int(wrong.sum())} of {goes} moves do not lead where the poses say; the moves are taken")
    boxes = _boxes(annotations, names, _instances(folder, notes), targets, folder / ANNOTATIONS, notes)
    views, sizes = _views(folder, names, image_size, progress)
    columns, chosen = _targets(boxes, folder, names, sizes, pictures, notes)
    scene = Scene(
        name=name or folder.name,
        actions=moves,
        views=views,
        poses=poses.astype(np.float32),
        transitions=transitions,
        boxes=_in_squares(boxes.corners[:, columns], sizes, image_size, notes),
        targets=chosen,
        image_size=image_size,
        fov=fov,
        source=f"Active Vision Dataset, {folder.name}",
    )
    return Imported(scene, tuple(notes))


def _annotations(folder: Path) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """What `annotations.json` says of each photograph that is there, in the order of their names."""
    path = folder / ANNOTATIONS
    content = read_json(path)
    if not isinstance(content, dict) or not content:
        raise SceneError(f"{path} should be a JSON object with an entry for each photograph, and has none")
    if not (folder / IMAGES).is_dir():
        raise SceneError(f"there is no folder {IMAGES} in {folder}; it holds the photographs")
    there = {file.name for file in (folder / IMAGES).iterdir()}
    annotations = {name: entry(content, name, dict, str(path)) for name in sorted(content) if name in there}
    if not annotations:
        raise SceneError(f"{folder / IMAGES} has none of the {len(content)} photographs that {path} names")
    notes = []
    if missing := len(content) - len(annotations):
        notes.append(f"{missing} photographs that {ANNOTATIONS} names are not in {IMAGES}; they are left out")
    if extra := len(there) - len(annotations):
        notes.append(f"{extra} files in {IMAGES} are not in {ANNOTATIONS}; they are left out")
    return annotations, notes


def _transitions(
    annotations: Mapping[str, dict[str, Any]], path: Path, notes: list[str]
) -> tuple[tuple[Action, ...], NDArray[np.int32]]:
    """The moves that occur, and where they lead."""
    row_of = {name: row for row, name in enumerate(annotations)}
    transitions = np.tile(np.arange(len(row_of), dtype=np.int32)[:, None], (1, len(MOVES)))
    nowhere = 0
    for name, row in row_of.items():
        for column, key in enumerate(MOVES):
            following = entry({key: "", **annotations[name]}, key, str, f"{path}, {name}")
            transitions[row, column] = row_of.get(following, row)
            nowhere += bool(following) and following not in row_of
    if nowhere:
        notes.append(f"{nowhere} moves lead to photographs that are not there; they are blocked")
    used = np.flatnonzero((transitions != np.arange(len(row_of))[:, None]).any(0))
    if not len(used):
        raise SceneError(f"{path} has no move from one photograph to another; a robot could not move")
    actions = tuple(MOVES.values())
    return tuple(actions[column] for column in used), transitions[:, used]


def _among(transitions: NDArray[np.int32], kept: NDArray[np.int64]) -> NDArray[np.int32]:
    """The moves among some of the states; those that lead to others are blocked."""
    number = np.full(len(transitions), -1, np.int32)
    number[kept] = np.arange(len(kept))
    following = number[transitions[kept]]
    return np.where(following < 0, np.arange(len(kept), dtype=np.int32)[:, None], following)


def _instances(folder: Path, notes: list[str]) -> dict[int, str]:
    """Names of instances by their number."""
    paths = [where / name for where in (folder, folder.absolute().parent) for name in INSTANCE_FILES]
    path = next((path for path in paths if path.is_file()), None)
    if path is None:
        notes.append(
            f"there is no {INSTANCE_FILES[0]} in {folder} or beside it; instances are called by their numbers"
        )
        return {}
    names: dict[int, str] = {}
    try:
        lines = path.read_text("utf-8").splitlines()
    except UnicodeDecodeError:
        raise SceneError(f"{path} is not a text file; its lines should be '<name> <id>'") from None
    for number, line in enumerate(lines, 1):
        parts = line.split()
        if not parts:
            continue
        if len(parts) != 2 or not (parts[1].isascii() and parts[1].isdigit() and len(parts[1]) < 10):
            raise SceneError(f"{path}, line {number}: expected '<name> <id>', got {line[:60]!r}")
        names[int(parts[1])] = parts[0].replace("/", "_")
    if len(set(names.values())) != len(names):
        raise SceneError(f"{path} gives two instances the same name")
    return names


def _boxes(
    annotations: Mapping[str, dict[str, Any]],
    names: Sequence[str],
    known: Mapping[int, str],
    wanted: Sequence[str],
    path: Path,
    notes: list[str],
) -> _Boxes:
    """The boxes of the wanted instances, the largest where a view has several of one."""
    found: dict[int, dict[int, list[float]]] = {}
    difficult = several = 0
    for row, name in enumerate(names):
        for number, box in enumerate(entry(annotations[name], "bounding_boxes", list, f"{path}, {name}")):
            where = f"{path}, {name}, bounding_boxes {number}"
            left, top, right, bottom, instance, difficulty = numbers(box, 6, where)
            if not (left < right and top < bottom) or instance % 1:
                raise SceneError(f"{where}: left, top, right, bottom, instance do not fit together: {box!r:.60}")
            if difficulty >= TOO_DIFFICULT:
                difficult += 1
                continue
            rows = found.setdefault(int(instance), {})
            if row in rows:
                several += 1
                if _area(rows[row]) >= _area([left, top, right, bottom]):
                    continue
            rows[row] = [left, top, right, bottom]
    if difficult:
        notes.append(f"{difficult} boxes of difficulty {TOO_DIFFICULT} and above (crowds) are left out")
    if several:
        notes.append(f"{several} boxes are of instances with a larger box in the same view; they are left out")
    called = {instance: known.get(instance, f"instance_{instance}") for instance in sorted(found)}
    for name in wanted:
        if name not in called.values():
            raise SceneError(f"{path} has no boxes of '{name}'; there are {', '.join(called.values()) or 'none'}")
    chosen = {instance: name for instance, name in called.items() if not wanted or name in wanted}
    corners = np.full((len(names), len(chosen), 4), np.nan)
    for column, instance in enumerate(chosen):
        for row, box in found[instance].items():
            corners[row, column] = box
    return _Boxes(tuple(chosen.values()), corners)


def _area(box: Sequence[float]) -> float:
    return (box[2] - box[0]) * (box[3] - box[1])


def _views(
    folder: Path, names: Sequence[str], size: int, progress: ProgressCallback
) -> tuple[tuple[bytes, ...], NDArray[np.int64]]:
    """Encoded views and (S, 2) width and height of the photographs."""
    views, sizes = [], []
    for name in names:
        image = read_image(folder / IMAGES / name)
        views.append(encoded_view(image, size))
        sizes.append((image.shape[1], image.shape[0]))
        progress(len(views), len(names))
    return tuple(views), np.array(sizes)


def _targets(
    boxes: _Boxes,
    folder: Path,
    names: Sequence[str],
    sizes: NDArray[np.int64],
    pictures: Path | None,
    notes: list[str],
) -> tuple[list[int], tuple[Target, ...]]:
    """Which columns of the boxes become targets, and these."""
    found = found_pictures(pictures, boxes.names) if pictures is not None else {}
    left = [index for index, name in enumerate(boxes.names) if name not in found]
    cropped = crop_pictures(
        [boxes.names[index] for index in left],
        boxes.corners[:, left],
        sizes,
        lambda row: read_image(folder / IMAGES / names[row]),
    )
    if cropped:
        notes.append(f"the pictures of {', '.join(cropped)} are cropped from the views that are searched")
    found |= cropped
    if bare := [name for name in boxes.names if name not in found]:
        notes.append(f"{', '.join(bare)} have neither a picture nor a clean box to crop one from; they are left out")
    columns = [index for index, name in enumerate(boxes.names) if name in found]
    return columns, tuple(pictured_target(boxes.names[i], found[boxes.names[i]], boxes.names[i]) for i in columns)


def _in_squares(
    corners: NDArray[np.float64], sizes: NDArray[np.int64], image_size: int, notes: list[str]
) -> NDArray[np.float32]:
    boxes = boxes_of_corners(corners, sizes, image_size)
    if outside := int((np.isnan(boxes) & ~np.isnan(corners)).all(-1).sum()):
        notes.append(f"{outside} boxes lie outside their photographs; they are left out")
    return boxes
