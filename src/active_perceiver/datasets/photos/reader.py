"""A room photographed on a grid: a folder of photographs, their poses, boxes from a labelling tool, target pictures.

my_room/
  poses.csv            file,x,z,heading,tilt (metres, degrees), see `pose_table.py`
  moves.csv            file,action,next_file; optional: without it the moves follow from the poses
  annotations.json     COCO boxes, see `coco/reader.py`; optional: views can be labelled later
  targets/mug/*.jpg    pictures of each object on its own; the folder's name is the object's
  IMG_0001.jpg ...     the photographs, in any folders
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.datasets.coco.reader import CocoBoxes, read_coco
from active_perceiver.datasets.io import Imported, check_image_size
from active_perceiver.datasets.moves import lattice_actions, one_way_moves, snapped_transitions
from active_perceiver.datasets.photos.photo_files import IMAGE_SUFFIXES, read_target, square_view
from active_perceiver.datasets.photos.pose_snapping import LatticeConfig, snap_poses
from active_perceiver.datasets.photos.pose_table import PoseTable, read_moves, read_poses
from active_perceiver.scenes.image_files import Upright, upright
from active_perceiver.scenes.images import boxes_in_square
from active_perceiver.scenes.lattice import Action
from active_perceiver.scenes.scene import LABELLED, PROPOSED, UNLABELLED, Scene, SceneError, Target
from active_perceiver.utils.progress import ProgressCallback, quiet

_LISTED = 5


@dataclass(frozen=True)
class PhotoConfig:
    """What the folder does not say.

    Attributes:
        name: of the scene; the folder's if empty.
        boxes: the COCO file; `annotations.json` in the folder if None.
        lattice: what is known of the lattice of poses.
        sideways: whether the robot can move to its sides.
        image_size: side of the scene's views in pixels.
        fov: field of view of the photographs' longer side in degrees.
        held_out: how many pictures of each target are never trained with.
    """

    name: str = ""
    boxes: Path | None = None
    lattice: LatticeConfig = field(default_factory=LatticeConfig)
    sideways: bool = False
    image_size: int = 300
    fov: float = 75.0
    held_out: int = 0

    def __post_init__(self) -> None:
        check_image_size(self.image_size)
        if not 1 <= self.fov < 180:
            raise SceneError(f"the field of view is degrees from 1 to 179, got {self.fov}")


@dataclass(frozen=True, eq=False)
class _States:
    """Poses and moves of the photographs that become states.

    Attributes:
        chosen: (S,) their indices in the table of poses.
        poses: (S, 4).
        actions: the columns of `transitions`.
        transitions: (S, A).
        notes: for the user.
    """

    chosen: NDArray[np.int64]
    poses: NDArray[np.float32]
    actions: tuple[Action, ...]
    transitions: NDArray[np.int32]
    notes: tuple[str, ...]


def import_photos(folder: Path, settings: PhotoConfig, report: ProgressCallback = quiet) -> Imported:
    """Make a scene of a folder of photographs.

    Photographs that are not square are padded in the middle, and their boxes with them. Their EXIF rotation is
    applied. A photograph that is a square of the scene's size already is kept as it is.

    Raises:
        UserError: if something is missing, malformed or contradictory; the message names the file and the place.
    """
    if not folder.is_dir():
        raise SceneError(f"there is no folder {folder}; give the folder that holds poses.csv and the photographs")
    table = read_poses(folder / "poses.csv")
    photographs = _photographs(folder, table)
    states = _states(folder, table, settings)
    targets = _target_files(folder)
    size = photographs[0].width, photographs[0].height
    files = [table.files[index] for index in states.chosen]
    coco = _boxes(folder, settings, files, size, list(targets))
    kinds = {} if coco is None else coco.kinds
    scene = Scene(
        name=settings.name or folder.resolve().name,
        actions=states.actions,
        views=_views(folder, files, [photographs[index] for index in states.chosen], settings.image_size, report),
        poses=states.poses,
        transitions=states.transitions,
        boxes=_square_boxes(coco, len(files), size, len(targets), settings.image_size),
        targets=tuple(
            Target(name, read_target(pictures), kinds.get(name, name), settings.held_out)
            for name, pictures in targets.items()
        ),
        image_size=settings.image_size,
        fov=settings.fov,
        source=f"{len(files)} photographs of {size[0]} x {size[1]} pixels from the folder {folder.resolve().name}",
        labels=_labels(coco, len(files)),
    )
    boxes = () if coco is None else tuple(str(coco.report).splitlines())
    return Imported(scene, (*states.notes, *boxes, *_unused(folder, table)))


def _photographs(folder: Path, table: PoseTable) -> list[Upright]:
    """Sizes of all photographs; they are there, and of one size."""
    for name, line in zip(table.files, table.lines, strict=True):
        if not _is_file(folder / name):
            raise SceneError(
                f"{table.path}, line {line}: there is no photograph {name[:80]} in {folder}; correct the name or "
                "take the line out"
            )
    found = [upright(folder / name) for name in table.files]
    sizes = Counter((one.width, one.height) for one in found)
    usual = max(sizes, key=lambda size: sizes[size])
    odd = [
        f"{name} ({one.width} x {one.height})"
        for name, one in zip(table.files, found, strict=True)
        if (one.width, one.height) != usual
    ]
    if odd:
        more = f" and {len(odd) - _LISTED} more" if len(odd) > _LISTED else ""
        raise SceneError(
            f"{folder}: most photographs have, upright, {usual[0]} x {usual[1]} pixels, but not "
            f"{', '.join(odd[:_LISTED])}{more}; take all with one camera held one way, or scale and crop these"
        )
    return found


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # no file can have such a name
        return False


def _states(folder: Path, table: PoseTable, settings: PhotoConfig) -> _States:
    everything = np.arange(len(table.files))
    if not (folder / "moves.csv").exists():
        snapped = snap_poses(table, settings.lattice)
        poses = snapped.poses[snapped.kept]
        actions = lattice_actions(poses, settings.sideways)
        if not actions:
            raise SceneError(f"{table.path} has a single pose: there is nowhere to move; photograph several")
        transitions = snapped_transitions(poses, actions, snapped.spacing, snapped.heading_step)
        notes = (*snapped.notes, *_nowhere_ahead(poses, actions, transitions))
        return _States(everything[snapped.kept], poses, actions, transitions, notes)
    actions, transitions = read_moves(folder / "moves.csv", table.files)
    poses = table.poses.astype(np.float32)
    try:
        snapped = snap_poses(table, settings.lattice)
    except SceneError as error:
        # The moves are known, so the poses are for figures only.
        notes = (f"poses are kept as they are: {error}",)
    else:
        if snapped.kept.all():
            poses, notes = snapped.poses, snapped.notes
        else:
            notes = ("poses are kept as they are: on a lattice some photographs would share one",)
    lost = one_way_moves(actions, transitions)
    if lost:
        start, action, end = lost[0]
        notes = (
            *notes,
            f"{len(lost)} moves have no way back, as {action.value} from {table.files[start]} to {table.files[end]}",
        )
    return _States(everything, poses, actions, transitions, notes)


def _nowhere_ahead(
    poses: NDArray[np.floating], actions: tuple[Action, ...], transitions: NDArray[np.integer]
) -> list[str]:
    """A note on headings at which no place lies ahead of any other, as halfway between the grid's directions."""
    if Action.MOVE_AHEAD not in actions:
        return []
    goes = transitions[:, actions.index(Action.MOVE_AHEAD)] != np.arange(len(poses))
    stuck = [f"{heading:g}" for heading in np.unique(poses[:, 2]) if not goes[poses[:, 2] == heading].any()]
    if not stuck:
        return []
    return [f"no place lies ahead at headings {', '.join(stuck)}; if the robot gets to one, say so in moves.csv"]


def _target_files(folder: Path) -> dict[str, list[Path]]:
    """Files of the pictures of each target."""
    place = folder / "targets"
    if not place.is_dir():
        raise SceneError(
            f"there is no folder {place}; make it, and in it a folder for each object with pictures of the object on "
            "its own, as targets/mug/1.jpg"
        )
    found = {}
    for target in sorted(place.iterdir()):
        if target.is_dir() and not target.name.startswith("."):
            found[target.name] = [path for path in sorted(target.iterdir()) if path.suffix.lower() in IMAGE_SUFFIXES]
            if not found[target.name]:
                raise SceneError(f"there is no picture in {target}; put JPEG, PNG or WebP files of the object there")
    return found


def _boxes(
    folder: Path, settings: PhotoConfig, files: list[str], size: tuple[int, int], targets: list[str]
) -> CocoBoxes | None:
    path = settings.boxes or folder / "annotations.json"
    if settings.boxes is None and not path.exists():
        return None
    return read_coco(path, files, np.tile(np.array(size), (len(files), 1)), targets)


def _square_boxes(
    coco: CocoBoxes | None, states: int, size: tuple[int, int], targets: int, image_size: int
) -> NDArray[np.float32]:
    if coco is None:
        return np.full((states, targets, 4), np.nan, np.float32)
    return boxes_in_square(coco.boxes, *size, image_size)


def _labels(coco: CocoBoxes | None, states: int) -> NDArray[np.uint8] | None:
    if coco is None:
        return np.full(states, UNLABELLED, np.uint8)
    labels = np.where(coco.listed, np.where(coco.proposed, PROPOSED, LABELLED), UNLABELLED).astype(np.uint8)
    return None if (labels == LABELLED).all() else labels


def _views(
    folder: Path, files: list[str], photographs: list[Upright], image_size: int, report: ProgressCallback
) -> tuple[bytes, ...]:
    views = []
    for number, (name, photograph) in enumerate(zip(files, photographs, strict=True), start=1):
        views.append(square_view(folder / name, photograph, image_size))
        report(number, len(files), name)
    return tuple(views)


def _unused(folder: Path, table: PoseTable) -> list[str]:
    """A note on photographs in the folder that have no pose."""
    known = {(folder / name).resolve() for name in table.files}
    others = [
        path.relative_to(folder)
        for path in sorted(folder.rglob("*"))
        if path.suffix.lower() in IMAGE_SUFFIXES
        and path.relative_to(folder).parts[0] != "targets"
        and path.resolve() not in known
    ]
    if not others:
        return []
    more = f" and {len(others) - 3} more" if len(others) > 3 else ""
    return [f"not in {table.path.name}, so left out: {', '.join(map(str, others[:3]))}{more}"]
