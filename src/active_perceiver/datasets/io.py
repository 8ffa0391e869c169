"""What readers share: reading other projects' files so that whatever is wrong ends in one sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes.angles import signed_angle
from active_perceiver.scenes.hdf5_values import check_stored, read_whole
from active_perceiver.scenes.image_files import MAX_PIXELS
from active_perceiver.scenes.images import boxes_in_square, encode_image, square_image
from active_perceiver.scenes.lattice import Action
from active_perceiver.scenes.scene import Scene, SceneError
from active_perceiver.utils.json_reader import DuplicateKeyError, parse_json

ALL_ACTIONS = tuple(Action)
# Metres between two places that count as one, and degrees between two headings or tilts that count as one.
SAME_PLACE, SAME_ANGLE = 1e-3, 1.0

_KINDS = {dict: "a JSON object", list: "a list", str: "a text", int: "a number", bool: "true or false"}


@dataclass(frozen=True, eq=False)
class Imported:
    """A scene made of foreign files.

    Attributes:
        scene: what came of them.
        notes: sentences on what was left out, guessed or does not agree.
    """

    scene: Scene
    notes: tuple[str, ...]


def read_json(path: Path) -> Any:
    """The content of a JSON file.

    Raises:
        SceneError: if the file is missing, cannot be read, is not JSON or names a key twice.
    """
    try:
        return parse_json(path.read_bytes())
    except FileNotFoundError:
        raise SceneError(f"there is no {path.name} in {path.parent}; it belongs to the format") from None
    except OSError as error:
        raise SceneError(f"{path} cannot be read ({error.strerror})") from None
    except DuplicateKeyError as error:
        raise SceneError(f"{path}: {error}") from None
    except ValueError as error:
        raise SceneError(f"{path} is not valid JSON ({error}); it may be truncated, copy it again") from None


def entry(record: Any, key: str, kind: type | tuple[type, ...], where: str) -> Any:
    """An entry of a JSON object.

    Args:
        record: what should be the object.
        key: of the entry.
        kind: what the entry should be.
        where: the file, and the place in it, for the error.

    Raises:
        SceneError: if it is no object, or has no such entry of this kind.
    """
    if not isinstance(record, dict) or not isinstance(record.get(key), kind):
        wanted = " or ".join(_KINDS[one] for one in (kind if isinstance(kind, tuple) else (kind,)))
        if not isinstance(record, dict):
            raise SceneError(f"{where} should be a JSON object with '{key}', got {record!r:.40}")
        got = f"got {record[key]!r:.40}" if key in record else "and is not there"
        raise SceneError(f"{where}: '{key}' should be {wanted}, {got}")
    return record[key]


def numbers(values: Any, count: int, where: str) -> list[float]:
    """A JSON list of finite numbers.

    Args:
        values: what should be the list.
        count: how many numbers it should have at least; more are cut off.
        where: the file, and the place in it, for the error.

    Raises:
        SceneError: if it is no such list.
    """
    if not isinstance(values, list) or len(values) < count:
        raise SceneError(f"{where} should be a list of {count} numbers, got {values!r:.60}")
    for value in values[:count]:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e9:
            raise SceneError(f"{where} should hold finite numbers, got {value!r:.40}")
    return [float(value) for value in values[:count]]


def dataset(file: h5py.File, name: str, shape: Sequence[int | None], kinds: str, path: Path) -> h5py.Dataset:
    """A dataset of an HDF5 file, of the shape and type that the format says.

    Args:
        file: where.
        name: of the dataset.
        shape: None for an axis of any length.
        kinds: numpy's letters of the types that will do: "u" and "i" for whole numbers, "f" for others.
        path: of the file, for the error.

    Raises:
        SceneError: if it is not there or of another shape or type.
    """
    found = file.get(name)
    if not isinstance(found, h5py.Dataset):
        raise SceneError(f"{path} has no dataset '{name}'; it has {', '.join(sorted(file)[:12]) or 'none'}")
    shown = " x ".join("any" if length is None else str(length) for length in shape)
    fits = len(found.shape) == len(shape) and all(
        wanted in (None, length) for wanted, length in zip(shape, found.shape, strict=True)
    )
    if not fits:
        raise SceneError(f"{path}: '{name}' has shape {found.shape}, expected {shown}")
    if found.dtype.kind not in kinds:
        expected = "whole numbers" if set(kinds) <= {"i", "u"} else "numbers"
        raise SceneError(f"{path}: '{name}' is of type {found.dtype}, expected {expected}")
    check_stored(found, f"{path}: ")
    return found


def finite(found: h5py.Dataset, path: Path) -> NDArray[np.float64]:
    """All of a dataset as finite numbers.

    Raises:
        SceneError: if some are not.
    """
    values = read_whole(found, f"{path}: ").astype(np.float64)
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        raise SceneError(
            f"{path}: {len(bad)} numbers of '{str(found.name).lstrip('/')}' are not finite, the first of them in row "
            f"{bad[0][0]}"
        )
    return values


def check_image_size(size: int) -> None:
    """Make sure that views can have this many pixels along a side.

    Raises:
        SceneError: if not.
    """
    if not 16 <= size <= 4096:
        raise SceneError(f"the image size must be 16 to 4096 pixels, got {size}")


def check_pixels(shape: Sequence[int], where: str) -> None:
    """Make sure that an array can be an RGB image.

    Args:
        shape: of the array.
        where: what to call it in an error.

    Raises:
        SceneError: if it is not (H, W, 3), empty or unreasonably large.
    """
    if len(shape) != 3 or shape[2] != 3 or not 0 < shape[0] * shape[1] <= MAX_PIXELS:
        raise SceneError(f"{where} should be an image of height x width x 3, got shape {tuple(shape)}")


def encoded_view(image: NDArray[np.uint8], size: int) -> bytes:
    """An image as the view of a scene: a square of `size` pixels, proportions kept, see `square_image`."""
    return encode_image(square_image(image, size))


def boxes_of_corners(
    corners: NDArray[np.floating], sizes: NDArray[np.integer], image_size: int
) -> NDArray[np.float32]:
    """Boxes given by two corners in images as boxes in the views that `encoded_view` makes of these.

    Args:
        corners: (S, T, 4) left, top, right, bottom in pixels; they are cut at the image's edges.
        sizes: (S, 2) width and height of the images in pixels.
        image_size: side of the views in pixels.

    Returns:
        (S, T, 4) centre x, centre y, width, height as fractions of the view; NaN where less than a pixel of the box
        is inside the image.
    """
    found = np.full(corners.shape, np.nan, np.float32)
    for row, (width, height) in enumerate(sizes.tolist()):
        low = np.maximum(corners[row, :, :2], 0.0)
        high = np.minimum(corners[row, :, 2:], (width, height))
        boxes = np.concatenate([(low + high) / 2, high - low], axis=-1) / [width, height, width, height]
        large = (high - low >= 1.0).all(-1, keepdims=True)
        found[row] = boxes_in_square(np.where(large, boxes, np.nan), width, height, image_size)
    return found


def turned(degrees: NDArray[np.floating]) -> NDArray[np.float64]:
    """Differences of headings as the shorter way round, -180 to 180 degrees."""
    return signed_angle(np.asarray(degrees, float))


def actions_between(
    before: NDArray[np.floating], after: NDArray[np.floating], tolerance: float = 10.0
) -> NDArray[np.int64]:
    """Which action leads from one pose to another, however far the moves go and whatever the steps of the headings.

    Args:
        before: (N, 4) poses.
        after: (N, 4) poses.
        tolerance: degrees that a move may be askew, and may turn on the way.

    Returns:
        (N,) index in `ALL_ACTIONS`; -1 where it is none of them.
    """
    change = np.asarray(after, float) - np.asarray(before, float)
    goes = np.hypot(change[:, 0], change[:, 1]) > SAME_PLACE
    turn, tilt = turned(change[:, 2]), change[:, 3]
    level = np.abs(tilt) <= SAME_ANGLE
    relative = turned(np.degrees(np.arctan2(change[:, 0], change[:, 1])) - before[:, 2])
    quarter = np.round(relative / 90.0)
    straight = (np.abs(relative - 90.0 * quarter) <= tolerance) & (np.abs(turn) <= tolerance)
    moves = np.array(
        [
            ALL_ACTIONS.index(action)
            for action in (Action.MOVE_AHEAD, Action.MOVE_RIGHT, Action.MOVE_BACK, Action.MOVE_LEFT)
        ]
    )
    found = np.where(goes & straight & level, moves[quarter.astype(np.int64) % 4], -1)
    turns = ~goes & level & (np.abs(turn) > SAME_ANGLE) & (np.abs(turn) < 180.0 - SAME_ANGLE)
    right, left = ALL_ACTIONS.index(Action.ROTATE_RIGHT), ALL_ACTIONS.index(Action.ROTATE_LEFT)
    found = np.where(turns, np.where(turn > 0, right, left), found)
    tilts = ~goes & ~level & (np.abs(turn) <= SAME_ANGLE)
    up, down = ALL_ACTIONS.index(Action.LOOK_UP), ALL_ACTIONS.index(Action.LOOK_DOWN)
    return np.where(tilts, np.where(tilt > 0, up, down), found)


def against_poses(
    poses: NDArray[np.floating],
    transitions: NDArray[np.integer],
    actions: Sequence[Action],
    tolerance: float = 10.0,
) -> NDArray[np.bool_]:
    """Which moves do not lead where the poses say that their action leads, (S, A); blocked ones are none of them.

    Args:
        poses: (S, 4).
        transitions: (S, A).
        actions: the columns of `transitions`.
        tolerance: see `actions_between`.
    """
    wrong = np.zeros(transitions.shape, np.bool_)
    for column, action in enumerate(actions):
        after = transitions[:, column]
        goes = after != np.arange(len(poses))
        wrong[:, column] = goes & (actions_between(poses, poses[after], tolerance) != ALL_ACTIONS.index(action))
    return wrong
