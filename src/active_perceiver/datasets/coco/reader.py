"""Boxes from COCO files, as Label Studio and CVAT export them.

Format: https://cocodataset.org/#format-data: `images` (id, file_name, width, height), `annotations` (image_id,
category_id, bbox [x, y, width, height] in pixels from the upper left corner, iscrowd), `categories` (id, name). An
image that is listed was looked at: what has no box in it is not visible in it. Images that are not listed are not
labelled.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from active_perceiver.datasets.coco.photograph_names import PhotographNames
from active_perceiver.datasets.io import read_json
from active_perceiver.scenes.box_labels import view_file_names, with_boxes
from active_perceiver.scenes.scene import PROPOSED, Scene, SceneError

PROPOSED_KEY = "proposed"
"""Our own field of an image: its boxes are a recogniser's. Labelling tools do not know it and leave it out."""
# How much the proportions of an image may differ from those of the photograph, by rounding.
_PROPORTIONS = 0.02


@dataclass(frozen=True)
class CocoReport:
    """What was read, and what was not as expected.

    Attributes:
        images: how many photographs are labelled by the file.
        boxes: how many boxes were taken.
        notes: a sentence each.
    """

    images: int
    boxes: int
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        return "\n".join([f"{self.boxes} boxes in {self.images} labelled images", *self.notes])


@dataclass(frozen=True, eq=False)
class CocoBoxes:
    """The boxes of a COCO file for some photographs.

    Attributes:
        boxes: (S, T, 4) float64 centre x, centre y, width, height as fractions of the photograph; NaN where not
            visible, or not labelled.
        listed: (S,) bool, whether the file lists the photograph: then it is labelled.
        proposed: (S,) bool, whether its boxes are proposals.
        kinds: by the name of a target the `supercategory` of its category, if it has one.
        report: for the user.
    """

    boxes: NDArray[np.float64]
    listed: NDArray[np.bool_]
    proposed: NDArray[np.bool_]
    kinds: dict[str, str]
    report: CocoReport


@dataclass(frozen=True)
class _Image:
    photograph: int
    width: float
    height: float


def read_coco(
    path: Path, photographs: Sequence[str], sizes: NDArray[np.integer], targets: Sequence[str]
) -> CocoBoxes:
    """Read the boxes of targets in photographs.

    Of several boxes of one target in one image the largest is taken; crowds are left out.

    Args:
        path: the COCO file.
        photographs: (S,) their names, paths within their folder.
        sizes: (S, 2) width and height in pixels of each, upright.
        targets: (T,) names; a category is a target if it has its name, apart from case, spaces and underscores.

    Raises:
        SceneError: if the file is missing, malformed or contradicts itself or the photographs, lists none of them, or
            has a box without a size; the message names the entry.
    """
    content = _load(path)
    reader = _Entries(path)
    ids, proposals, unknown = _images(reader, content, photographs, sizes)
    category_of, kinds, others = _categories(reader, content, targets)
    boxes = np.full((len(photographs), len(targets), 4), np.nan)
    counts: Counter[str] = Counter()
    strangers: Counter[str] = Counter()
    for where, entry in reader.list(content, "annotations"):
        image_id, category_id = (reader.value(where, entry, name, int) for name in ("image_id", "category_id"))
        if image_id not in ids:
            reader.refuse(f"{where}.image_id", f"is {image_id}, which is not the id of an image")
        if category_id not in category_of and category_id not in others:
            reader.refuse(f"{where}.category_id", f"is {category_id}, which is not the id of a category")
        image = ids[image_id]
        if category_id in others:
            strangers[others[category_id]] += 1
        elif entry.get("iscrowd") in (1, True):
            counts["crowds"] += 1
        elif image is not None:
            box, clipped = _box(reader, where, entry, image)
            counts["clipped"] += clipped
            place = boxes[image.photograph, category_of[category_id]]
            if not np.isnan(place[0]):
                counts["doubles"] += 1
            if not place[2] * place[3] >= box[2] * box[3]:
                place[:] = box
    listed = np.zeros(len(photographs), bool)
    listed[[image.photograph for image in ids.values() if image is not None]] = True
    seen = ~np.isnan(boxes[..., 0])
    notes = _notes(
        counts, strangers, unknown, [target for target, found in zip(targets, seen.any(0), strict=True) if not found]
    )
    proposed = np.isin(np.arange(len(photographs)), list(proposals)) & listed
    return CocoBoxes(boxes, listed, proposed, kinds, CocoReport(int(listed.sum()), int(seen.sum()), notes))


def labelled_from_coco(scene: Scene, path: Path) -> tuple[Scene, CocoReport]:
    """Put the boxes of a COCO file into a scene.

    The file's images are the scene's views under the names that `scenes export coco` gives them. A view that the file
    lists is labelled by it, whatever it was before; the others stay as they are.

    Raises:
        SceneError: if the file is not sound, see `read_coco`, or lists no view of the scene.
    """
    sizes = np.full((len(scene), 2), scene.image_size)
    coco = read_coco(path, view_file_names(scene), sizes, scene.target_names)
    for chosen, state in ((coco.listed & ~coco.proposed, None), (coco.listed & coco.proposed, PROPOSED)):
        by_view = {int(view): coco.boxes[view] for view in np.flatnonzero(chosen)}
        scene = with_boxes(scene, by_view) if state is None else with_boxes(scene, by_view, state)
    return scene, coco.report


class _Entries:
    """Access to the parts of a JSON document; what is not as it should be is refused by its place.

    Args:
        path: of the document, for messages.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def refuse(self, where: str, what: str) -> NoReturn:
        raise SceneError(f"{self.path}: {where} {what}; export it as COCO anew, or correct it")

    def list(self, content: dict[str, Any], name: str) -> Iterator[tuple[str, dict[str, Any]]]:
        entries = content.get(name)
        if not isinstance(entries, list):
            self.refuse(name, "is missing" if entries is None else "is not a list")
        for index, entry in enumerate(entries):
            if not isinstance(entry, dict):
                self.refuse(f"{name}[{index}]", "is not an object")
            yield f"{name}[{index}]", entry

    def value(self, where: str, entry: dict[str, Any], name: str, kind: type) -> Any:
        value = entry.get(name)
        if not isinstance(value, kind) or isinstance(value, bool):
            found = "is missing" if value is None else f"is {str(value)[:40]!r}"
            wanted = {int: "a whole number", str: "a text"}[kind]
            self.refuse(f"{where}.{name}", f"{found}, expected {wanted}")
        return value


def _load(path: Path) -> dict[str, Any]:
    content = read_json(path)
    if not isinstance(content, dict):
        raise SceneError(f"{path} is JSON, but not COCO, which is an object with images, annotations and categories")
    return content


def _images(
    reader: _Entries, content: dict[str, Any], photographs: Sequence[str], sizes: NDArray[np.integer]
) -> tuple[dict[int, _Image | None], set[int], list[str]]:
    """The images by their id (None for one that is no photograph), photographs with proposals, unknown names."""
    names = PhotographNames(photographs)
    ids: dict[int, _Image | None] = {}
    proposals: set[int] = set()
    unknown = []
    for where, entry in reader.list(content, "images"):
        identity, name = reader.value(where, entry, "id", int), reader.value(where, entry, "file_name", str)
        if identity in ids:
            reader.refuse(f"{where}.id", f"is {identity}, as that of an image before it")
        found = names.find(name)
        if len(found) > 1:
            several = " and ".join(photographs[index] for index in found[:2])
            reader.refuse(f"{where}.file_name", f"'{name}' may be {several}; give the tool their folders, too")
        if not found:
            unknown.append(name)
            ids[identity] = None
            continue
        ids[identity] = _sized(reader, where, entry, found[0], photographs[found[0]], sizes[found[0]])
        if entry.get(PROPOSED_KEY) is True:
            proposals.add(found[0])
    if unknown and all(image is None for image in ids.values()):
        raise SceneError(
            f"{reader.path} lists none of the {len(photographs)} photographs: its names are as '{unknown[0][:80]}', "
            f"theirs as '{photographs[0]}'; label the photographs under their names"
        )
    return ids, proposals, unknown


def _sized(
    reader: _Entries, where: str, entry: dict[str, Any], index: int, name: str, size: NDArray[np.integer]
) -> _Image:
    """An image with the size its boxes refer to: that in the file, or that of the photograph if it has none."""
    given = [entry.get("width"), entry.get("height")]
    if given == [None, None]:
        return _Image(index, float(size[0]), float(size[1]))
    width, height = (
        float(value) if isinstance(value, (int, float)) and 0 < value < 1e6 else np.nan for value in given
    )
    if np.isnan(width + height):
        reader.refuse(f"{where}.width and height", f"are {str(given)[:60]}, expected pixels")
    # The same image smaller or larger is fine; one turned by its EXIF, or cut, is not what the boxes refer to.
    if abs(width * size[1] / (height * size[0]) - 1) > _PROPORTIONS:
        raise SceneError(
            f"{reader.path}: {where} says that {name} has {width:g} x {height:g} pixels, but upright it has "
            f"{size[0]} x {size[1]}; label the photographs as they are imported: upright (their EXIF applied), uncut"
        )
    return _Image(index, width, height)


def _categories(
    reader: _Entries, content: dict[str, Any], targets: Sequence[str]
) -> tuple[dict[int, int], dict[str, str], dict[int, str]]:
    """Index of the target by category id, kinds by target, and names of the other categories by id."""
    by_name = {_same(target): index for index, target in enumerate(targets)}
    by_name |= {target: index for index, target in enumerate(targets)}
    category_of: dict[int, int] = {}
    kinds: dict[str, str] = {}
    others: dict[int, str] = {}
    for where, entry in reader.list(content, "categories"):
        identity, name = reader.value(where, entry, "id", int), reader.value(where, entry, "name", str)
        if identity in category_of or identity in others:
            reader.refuse(f"{where}.id", f"is {identity}, as that of a category before it")
        index = by_name.get(name, by_name.get(_same(name)))
        if index is None:
            others[identity] = name
            continue
        category_of[identity] = index
        kind = entry.get("supercategory")
        if isinstance(kind, str) and kind:
            kinds[targets[index]] = kind
    return category_of, kinds, others


def _same(name: str) -> str:
    return name.strip().casefold().replace(" ", "_").replace("-", "_")


def _box(reader: _Entries, where: str, entry: dict[str, Any], image: _Image) -> tuple[NDArray[np.float64], bool]:
    """A box as fractions of its image, and whether it had to be clipped by more than rounding."""
    given = entry.get("bbox")
    numbers = (
        given
        if isinstance(given, list)
        and len(given) == 4
        and all(isinstance(value, (int, float)) and abs(value) < 1e9 for value in given)
        else reader.refuse(f"{where}.bbox", f"is {str(given)[:60]}, expected [x, y, width, height] in pixels")
    )
    low = np.array(numbers[:2], float)
    high = low + numbers[2:]
    limit = np.array([image.width, image.height])
    inside_low, inside_high = low.clip(0, limit), high.clip(0, limit)
    if (high <= low).any() or (inside_high <= inside_low).any():
        reader.refuse(
            f"{where}.bbox", f"is {numbers}, which has no size within the {limit[0]:g} x {limit[1]:g} image"
        )
    clipped = max(np.abs(inside_low - low).max(), np.abs(inside_high - high).max()) > 1
    return np.concatenate([(inside_low + inside_high) / 2, inside_high - inside_low]) / np.tile(limit, 2), bool(
        clipped
    )


def _notes(counts: Counter[str], strangers: Counter[str], unknown: list[str], unseen: list[str]) -> tuple[str, ...]:
    texts = {
        "crowds": "boxes of crowds (iscrowd) left out",
        "doubles": "boxes left out, as another of the same object in the same image is larger",
        "clipped": "boxes stuck out of their image and were clipped",
    }
    notes = [f"{counts[name]} {text}" for name, text in texts.items() if counts[name]]
    if strangers:
        listing = ", ".join(f"{name} ({count} boxes)" for name, count in sorted(strangers.items()))
        notes.append(f"categories that are no target: {listing}")
    if unknown:
        more = f" and {len(unknown) - 3} more" if len(unknown) > 3 else ""
        notes.append(f"images that are no photograph here: {', '.join(unknown[:3])}{more}")
    if unseen:
        notes.append(f"no box of {', '.join(unseen)}")
    return tuple(notes)
