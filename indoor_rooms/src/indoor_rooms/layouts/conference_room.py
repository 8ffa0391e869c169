"""Conference rooms: a long table with chairs, a whiteboard, a screen, cabinets along the walls (the paper's room)."""

from __future__ import annotations

import numpy as np

from indoor_rooms.furniture import office, screens, storage, tables
from indoor_rooms.geometry.pieces import placed
from indoor_rooms.layouts.cases import (
    keep_floor,
    stand_bookcase,
    stand_chest,
    stand_desk,
    stand_plants,
    stand_radiator,
)
from indoor_rooms.layouts.common import bare_room, dress_window, hang_pictures, make_window, sill_ledge, wall_ledge
from indoor_rooms.layouts.contents import Contents, lay_things
from indoor_rooms.layouts.daylight import COLD, NEUTRAL, WARM, hour_of_day
from indoor_rooms.layouts.placement import Ledge, RoomBuilder, stream
from indoor_rooms.layouts.shell import ceiling_panel, daylight_lamps, hang_door, raise_walls
from indoor_rooms.layouts.walls import WALL_GAP, FloorLayout, Wall
from indoor_rooms.materials import textures
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import CHROME, plastic
from indoor_rooms.materials.themes import Theme, floor_of, pick_one, theme_of, upholstery_of
from indoor_rooms.room import Room

CONTENTS = Contents(
    ("scissors", "stapler", "laptop", "bag", "mug", "phone"),
    (
    "tape_dispenser", "pen_cup", "calculator", "binder", "notebook", "headphones", "water_bottle", "clock",
    "house_plant", "tissue_box", "lamp", "camera", "book", "radio", "apple", "book_stack", "globe", "photo_frame",
    "basket",
    ),
)  # fmt: skip
CARPETS = ("#6f7780", "#8a857c", "#4f5d6a", "#7a6f66", "#5f6f63", "#9a948a")
DOOR_PAINTS = ("#d8d4ca", "#e3ddd0")
CHAIR_SPACING = 0.78


def furnish_conference_room(seed: int, attempt: int, contents: Contents = CONTENTS, hour: str | None = None) -> Room:
    """A furnished conference room.

    Args:
        seed: everything follows from it.
        attempt: another arrangement for the same seed, for when one does not work out.
        contents: what lies about.
        hour: of the day, see `daylight.HOURS`; it follows from the seed if None.

    Raises:
        NoRoomError: if this arrangement leaves too little room for a robot or for things.
    """
    rng = stream(seed, f"conference room {attempt}")
    width, depth = float(rng.uniform(5.0, 6.1)), float(rng.uniform(4.5, 5.3))
    height = float(rng.uniform(2.55, 2.95))
    plan, builder, theme = FloorLayout(width, depth), RoomBuilder(), theme_of(rng)
    walls = list(plan.walls.values())
    order = [walls[int(index)] for index in rng.permutation(4)]
    windows = [make_window(plan, wall, rng, (0.78, 0.98), height) for wall in order[: 1 if rng.random() < 0.5 else 2]]
    light = hour_of_day([window.wall for window in windows], rng, hour)
    ledges = _table(builder, plan, theme, rng)
    hang_door(builder, plan, [*order[2:], *order[:2]], theme, rng, DOOR_PAINTS)
    _boards(builder, plan, order, rng)
    ledges += stand_chest(builder, plan, order, theme, "credenza", rng)
    ledges += stand_chest(builder, plan, order, theme, "sideboard", rng) if rng.random() < 0.5 else []
    if rng.random() < 0.7:
        ledges += stand_bookcase(builder, plan, order, theme.casing, "bookcase", rng)
    ledges += _filing_cabinet(builder, plan, order, rng)
    if rng.random() < 0.5:
        ledges += stand_desk(builder, plan, order, theme, rng, swivel=True)
    ledges += keep_floor(plan, order, 3, rng)
    stand_plants(builder, plan, order, int(rng.integers(1, 3)), rng)
    _odds_and_ends(builder, plan, order, rng)
    for window in windows:
        ledges.append(sill_ledge(window))
        if rng.random() < 0.6:
            stand_radiator(builder, window)
        dress_window(builder, window, theme, rng, floor=False)
    hang_pictures(builder, plan, theme.timber, rng, 2, walls)

    raise_walls(builder, plan, height, windows, theme, order[2], _floor(theme, rng))
    targets = lay_things(builder, plan, ledges, contents, seed)

    lamps = daylight_lamps(builder, windows, light, seed)
    colour = pick_one(rng, (COLD, NEUTRAL, WARM))
    for share in (0.3, 0.7):
        lamps.append(ceiling_panel(builder, width * share, depth / 2, height, 0.6, colour, 0.8 * light.lamps))
    return bare_room(builder, plan, height, f"conference_room_{seed}", targets, light.sun, light.sky, lamps)


def _floor(theme: Theme, rng: np.random.Generator) -> Material:
    """Carpet as often as not."""
    if rng.random() < 0.4:
        return floor_of(theme.floor, theme.seed)
    make = textures.carpet_tiles if rng.random() < 0.5 else textures.carpet
    return Material((1.0, 1.0, 1.0), make(pick_one(rng, CARPETS)), roughness=0.97, specular=0.05)


def _table(builder: RoomBuilder, plan: FloorLayout, theme: Theme, rng: np.random.Generator) -> list[Ledge]:
    """The long table in the middle, chairs on both sides; returns its two long edges and its ends."""
    turned = plan.depth > plan.width * 0.9 and rng.random() < 0.7
    length, depth = float(rng.uniform(1.9, 2.6)), float(rng.uniform(0.95, 1.15))
    x = plan.width / 2 + float(rng.uniform(-0.25, 0.25))
    y = plan.depth / 2 + float(rng.uniform(-0.15, 0.15))
    turn = 90.0 if turned else 0.0
    steel = plastic(pick_one(rng, ("#2f3236", "#c9cbcc", "#f0eee8")), 0.3)
    builder.add(
        "table", tables.conference_table(length, depth, theme.timber, steel), (x, y, 0.0004), turn, obstacle=True
    )
    fabric, swivel = (
        upholstery_of(pick_one(rng, ("#2f3438", "#38506b", "#7a3f38", theme.fabric)), rng),
        rng.random() < 0.5,
    )
    count = int((length - 0.3) / CHAIR_SPACING)
    places = (np.arange(count) - (count - 1) / 2) * min(CHAIR_SPACING + 0.1, (length - 0.3) / max(count, 1))
    number = 0
    for sign in (-1, 1):
        for along in places:
            if rng.random() < 0.12:
                continue
            number += 1
            chair = office.office_chair(fabric) if swivel else office.meeting_chair(fabric, CHROME)
            swing = float(rng.uniform(-12, 12))
            chair = placed(chair, turn=swing + (180.0 if sign > 0 else 0.0))
            # Pulled out far enough for the arms and the hands on the table.
            out = depth / 2 + float(rng.uniform(0.18, 0.30))
            chair = placed(chair, (float(along), sign * out, 0.0))
            builder.add(f"chair_{number}", chair, (x, y, 0.0006), turn, obstacle=True)
    half_x, half_y = length / 2 + 0.1, depth / 2 + 0.62
    half_x, half_y = (half_y, half_x) if turned else (half_x, half_y)
    # A robot passes all around.
    plan.take((x - half_x - 0.35, y - half_y - 0.35, x + half_x + 0.35, y + half_y + 0.35))
    return _edges(x, y, length, depth, turned)


def _edges(x: float, y: float, length: float, depth: float, turned: bool) -> list[Ledge]:
    """The table's two long edges, left and right of the cable cover in its middle."""
    ledges = []
    height = 0.0004 + tables.CONFERENCE_TABLE_HEIGHT
    reach, strip = length / 2 - 0.14, 0.30
    line = depth / 2 - 0.06 - strip / 2
    for start, end in (((-reach, -line), (reach, -line)), ((reach, line), (-reach, line))):
        if turned:
            start, end = (-start[1], start[0]), (-end[1], end[0])
        ledges.append(Ledge("table", "desk", (x + start[0], y + start[1]), (x + end[0], y + end[1]), height, strip))
    return ledges


def _boards(builder: RoomBuilder, plan: FloorLayout, walls: list[Wall], rng: np.random.Generator) -> None:
    """Whiteboard, screen and pinboard wherever a wall is free."""
    whiteboard, screen = float(rng.uniform(1.3, 1.9)), float(rng.uniform(1.1, 1.5))
    hung = (
        ("whiteboard", whiteboard, screens.whiteboard(whiteboard, 1.0, int(rng.integers(4))), 1.58),
        ("screen", screen, screens.wall_screen(screen, pick_one(rng, (None, 0, 1, 2))), 1.5),
        ("pinboard", 0.9, screens.pinboard(0.9, 0.6, rng), 1.5),
    )
    for (name, width, pieces, middle), chance in zip(hung, (0.95, 0.9, 0.5), strict=True):
        candidates = [walls[int(index)] for index in rng.permutation(4)]
        for wall in candidates if rng.random() < chance else []:
            # A whiteboard's tray reaches into the room: nothing stands below it.
            reach = 0.15 if name == "whiteboard" else 0.0
            along = plan.hanging_place(wall, width + 0.1, rng, out=reach)
            if along is not None:
                plan.take(wall.rectangle(along, width + 0.1, 0.0, reach))
                builder.add(name, pieces, wall.point(along, 0.001, middle), wall.turn)
                break


def _filing_cabinet(
    builder: RoomBuilder, plan: FloorLayout, walls: list[Wall], rng: np.random.Generator
) -> list[Ledge]:
    """One or two filing cabinets side by side."""
    count = int(rng.integers(1, 3))
    width, depth = 0.42 * count + 0.005 * (count - 1), 0.50
    found = plan.somewhere(walls, width, depth + 0.03, rng)
    if found is None:
        return []
    wall, along = found
    steel = Material(from_hex(pick_one(rng, ("#b9bcbc", "#6f777c", "#d8d4c8", "#3f4a52"))), roughness=0.4)
    drawers = int(rng.integers(2, 4))
    height = 0.74 if drawers == 2 else storage.FILING_CABINET_HEIGHT
    for number in range(count):
        place = along + (number - (count - 1) / 2) * 0.425
        cabinet = storage.filing_cabinet(steel, drawers, height=height)
        builder.add(f"filing_cabinet_{number + 1}", cabinet, wall.point(place, WALL_GAP), wall.turn, obstacle=True)
    deep = depth - 0.06
    return [wall_ledge(wall, (along, WALL_GAP + depth / 2, height), (width - 0.03, deep), "filing_cabinet", "board")]


def _odds_and_ends(builder: RoomBuilder, plan: FloorLayout, walls: list[Wall], rng: np.random.Generator) -> None:
    """A flip chart, a coat stand, a bin."""
    things = (
        ("flip_chart", 0.86, 0.84, 0.58, office.flip_chart(int(rng.integers(3))), True, 0.5),
        ("coat_stand", 0.55, 0.55, 0.30, office.coat_stand(pick_one(rng, (None, "#3d4a5c", "#8a3f38"))), True, 0.5),
        ("bin", 0.34, 0.34, 0.19, office.paper_bin(), False, 0.9),
    )
    for name, width, depth, out, pieces, tall, chance in things:
        found = plan.somewhere(walls, width, depth, rng, tall=tall) if rng.random() < chance else None
        if found is not None:
            wall, along = found
            builder.add(name, pieces, wall.point(along, WALL_GAP + out, 0.0006), wall.turn, obstacle=True)
