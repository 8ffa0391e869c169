"""Scene files: HDF5, format "active-perceiver-scene", version 1.

Layout: attributes `format`, `version`, `name`, `actions` (JSON list), `image_size`, `fov`, `source`; datasets
`views` (S,) variable-length uint8, `poses` (S, 4) float32, `transitions` (S, A) int32, `boxes` (S, T, 4) float32;
groups `targets/<name>` with `pictures` (K,) variable-length uint8 and attributes `category`, `index` and `held_out`:
the last so many pictures are never trained with (0 if the attribute is not there, as in older files); optional
dataset `labels` (S,) uint8, see `Scene.labels` (all views are labelled if it is not there); optional group
`floor_plan` with `outline` and `obstacles/<number>`. Nothing in a file is executed when it is read.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes.floor_plan import FloorPlan
from active_perceiver.scenes.hdf5 import create_hdf5, h5py_module, open_hdf5
from active_perceiver.scenes.hdf5_values import MemoryBudget, read_attribute, read_blobs, read_whole
from active_perceiver.scenes.lattice import Action
from active_perceiver.scenes.scene import Scene, SceneError, Target
from active_perceiver.utils.files import replacing

if TYPE_CHECKING:
    import h5py

FORMAT = "active-perceiver-scene"
VERSION = 1


def save_scene(scene: Scene, path: Path | str, *, force: bool = False) -> None:
    """Write a scene file, atomically.

    Args:
        scene: what to write.
        path: where to; parent folders are made.
        force: replace an existing file.

    Raises:
        OutputExistsError: if the file exists and `force` is false.
        SceneError: if h5py is not installed.
    """
    h5py_module()  # said before anything is written if it is not there
    with replacing(Path(path), force) as temporary, create_hdf5(temporary) as file:
        file.attrs.update(
            format=FORMAT,
            version=VERSION,
            name=scene.name,
            actions=json.dumps([action.value for action in scene.actions]),
            image_size=scene.image_size,
            fov=scene.fov,
            source=scene.source,
        )
        _write_blobs(file, "views", scene.views)
        for label in ("poses", "transitions", "boxes"):
            file.create_dataset(label, data=getattr(scene, label), compression="gzip")
        if scene.labels is not None:
            file.create_dataset("labels", data=scene.labels)
        for index, target in enumerate(scene.targets):
            group = file.create_group(f"targets/{target.name}")
            group.attrs.update(category=target.category, index=index, held_out=target.held_out)
            _write_blobs(group, "pictures", target.pictures)
        if scene.floor_plan is not None:
            group = file.create_group("floor_plan")
            group["outline"] = scene.floor_plan.outline
            for index, (label, polygon) in enumerate(scene.floor_plan.obstacles):
                group[f"obstacles/{index}"] = polygon
                group[f"obstacles/{index}"].attrs["label"] = label


def load_scene(path: Path | str) -> Scene:
    """Read a scene file and check it.

    Raises:
        SceneError: if the file is missing, not HDF5, truncated, of another format or version, or not sound.
        SceneError: if h5py is not installed.
    """
    path = Path(path)
    if not path.is_file():
        raise SceneError(f"there is no scene file {path}; see `active-perceiver scenes list` for bundled scenes")
    with open_hdf5(path) as file:
        try:
            return _read(file, MemoryBudget.of(path.stat().st_size))
        except SceneError as error:
            raise SceneError(f"{path}: {error}") from None


def _read(file: h5py.File, budget: MemoryBudget) -> Scene:
    if _attribute(file, "format", str) != FORMAT:
        raise SceneError(f"not a scene file (its format is {read_attribute(file, 'format')!r:.40}, not {FORMAT!r})")
    version = _attribute(file, "version", int)
    if version != VERSION:
        raise SceneError(f"has scene format version {version}; this software reads version {VERSION}: update it")
    groups = file.get("targets", {})
    names = sorted(groups, key=lambda name: _attribute(groups[name], "index", int))
    return Scene(
        name=_attribute(file, "name", str),
        actions=_actions(_attribute(file, "actions", str)),
        views=_read_blobs(file, "views", budget),
        poses=_floats(file, "poses", budget),
        transitions=_whole_numbers(file, "transitions", np.int32, budget),
        boxes=_floats(file, "boxes", budget),
        targets=tuple(_read_target(name, groups[name], budget) for name in names),
        image_size=_attribute(file, "image_size", int),
        fov=float(_attribute(file, "fov", (int, float))),
        source=_attribute(file, "source", str),
        floor_plan=_read_floor_plan(file, budget),
        labels=_whole_numbers(file, "labels", np.uint8, budget) if "labels" in file else None,
    )


def _attribute(holder: h5py.HLObject, name: str, kind: type | tuple[type, ...]) -> Any:
    value = read_attribute(holder, name)
    if isinstance(value, np.generic):
        value = value.item()
    if not isinstance(value, kind):
        where = str(holder.name).strip("/") or "the file"
        expected = {str: "a text", int: "a whole number"}.get(kind if isinstance(kind, type) else float, "a number")
        raise SceneError(f"attribute '{name}' of {where} is {' '.join(repr(value).split()):.60}, expected {expected}")
    return value


def _array(group: h5py.Group, name: str) -> h5py.Dataset:
    """A dataset of numbers that can be read."""
    found = group[name]
    if not isinstance(found, h5py_module().Dataset) or found.shape is None or found.dtype.kind not in "iufO":
        raise SceneError(f"'{name}' is not a dataset of numbers")
    return found


def _floats(group: h5py.Group, name: str, budget: MemoryBudget) -> NDArray[np.float32]:
    found = _array(group, name)
    if found.dtype.kind == "O":
        raise SceneError(f"{name} are {found.dtype}, expected numbers")
    with np.errstate(over="ignore"):  # what is too large becomes infinite, and is refused
        return np.asarray(read_whole(found, budget=budget)).astype(np.float32)


def _whole_numbers(group: h5py.Group, name: str, kind: type[np.integer], budget: MemoryBudget) -> NDArray[Any]:
    found = _array(group, name)
    if found.dtype.kind not in "iu":
        raise SceneError(f"{name} are {found.dtype}, expected whole numbers")
    numbers = np.asarray(read_whole(found, budget=budget))
    converted = numbers.astype(kind)
    if (converted != numbers).any():
        raise SceneError(f"some of the {name} are too large or negative")
    return converted


def _read_target(name: str, group: h5py.Group, budget: MemoryBudget) -> Target:
    held_out = _attribute(group, "held_out", int) if "held_out" in group.attrs else 0
    return Target(name, _read_blobs(group, "pictures", budget), _attribute(group, "category", str), held_out)


def _actions(text: str) -> tuple[Action, ...]:
    known = {action.value: action for action in Action}
    names = json.loads(text)
    if not isinstance(names, list) or not names:
        raise SceneError(f"actions are {text:.60}, expected a list of names")
    if unknown := [name for name in names if name not in known]:
        raise SceneError(f"unknown actions {unknown!s:.80}; known are {sorted(known)}")
    return tuple(known[name] for name in names)


def _read_floor_plan(file: h5py.File, budget: MemoryBudget) -> FloorPlan | None:
    if "floor_plan" not in file:
        return None
    group = file["floor_plan"]
    obstacles = group.get("obstacles", {})
    return FloorPlan(
        outline=_polygon(group, "outline", budget),
        obstacles=tuple(
            (_attribute(obstacles[key], "label", str), _polygon(obstacles, key, budget))
            for key in sorted(obstacles, key=int)
        ),
    )


def _polygon(group: h5py.Group, name: str, budget: MemoryBudget) -> NDArray[np.float64]:
    found = _array(group, name)
    points: NDArray[Any] = np.asarray(read_whole(found, budget=budget))
    if points.dtype.kind == "O" or points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise SceneError(f"floor_plan: '{name}' has shape {points.shape}, expected rows of two finite numbers")
    return points


def _write_blobs(group: h5py.Group, name: str, blobs: Sequence[bytes]) -> None:
    dataset = group.create_dataset(name, (len(blobs),), dtype=h5py_module().vlen_dtype(np.uint8))
    for index, blob in enumerate(blobs):
        dataset[index] = np.frombuffer(blob, np.uint8)


def _read_blobs(group: h5py.Group, name: str, budget: MemoryBudget) -> tuple[bytes, ...]:
    found = _array(group, name)
    if h5py_module().check_vlen_dtype(found.dtype) != np.uint8 or found.ndim != 1:
        raise SceneError(f"'{name}' is {found.dtype} of shape {found.shape}, expected a list of encoded images")
    return read_blobs(found, budget)
