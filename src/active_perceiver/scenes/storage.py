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

import h5py
import numpy as np

from active_perceiver.files import replacing
from active_perceiver.scenes.lattice import Action
from active_perceiver.scenes.scene import FloorPlan, Scene, SceneError, Target

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
    """
    with replacing(Path(path), force) as temporary, h5py.File(temporary, "w") as file:
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
    """
    path = Path(path)
    if not path.is_file():
        raise SceneError(f"there is no scene file {path}; see `active-perceiver scenes list` for bundled scenes")
    try:
        with h5py.File(path, "r") as file:
            return _read(file, path)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None
    except (OSError, RuntimeError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise SceneError(
            f"{path} is not a readable HDF5 file ({reason}); it may be truncated, copy it again"
        ) from None
    except (KeyError, ValueError, TypeError) as error:
        raise SceneError(f"{path} is damaged or not a scene of version {VERSION}: {error}") from None


def _read(file: h5py.File, path: Path) -> Scene:
    if file.attrs.get("format") != FORMAT:
        raise SceneError(f"not a scene file (its format is {file.attrs.get('format')!r}, not {FORMAT!r})")
    version = int(file.attrs["version"])
    if version != VERSION:
        raise SceneError(f"has scene format version {version}; this software reads version {VERSION}: update it")
    groups = file.get("targets", {})
    names = sorted(groups, key=lambda name: int(groups[name].attrs["index"]))
    return Scene(
        name=str(file.attrs["name"]),
        actions=_actions(str(file.attrs["actions"])),
        views=_read_blobs(file["views"]),
        poses=file["poses"][()].astype(np.float32),
        transitions=_as_states(file["transitions"][()]),
        boxes=file["boxes"][()].astype(np.float32),
        targets=tuple(_read_target(name, groups[name]) for name in names),
        image_size=int(file.attrs["image_size"]),
        fov=float(file.attrs["fov"]),
        source=str(file.attrs["source"]),
        floor_plan=_read_floor_plan(file),
        labels=_read_labels(file),
    )


def _read_labels(file: h5py.File) -> np.ndarray | None:
    if "labels" not in file:
        return None
    labels = file["labels"][()]
    if not np.issubdtype(labels.dtype, np.integer):
        raise SceneError(f"labels are {labels.dtype}, expected whole numbers")
    return labels.astype(np.uint8)


def _read_target(name: str, group: h5py.Group) -> Target:
    held_out = group.attrs.get("held_out", 0)
    if not isinstance(held_out, (int, np.integer)):
        raise SceneError(f"target '{name}' holds out {held_out!r} pictures, expected a whole number")
    return Target(name, _read_blobs(group["pictures"]), str(group.attrs["category"]), int(held_out))


def _actions(text: str) -> tuple[Action, ...]:
    known = {action.value: action for action in Action}
    names = json.loads(text)
    if unknown := [name for name in names if name not in known]:
        raise SceneError(f"unknown actions {unknown}; known are {sorted(known)}")
    return tuple(known[name] for name in names)


def _as_states(array: np.ndarray) -> np.ndarray:
    if not np.issubdtype(array.dtype, np.integer):
        raise SceneError(f"transitions are {array.dtype}, expected whole numbers")
    return array.astype(np.int32)


def _read_floor_plan(file: h5py.File) -> FloorPlan | None:
    if "floor_plan" not in file:
        return None
    group = file["floor_plan"]
    obstacles = group.get("obstacles", {})
    return FloorPlan(
        outline=group["outline"][()],
        obstacles=tuple(
            (str(obstacles[key].attrs["label"]), obstacles[key][()]) for key in sorted(obstacles, key=int)
        ),
    )


def _write_blobs(group: h5py.Group, name: str, blobs: Sequence[bytes]) -> None:
    dataset = group.create_dataset(name, (len(blobs),), dtype=h5py.vlen_dtype(np.uint8))
    for index, blob in enumerate(blobs):
        dataset[index] = np.frombuffer(blob, np.uint8)


def _read_blobs(dataset: h5py.Dataset) -> tuple[bytes, ...]:
    return tuple(blob.tobytes() for blob in dataset[()])
