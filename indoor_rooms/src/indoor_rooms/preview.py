"""A quick look at rooms before they are photographed: are they sound, and how do they look?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from indoor_rooms.free_space import free_positions
from indoor_rooms.layouts import make_room
from indoor_rooms.progress import Progress, quiet
from indoor_rooms.renderer.camera import render
from indoor_rooms.renderer.lighting import bake
from indoor_rooms.room import Room
from indoor_rooms.validation import room_problems

EYES = 1.45
PREVIEW_RAYS = 48
FIELD_OF_VIEW = 80.0
DOWN = -14.0
CAPTION, GAP = 18, 6
# From which corner of the floor each picture is taken, as shares of its size: opposite ones first.
CORNERS = ((0, 0), (1, 1), (1, 0), (0, 1))
MOST_VIEWS = len(CORNERS)

Run = Callable[[Callable[[Any, Any], Any], Any, Sequence[Any], Progress], list[Any]]


@dataclass(frozen=True, eq=False)
class Look:
    """What was found out about one room.

    Attributes:
        name: of the room.
        problems: sentences; none if it is sound.
        targets: how many things can be searched for.
        places: how many places a robot has.
        pictures: (H, W, 3) uint8 each.
    """

    name: str
    problems: list[str]
    targets: int
    places: int
    pictures: list[NDArray[np.uint8]]


def look_at_rooms(
    layouts: Sequence[str],
    seeds: Sequence[int],
    views: int = 0,
    image_size: int = 300,
    progress: Progress = quiet,
    run: Run | None = None,
) -> list[Look]:
    """Make rooms, check them, and take pictures of them.

    Args:
        layouts: names of layouts.
        seeds: of each layout these rooms.
        views: pictures of each room, 0 to 4; taking them needs some seconds a room.
        image_size: side of the pictures in pixels.
        progress: told after each room.
        run: makes one look of each job, for instance in several processes; None for one after the other here.

    Raises:
        LayoutError: if there is no such layout, or a room cannot be made.
    """
    jobs = [(layout, seed) for layout in layouts for seed in seeds]
    shared = (views, image_size)
    if run is not None:
        return run(look_at_room, shared, jobs, progress)
    looks = []
    for number, job in enumerate(jobs, 1):
        looks.append(look_at_room(shared, job))
        progress(number, len(jobs))
    return looks


def look_at_room(shared: tuple[int, int], job: tuple[str, int]) -> Look:
    """Make, check and picture one room, given pictures and their side, and its layout and seed."""
    views, image_size = shared
    room = make_room(*job)
    pictures = preview(room, views, image_size) if views else []
    return Look(room.name, room_problems(room), len(room.targets), len(free_positions(room)), pictures)


def preview(room: Room, views: int = 2, image_size: int = 300, rays: int = PREVIEW_RAYS) -> list[NDArray[np.uint8]]:
    """Pictures of a room, each from another corner towards the middle.

    Args:
        room: what to look at.
        views: how many, 1 to 4.
        image_size: side of the pictures in pixels.
        rays: per vertex of the light's computation; few are enough for a look.

    Returns:
        `views` pictures, (image_size, image_size, 3) uint8.

    Raises:
        FreeSpaceError: if there is no place to stand.
    """
    places = free_positions(room)
    middle = np.array(room.size[:2]) / 2
    baked = bake(room, rays, bounces=4, seed=1)
    pictures = []
    for x, y in CORNERS[:views]:
        corner = np.array([x * room.size[0], y * room.size[1]])
        place = places[np.linalg.norm(places - corner, axis=1).argmin()]
        away = middle - place
        heading = float(np.degrees(np.arctan2(away[0], away[1])))
        picture = render(baked, (*place.tolist(), EYES), heading, DOWN, image_size, FIELD_OF_VIEW)
        pictures.append(picture.image)
    return pictures


def preview_sheet(looks: Sequence[Look], columns: int = 3) -> Image.Image:
    """Rooms side by side, each with its pictures in a row and its name below."""
    width = sum(picture.shape[1] for picture in looks[0].pictures) + GAP
    height = looks[0].pictures[0].shape[0] + CAPTION + GAP
    columns = min(columns, len(looks))
    sheet = Image.new("RGB", (columns * width + GAP, -(-len(looks) // columns) * height + GAP), "white")
    draw = ImageDraw.Draw(sheet)
    for number, look in enumerate(looks):
        x, y = GAP + number % columns * width, GAP + number // columns * height
        sheet.paste(Image.fromarray(np.hstack(look.pictures)), (x, y))
        text = f"{look.name}: {look.places} places, {look.targets} targets"
        draw.text((x + 2, y + height - CAPTION - GAP + 1), text, fill="#333333", font=ImageFont.load_default(size=13))
    return sheet
