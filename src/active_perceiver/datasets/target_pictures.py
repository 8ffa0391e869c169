"""Pictures of targets for foreign scenes: files from a folder, or crops of the views themselves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.datasets.io import encoded_view
from active_perceiver.scenes.images import read_image
from active_perceiver.scenes.scene import SceneError, Target

MOST_CROPS = 8
"""Pictures of a target that are cropped from views."""
PICTURE_SIZE = 320
"""Pixels along a side of a stored picture: as many as the backbone looks at."""
HELD_OUT_SHARE = 4
"""One of so many pictures is held out from training, see `Target.held_out`."""

# A crop shows all of the object: its box keeps off the view's edges and no side of it is shorter than so many pixels;
# this share of its size is left around it.
_EDGE, _LEAST_SIDE, _MARGIN = 2, 24, 0.1
_SUFFIXES = (".jpg", ".jpeg", ".png", ".webp")


def crop_pictures(
    names: Sequence[str],
    corners: NDArray[np.floating],
    sizes: NDArray[np.integer],
    image_of: Callable[[int], NDArray[np.uint8]],
) -> dict[str, tuple[bytes, ...]]:
    """Pictures of targets from the views with their largest clean boxes: whole, and not too small.

    Args:
        names: (T,) of the targets.
        corners: (S, T, 4) left, top, right, bottom of the boxes in pixels, NaN where not visible.
        sizes: (S, 2) width and height of the views in pixels.
        image_of: a state's view, (H, W, 3) uint8.

    Returns:
        For each target with clean boxes, pictures of it, the largest first.
    """
    low, high = corners[..., :2], corners[..., 2:]
    # Comparisons with NaN are false.
    clean = ((low >= _EDGE) & (high <= sizes[:, None] - _EDGE) & (high - low >= _LEAST_SIDE)).all(-1)
    areas = np.where(clean, (high - low).prod(-1), 0.0)
    pictures = {}
    for index, name in enumerate(names):
        largest = np.argsort(-areas[:, index], kind="stable")[:MOST_CROPS]
        chosen = [int(state) for state in largest if areas[state, index] > 0]
        if chosen:
            pictures[name] = tuple(_cropped(image_of(state), corners[state, index]) for state in chosen)
    return pictures


def _cropped(image: NDArray[np.uint8], corners: NDArray[np.floating]) -> bytes:
    margin = _MARGIN * float((corners[2:] - corners[:2]).max())
    left, top = np.floor(np.maximum(corners[:2] - margin, 0)).astype(int)
    right, bottom = np.ceil(corners[2:] + margin).astype(int)
    return encoded_view(image[top:bottom, left:right], PICTURE_SIZE)


def found_pictures(folder: Path, names: Iterable[str]) -> dict[str, tuple[bytes, ...]]:
    """Pictures of targets in a folder: all images in `NAME/`, and those called `NAME.*` or `NAME_*`, at any depth.

    Args:
        folder: where to look.
        names: of the targets; where two fit, such as "cup" and "cup_red", the longer one is meant.

    Returns:
        For each target with pictures, these, as squares, in the order of the files' names.

    Raises:
        SceneError: if there is no such folder.
        ImageError: if a picture cannot be read.
    """
    if not folder.is_dir():
        raise SceneError(f"there is no folder of pictures {folder}")
    longest_first = sorted(names, key=len, reverse=True)
    pictures: dict[str, list[bytes]] = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() in _SUFFIXES and path.is_file():
            name = next((name for name in longest_first if _shows(path, name)), None)
            if name is not None:
                pictures.setdefault(name, []).append(encoded_view(read_image(path), PICTURE_SIZE))
    return {name: tuple(found) for name, found in pictures.items()}


def _shows(path: Path, name: str) -> bool:
    return path.parent.name == name or path.stem == name or path.stem.startswith(f"{name}_")


def pictured_target(name: str, pictures: tuple[bytes, ...], category: str) -> Target:
    """A target that holds out its share of the pictures."""
    return Target(name, pictures, category, held_out=len(pictures) // HELD_OUT_SHARE)
