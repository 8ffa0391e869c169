"""A scene as a folder that a labelling tool opens and `scenes import photos` reads again.

It holds the views as images, `annotations.json` (COCO, https://cocodataset.org/#format-data) with the boxes and their
targets as categories, `poses.csv`, `moves.csv`, and `targets/NAME/` with the pictures of each target. Views that are
not labelled are not in `annotations.json`; proposals are marked by a field that labelling tools leave out, so that
they come back as labelled. The floor plan stays behind.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.datasets.coco.reader import PROPOSED_KEY
from active_perceiver.datasets.photos.pose_table import write_moves, write_poses
from active_perceiver.scenes.box_labels import label_states, view_file_names
from active_perceiver.scenes.image_files import upright
from active_perceiver.scenes.images import image_suffix
from active_perceiver.scenes.scene import PROPOSED, UNLABELLED, Scene, SceneError
from active_perceiver.utils.files import OutputExistsError, replacing_folder
from active_perceiver.utils.progress import ProgressCallback, quiet


def export_coco(scene: Scene, folder: Path, report: ProgressCallback = quiet) -> None:
    """Write a scene as a folder of images and tables; nothing is left of it if that fails.

    Raises:
        OutputExistsError: if the folder exists and is not empty.
        SceneError: if a target's name cannot be that of a folder.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise OutputExistsError(f"{folder} exists; give another name, or delete it first")
    for name in scene.target_names:
        if name.startswith(".") or "\\" in name or "\0" in name:
            raise SceneError(f"target {name!r} cannot be the name of a folder; rename it first")
    with replacing_folder(folder, force=True) as temporary:
        _write(scene, temporary, report)


def coco_annotations(scene: Scene) -> dict[str, Any]:
    """The boxes of a scene as a COCO document, in pixels of the images as they are."""
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    states = label_states(scene)
    for view, name in enumerate(view_file_names(scene)):
        if states[view] == UNLABELLED:
            continue
        shown = upright(scene.views[view], f"view {view}")
        width, height = shown.width, shown.height
        proposed = {PROPOSED_KEY: True} if states[view] == PROPOSED else {}
        images.append({"id": view + 1, "file_name": name, "width": width, "height": height, **proposed})
        boxes = scene.boxes[view].astype(float) * [width, height, width, height]
        for target in np.flatnonzero(~np.isnan(boxes[:, 0])):
            x, y, across, down = boxes[target].tolist()
            corner = [x - across / 2, y - down / 2]
            annotations.append(
                {
                    "id": len(annotations) + 1,
                    "image_id": view + 1,
                    "category_id": int(target) + 1,
                    "bbox": [round(value, 4) for value in (*corner, across, down)],
                    "area": round(across * down, 4),
                    "iscrowd": 0,
                }
            )
    categories = [
        {"id": index + 1, "name": target.name, "supercategory": target.category}
        for index, target in enumerate(scene.targets)
    ]
    info = {"description": scene.name}
    return {"info": info, "images": images, "annotations": annotations, "categories": categories}


def _write(scene: Scene, folder: Path, report: ProgressCallback) -> None:
    names = view_file_names(scene)
    for number, (name, view) in enumerate(zip(names, scene.views, strict=True), start=1):
        (folder / name).write_bytes(view)
        report(number, len(names), name)
    for target in scene.targets:
        place = folder / "targets" / target.name
        place.mkdir(parents=True)
        for index, picture in enumerate(target.pictures):
            (place / f"{index:03d}.{image_suffix(picture)}").write_bytes(picture)
    (folder / "targets").mkdir(exist_ok=True)
    (folder / "annotations.json").write_text(json.dumps(coco_annotations(scene), indent=1), encoding="utf-8")
    write_poses(folder / "poses.csv", names, scene.poses)
    write_moves(folder / "moves.csv", names, scene.actions, scene.transitions)
