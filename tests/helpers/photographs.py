"""A scene as somebody's folder of photographs: JPEG of another shape, poses by tape measure, a phone's EXIF."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from PIL import Image

from active_perceiver.datasets.photos.pose_table import write_poses
from active_perceiver.scenes import Scene
from active_perceiver.scenes.images import image_suffix

# EXIF orientation: how the stored pixels came of the upright ones.
STORED = {6: Image.Transpose.ROTATE_90, 8: Image.Transpose.ROTATE_270, 3: Image.Transpose.ROTATE_180}


def photograph_scene(
    scene: Scene,
    folder: Path,
    *,
    seed: int = 0,
    size: tuple[int, int] = (480, 360),
    centimetres: float = 5.0,
    degrees: float = 4.0,
    noise: float = 3.0,
    turned: float = 0.1,
) -> None:
    """Write `IMG_0000.jpg` and so on, `poses.csv`, `targets/` and `annotations.json`.

    Args:
        scene: its views are cut to the proportions of `size` in the middle, boxes with them; a target that is cut to
            less than two pixels is not visible.
        folder: is made.
        seed: of everything random.
        size: width and height of the photographs, upright; not higher than wide.
        centimetres: places are written down with an error of up to so much in x and z.
        degrees: headings and tilts likewise.
        noise: standard deviation of the camera's, in grey levels of 255.
        turned: share of the photographs whose pixels are stored otherwise than upright, as their EXIF says.
    """
    rng = np.random.default_rng(seed)
    width, height = size
    names = [f"IMG_{state:04d}.jpg" for state in range(len(scene))]
    folder.mkdir(parents=True)
    images, annotations = [], []
    for state, name in enumerate(names):
        photograph = np.asarray(Image.fromarray(scene.view(state)).resize((width, width), Image.Resampling.BICUBIC))
        top = (width - height) // 2
        noisy = photograph[top : top + height] + rng.normal(0, noise, (height, width, 3))
        upright = Image.fromarray(noisy.clip(0, 255).astype(np.uint8))
        exif = Image.Exif()
        if rng.random() < turned:
            exif[0x0112] = int(rng.choice(list(STORED)))
            upright = upright.transpose(STORED[exif[0x0112]])
        upright.save(folder / name, quality=90, exif=exif)
        images.append({"id": state, "file_name": name, "width": width, "height": height})
        annotations += cut_boxes(scene, state, width, height, len(annotations))
    error = rng.uniform(-1, 1, (len(scene), 4)) * [centimetres / 100, centimetres / 100, degrees, degrees]
    write_poses(folder / "poses.csv", names, scene.poses + error)
    categories = [{"id": index, "name": name} for index, name in enumerate(scene.target_names)]
    coco = {"images": images, "annotations": annotations, "categories": categories}
    (folder / "annotations.json").write_text(json.dumps(coco))
    for target in scene.targets:
        (folder / "targets" / target.name).mkdir(parents=True)
        for index, picture in enumerate(target.pictures):
            (folder / "targets" / target.name / f"{index:02d}.{image_suffix(picture)}").write_bytes(picture)


def cut_boxes(scene: Scene, state: int, width: int, height: int, count: int) -> list[dict]:
    """COCO annotations of a view cut to width x height pixels; `count` annotations come before them."""
    found: list[dict] = []
    for target, box in enumerate(scene.boxes[state].astype(float) * width):
        top = (width - height) / 2
        low = np.maximum(box[:2] - box[2:] / 2 - [0, top], 0)
        high = np.minimum(box[:2] + box[2:] / 2 - [0, top], [width, height])
        if (high - low >= 2).all():
            bbox = np.concatenate([low, high - low]).round(2).tolist()
            entry = {"id": count + len(found), "image_id": state, "category_id": target, "bbox": bbox, "iscrowd": 0}
            found.append(entry | {"area": bbox[2] * bbox[3]})
    return found
