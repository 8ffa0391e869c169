"""`scenes capture room`: a rendered room as somebody's folder of photographs, for those who have no camera at hand.

It is what `scenes import photos` reads. Whoever took these photographs put the camera beside the marks on the floor,
turned it roughly to where it should look, and wrote down the marks with errors of their own. Boxes are those of what
the camera really saw.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.capture_scene import (
    HEADINGS,
    Studio,
    check_targets,
    look,
    take_targets,
    take_views,
)
from active_perceiver.capture.rendered.config import CaptureConfig, CaptureError, layout_config
from active_perceiver.capture.rendered.render import noted_origin
from active_perceiver.datasets.photos.pose_table import photograph_name, write_poses
from active_perceiver.parallel.executor import Executor
from active_perceiver.parallel.process_pool import ProcessExecutor
from active_perceiver.parallel.run_store import RunStore, part_folder
from active_perceiver.scenes.images import decode_image, encode_image
from active_perceiver.scenes.lattice import lattice_poses
from active_perceiver.scenes.scene import Target
from active_perceiver.utils.files import OutputExistsError, check_output, replacing_folder
from active_perceiver.utils.progress import progress_bar
from indoor_rooms.free_space import free_positions
from indoor_rooms.layouts import make_room
from indoor_rooms.renderer.camera_faults import CameraFaults
from indoor_rooms.room import Room

JPEG_QUALITY = 90
# Near white a grey level of 255 is so much of the light, as sRGB encodes it.
_LIGHT_PER_GREY = 2.4 / 1.055 / 255
# Everything in a folder that `take_photographs` wrote, and the sign that it did: somebody's own photographs may be
# called the same.
_WRITTEN = re.compile(r"poses\.csv|annotations\.json|IMG_\d{4,}\.jpg|targets/[^/]+/\d{2,}\.jpg")
_SIGN = "photographs of a rendered room"


@dataclass(frozen=True)
class PhotographConfig:
    """Who takes the photographs, and with what.

    Attributes:
        width: of the photographs in pixels; they are three quarters as high.
        jitter_cm: each is taken up to so many centimetres beside its mark, in x and in z.
        jitter_degrees: up to so many degrees away from the intended heading and tilt.
        error_cm: places are written down with an error of up to so much, in x and in z.
        error_degrees: headings and tilts likewise.
        noise: standard deviation of the camera's noise where a photograph is white, in grey levels of 255.
        targets: names of the objects that are marked and photographed alone; all if empty.
    """

    width: int = 400
    jitter_cm: float = 5.0
    jitter_degrees: float = 4.0
    error_cm: float = 2.0
    error_degrees: float = 2.0
    noise: float = 4.0
    targets: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        checks = {
            "width must be in 32..4096 pixels": 32 <= self.width <= 4096,
            "jitter_cm must be in 0..100 centimetres": 0 <= self.jitter_cm <= 100,
            "jitter_degrees must be in 0..30 degrees": 0 <= self.jitter_degrees <= 30,
            "error_cm must be in 0..100 centimetres": 0 <= self.error_cm <= 100,
            "error_degrees must be in 0..30 degrees": 0 <= self.error_degrees <= 30,
            "noise must be in 0..100 grey levels": 0 <= self.noise <= 100,
        }
        for rule, kept in checks.items():
            if not kept:
                name = rule.split()[0]
                raise CaptureError(f"{rule}, got {getattr(self, name)}")

    @property
    def height(self) -> int:
        """Of the photographs in pixels."""
        return self.width * 3 // 4


@dataclass(frozen=True, eq=False)
class _Rolls:
    """Poses of all photographs, (S, 4) each: x, z in metres, heading and tilt in degrees.

    Attributes:
        taken: where the camera was, in the room's own coordinates.
        written: what is written down: from the first mark along each axis.
    """

    taken: NDArray[np.float64]
    written: NDArray[np.float64]


def take_photographs(
    layout: str,
    seed: int,
    folder: Path,
    photographer: PhotographConfig,
    *,
    force: bool = False,
    resume: bool = False,
    executor: Executor | None = None,
    settings: CaptureConfig | None = None,
) -> int:
    """Write a folder of photographs of a rendered room: `IMG_0001.jpg` and so on, `poses.csv`, COCO boxes, targets.

    What is finished is kept in the folder `FOLDER.part` until everything is there.

    Args:
        layout: kind of room, a name in `layouts.LAYOUTS`.
        seed: the room, the photographer's mistakes and every picture follow from it.
        folder: the folder to write.
        photographer: who takes the photographs, and with what.
        force: replace an earlier folder of photographs, and begin anew where the work was interrupted.
        resume: go on with interrupted work.
        executor: does the work; None for a process a core.
        settings: None for those of the layout; the pictures' size is the photographer's.

    Returns:
        The number of photographs.

    Raises:
        LayoutError: if there is no such layout.
        CaptureError: if the room does not hold a target, the jitter is more than the room's robot has space for, or
            interrupted work was begun with other settings.
        OutputExistsError: if the folder, or interrupted work on it, exists and nothing says what to do with it.
    """
    _check_folder(folder, force)
    settings = _camera(settings or layout_config(layout), photographer)
    room = make_room(layout, seed)
    names = _names(room, photographer.targets)
    rolls = _rolls(room, settings, photographer, seed)
    noted = {**noted_origin(layout, seed, settings, room), "photographs": asdict(photographer)}
    noted["photographs"]["targets"] = list(names)
    store = RunStore.begin(part_folder(folder), noted, force=force, resume=resume)
    studio = Studio(room, settings, seed, store)
    jobs = [(pose, names, photographer.height) for pose in rolls.taken.tolist()]
    executor = executor or ProcessExecutor()
    seen = take_views(_photograph, studio, jobs, executor, progress_bar)
    targets = take_targets(studio, names, executor, progress_bar)
    _write(folder, rolls.written, seen, targets, (photographer.width, photographer.height))
    store.remove()
    return len(seen)


def _check_folder(folder: Path, force: bool) -> None:
    if not folder.exists():
        return
    check_output(folder, force)
    if folder.is_symlink() or not folder.is_dir() or not _all_written_here(folder):
        raise OutputExistsError(f"{folder} holds other things than {_SIGN}; give another name")


def _all_written_here(folder: Path) -> bool:
    """Whether a folder holds nothing but what `take_photographs` wrote."""
    files = [path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir()]
    if not all(_WRITTEN.fullmatch(name) for name in files):
        return False
    try:
        return not files or json.loads((folder / "annotations.json").read_bytes())["info"]["description"] == _SIGN
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return False


def _camera(settings: CaptureConfig, photographer: PhotographConfig) -> CaptureConfig:
    """The layout's settings with the photographer's camera."""
    faults = replace(settings.faults or CameraFaults(), noise=min(1.0, photographer.noise * _LIGHT_PER_GREY))
    camera = replace(settings, image_size=photographer.width, faults=faults, webp_quality=95)
    if photographer.jitter_cm / 100 * math.sqrt(2) > settings.robot_radius:
        raise CaptureError(
            f"{photographer.jitter_cm:g} cm beside a mark the camera could be in the furniture; give a jitter_cm of "
            f"at most {math.floor(100 * settings.robot_radius / math.sqrt(2))}"
        )
    return camera


def _names(room: Room, wanted: Sequence[str]) -> tuple[str, ...]:
    check_targets(room)
    for name in wanted:
        if name not in room.targets:
            raise CaptureError(
                f"room '{room.name}' has no target '{name}'; there are {', '.join(sorted(room.targets))}"
            )
    return tuple(dict.fromkeys(wanted)) or tuple(room.targets)


def _rolls(room: Room, settings: CaptureConfig, photographer: PhotographConfig, seed: int) -> _Rolls:
    positions = free_positions(room, settings.spacing, settings.robot_radius, settings.places)
    meant = lattice_poses(positions, HEADINGS, settings.tilts).astype(np.float64)
    rng = np.random.default_rng([seed, len(meant)])
    cm, degrees = photographer.jitter_cm / 100, photographer.jitter_degrees
    beside = rng.uniform(-1, 1, meant.shape) * [cm, cm, degrees, degrees]
    cm, degrees = photographer.error_cm / 100, photographer.error_degrees
    wrong = rng.uniform(-1, 1, meant.shape) * [cm, cm, degrees, degrees]
    from_mark = np.array([*meant[:, :2].min(0), 0, 0])
    written = meant - from_mark + wrong
    # What a person reads off: whole centimetres and degrees.
    return _Rolls(meant + beside, np.column_stack([written[:, :2].round(2), written[:, 2:].round()]))


def _photograph(studio: Studio, job: tuple[str, tuple[Sequence[float], Sequence[str], int]]) -> None:
    """One photograph and its boxes."""
    key, (pose, names, height) = job
    image, boxes = look(studio.baked, studio.settings, pose, names, studio.seed, height)
    blob = encode_image(image, "jpeg", JPEG_QUALITY)
    studio.store.save(key, image=np.frombuffer(blob, np.uint8), boxes=boxes)


def _write(
    folder: Path,
    poses: NDArray[np.float64],
    seen: Sequence[dict[str, NDArray[Any]]],
    targets: Sequence[Target],
    size: tuple[int, int],
) -> None:
    """Write everything beside the folder, then put it in its place."""
    with replacing_folder(folder, force=True) as temporary:
        names = [photograph_name(number) for number in range(1, len(seen) + 1)]
        for name, view in zip(names, seen, strict=True):
            (temporary / name).write_bytes(view["image"].tobytes())
        write_poses(temporary / "poses.csv", names, poses)
        boxes = [view["boxes"] for view in seen]
        (temporary / "annotations.json").write_text(json.dumps(_coco(names, boxes, targets, size), indent=1))
        for target in targets:
            place = temporary / "targets" / target.name
            place.mkdir(parents=True)
            for number, picture in enumerate(target.pictures, 1):
                (place / f"{number:02}.jpg").write_bytes(encode_image(decode_image(picture), "jpeg", JPEG_QUALITY))


def _coco(
    names: Sequence[str], boxes: Sequence[NDArray[np.float32]], targets: Sequence[Target], size: tuple[int, int]
) -> dict[str, Any]:
    """A COCO document (https://cocodataset.org/#format-data) of boxes (T, 4) of each photograph."""
    width, height = size
    images = [
        {"id": number, "file_name": name, "width": width, "height": height} for number, name in enumerate(names, 1)
    ]
    annotations: list[dict[str, Any]] = []
    for number, of_image in enumerate(boxes, 1):
        for category, (x, y, across, down) in enumerate((of_image * [width, height, width, height]).tolist(), 1):
            if not math.isnan(x):
                bbox = [round(value, 2) for value in (x - across / 2, y - down / 2, across, down)]
                annotations.append(
                    {
                        "id": len(annotations) + 1,
                        "image_id": number,
                        "category_id": category,
                        "bbox": bbox,
                        "area": round(across * down, 2),
                        "iscrowd": 0,
                    }
                )
    categories = [
        {"id": number, "name": target.name, "supercategory": target.category}
        for number, target in enumerate(targets, 1)
    ]
    info = {"description": _SIGN}
    return {"info": info, "images": images, "annotations": annotations, "categories": categories}
