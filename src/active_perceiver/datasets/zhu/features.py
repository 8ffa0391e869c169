"""Writing scenes with features for other software: dumps as those of Zhu et al., ICRA 2017."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from active_perceiver.datasets.zhu.writer import FEATURES, ZhuDump, write_zhu, zhu_dump
from active_perceiver.errors import UserError
from active_perceiver.scenes import Scene
from active_perceiver.scenes.hdf5 import create_hdf5
from active_perceiver.utils.files import check_output, replacing
from active_perceiver.utils.progress import ProgressCallback, console, progress_bar
from active_perceiver.vision.backbone import IMAGE_SIZE, Backbone, load_backbone, pooled

# The ten crops: this share of either side, in the corners and the middle, and their mirror images.
_CROP = 0.875


def export_zhu(
    scene: Scene,
    out: Path,
    *,
    backbone: str = "efficientnet_lite0",
    image_size: int = IMAGE_SIZE,
    crops: int = 1,
    force: bool = False,
) -> tuple[str, ...]:
    """Write a scene as a dump for agents written for those of Zhu et al.

    Args:
        scene: what to write.
        out: the `.h5` file.
        backbone: makes the features. They are fewer than the format's 2048; zeros follow.
        image_size: side in pixels to which it scales the views.
        crops: features per state: 1, of the view, or 10, of the corners and the middle and their mirror images.
        force: replace an existing file.

    Returns:
        Sentences on what the format cannot say, and on the features.

    Raises:
        OutputExistsError: if the file exists and `force` is false.
        UserError: if the scene or the backbone does not suit, or there is no such number of crops.
    """
    if crops not in (1, 10):
        raise UserError(f"a dump has 1 or 10 features per state, got {crops}")
    check_output(out, force)
    dump = zhu_dump(scene)
    with console.status(f"backbone {backbone}"):
        network = load_backbone(backbone, image_size=image_size)
    with replacing(out, force) as temporary, create_hdf5(temporary) as file:
        with progress_bar("observations") as report:
            write_zhu(dump, file, report)
        with progress_bar(f"features by {backbone}") as report:
            _write_features(dump, network, crops, file, report)
    return (
        *dump.notes,
        f"'resnet_feature' holds {network.channels} pooled features of {network.name}, then zeros up to the "
        f"{FEATURES} that the format's networks expect; they are not those of the published dumps",
    )


def _write_features(
    dump: ZhuDump, backbone: Backbone, crops: int, file: h5py.File, progress: ProgressCallback
) -> None:
    states = len(dump.states)
    features = file.create_dataset("resnet_feature", (states, crops, FEATURES), np.float32, compression="gzip")
    features.attrs.update(backbone=backbone.name, width=backbone.channels)
    for row, state in enumerate(dump.states):
        view = dump.scene.view(int(state))
        values = np.zeros((crops, FEATURES), np.float32)
        values[:, : backbone.channels] = pooled(backbone.maps([view] if crops == 1 else ten_crops(view)))
        features[row] = values
        progress(row + 1, states)


def ten_crops(view: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    """The corners and the middle of a view, and their mirror images, at the view's own size."""
    size = view.shape[0]
    side = max(1, round(_CROP * size))
    end, middle = size - side, (size - side) // 2
    cut = [view[top : top + side, left : left + side] for top in (0, end) for left in (0, end)]
    cut.append(view[middle : middle + side, middle : middle + side])
    scaled = [np.asarray(Image.fromarray(one).resize((size, size), Image.Resampling.BILINEAR)) for one in cut]
    return scaled + [one[:, ::-1] for one in scaled]
