"""The objects of a folder of offline AI2-THOR data: where each is visible, and its boxes if there are any."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.datasets.io import entry, numbers, read_json
from active_perceiver.scenes.scene import SceneError

DETECTIONS = "instance_detections2D"


@dataclass(frozen=True, eq=False)
class SeenObjects:
    """What a folder says of some objects.

    Attributes:
        names: (T,) unique: the type, numbered where a scene has several of it.
        types: (T,) such as "Mug".
        places: (T,) x, z in metres; NaN if the object's id does not say.
        visible: (T,) numbers of the states from which each is visible.
        corners: (S, T, 4) left, top, right, bottom in pixels, NaN where not detected; None if there are no boxes.
    """

    names: tuple[str, ...]
    types: tuple[str, ...]
    places: tuple[tuple[float, float], ...]
    visible: tuple[NDArray[np.int64], ...]
    corners: NDArray[np.float64] | None


def read_objects(
    folder: Path, row_of: Mapping[str, int], states: int, wanted: Sequence[str], notes: list[str]
) -> SeenObjects:
    """Read `metadata.json`, or `visible_object_map.json` if there is none or it has no boxes.

    Args:
        folder: of the scene.
        row_of: the number of each state by its name.
        states: how many there are.
        wanted: types of objects; all if none are given.
        notes: sentences on what was left out are added to these.

    Raises:
        SceneError: if a file is malformed, or no object is of a wanted type.
    """
    visible, boxes = _read(folder, row_of, notes)
    ids = sorted(set(visible) | set(boxes))
    types = {one: one.split("|")[0] for one in ids}
    for kind in wanted:
        if kind not in types.values():
            known = ", ".join(sorted(set(types.values()))) or "no objects at all"
            raise SceneError(f"{folder} has no object of the type '{kind}'; there are {known}")
    chosen = [one for one in ids if (not wanted or types[one] in wanted) and (not boxes or boxes.get(one))]
    corners = None
    if boxes:
        corners = np.full((states, len(chosen), 4), np.nan)
        for column, one in enumerate(chosen):
            for row, box in boxes[one].items():
                corners[row, column] = box
    return SeenObjects(
        names=_names([types[one] for one in chosen]),
        types=tuple(types[one] for one in chosen),
        places=tuple(_place(one) for one in chosen),
        visible=tuple(np.array(sorted(visible.get(one, ())), np.int64) for one in chosen),
        corners=corners,
    )


def _read(
    folder: Path, row_of: Mapping[str, int], notes: list[str]
) -> tuple[dict[str, set[int]], dict[str, dict[int, list[float]]]]:
    """States by object, and boxes by object and state."""
    metadata, simple = folder / "metadata.json", folder / "visible_object_map.json"
    path = metadata if metadata.is_file() else simple
    content = read_json(path)
    if not isinstance(content, dict):
        raise SceneError(f"{path} should be a JSON object, got {type(content).__name__}")
    # As in the project's own loader, either file may hold either thing; a state's name begins with a number.
    if next(iter(content), "").split("|")[0].lstrip("+-").replace(".", "", 1).isdigit():
        return _from_metadata(content, path, row_of)
    visible: dict[str, set[int]] = {}
    unknown = 0
    for one in content:
        found = entry(content, one, list, str(path))
        known = {row_of[state] for state in found if isinstance(state, str) and state in row_of}
        unknown += sum(not isinstance(state, str) or state not in row_of for state in found)
        visible[one] = known
    if unknown:
        notes.append(f"{unknown} times {path.name} names a state that is not in graph.json or has no image")
    return visible, {}


def _from_metadata(
    content: dict[str, Any], path: Path, row_of: Mapping[str, int]
) -> tuple[dict[str, set[int]], dict[str, dict[int, list[float]]]]:
    visible: dict[str, set[int]] = {}
    boxes: dict[str, dict[int, list[float]]] = {}
    for state, row in row_of.items():
        if state not in content:
            continue
        where = f"{path}, state {state}"
        record = entry(content, state, dict, str(path))
        for number, one in enumerate(entry(record, "objects", list, where) if "objects" in record else []):
            name = entry(one, "objectId", str, f"{where}, object {number}")
            visible.setdefault(name, set())
            if entry(one, "visible", bool, f"{where}, object {number}"):
                visible[name].add(row)
        if DETECTIONS in record:
            for name, box in entry(record, DETECTIONS, dict, where).items():
                boxes.setdefault(name, {})[row] = numbers(box, 4, f"{where}, {DETECTIONS} of {name}")
    return visible, boxes


def _names(types: Sequence[str]) -> tuple[str, ...]:
    """The types, numbered where there are several."""
    count, so_far = Counter(types), Counter[str]()
    names = []
    for kind in types:
        so_far[kind] += 1
        names.append(kind if count[kind] == 1 else f"{kind}_{so_far[kind]}")
    return tuple(names)


def _place(one: str) -> tuple[float, float]:
    """X and z of an object with the id "Type|+x|+y|+z"."""
    parts = one.split("|")
    try:
        return float(parts[1]), float(parts[3])
    except (IndexError, ValueError):
        return np.nan, np.nan
