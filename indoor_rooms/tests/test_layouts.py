"""Properties of generated rooms: sound whatever the seed, the same for the same seed, different for another."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from box_room import box_room
from indoor_rooms.free_space import free_positions
from indoor_rooms.geometry.boxes import box
from indoor_rooms.geometry.pieces import bounds
from indoor_rooms.layouts import LAYOUTS, Layout, LayoutError, make_room
from indoor_rooms.layouts.contents import ALLOWED, SCENERY, SURFACES, SWING, Contents
from indoor_rooms.layouts.placement import Item, Ledge, NoRoomError, assign, lay_out
from indoor_rooms.layouts.walls import FloorLayout, four_walls
from indoor_rooms.materials.surfaces import beech
from indoor_rooms.objects import OBJECTS
from indoor_rooms.room import Room
from indoor_rooms.validation import room_problems
from made_rooms import made_room, together

# A few here; `active-perceiver scenes preview LAYOUT --count 40` checks as many as one likes.
SEEDS = (1, 2, 11)
EACH_LAYOUT = [pytest.param(layout, marks=together(layout)) for layout in LAYOUTS]


@pytest.fixture(
    params=[
        pytest.param((layout, seed), id=f"{layout}-{seed}", marks=together(layout))
        for layout in LAYOUTS
        for seed in SEEDS
    ]
)
def room(request: pytest.FixtureRequest) -> Room:
    return made_room(*request.param)


def test_rooms_are_sound(room: Room) -> None:
    """Nothing intersects, floats, tips over or lies out of reach; see `room_problems`."""
    assert room_problems(room) == []


def test_rooms_have_what_is_searched_and_space_for_a_robot(room: Room) -> None:
    layout = room.name.rsplit("_", 1)[0]
    assert set(LAYOUTS[layout].contents.required) <= set(room.targets)
    assert len(room.targets) >= 12
    assert not set(SCENERY) & set(room.targets)
    assert all(name in OBJECTS and category == name for name, category in room.targets.items())
    assert len(free_positions(room)) >= 25
    assert any(lamp.object_name == "outside" for lamp in room.lamps)
    for low, high in ((room.size[0], 3.5), (room.size[1], 3.5), (room.size[2], 2.4)):
        assert low >= high


@pytest.mark.parametrize("layout", EACH_LAYOUT)
def test_rooms_follow_their_seed(layout: str) -> None:
    first, again, other = made_room(layout, 3), make_room(layout, 3), made_room(layout, 4)
    assert first is not again
    assert first.sun == again.sun
    assert first.targets == again.targets
    assert first.size == again.size != other.size
    for part, same in zip(first.parts, again.parts, strict=True):
        assert part.object_name == same.object_name
        np.testing.assert_array_equal(part.mesh.vertices, same.mesh.vertices)
        assert part.material.colour == same.material.colour
    for (label, polygon), (same_label, same_polygon) in zip(first.obstacles, again.obstacles, strict=True):
        assert label == same_label
        np.testing.assert_array_equal(polygon, same_polygon)


def shapes(room: Room, names: set[str] | None = None) -> list[tuple[str, bytes]]:
    """Every mesh there is, or those of some objects."""
    return [
        (part.object_name, part.mesh.vertices.tobytes())
        for part in room.parts
        if names is None or part.object_name in names
    ]


@pytest.fixture(params=EACH_LAYOUT)
def first(request: pytest.FixtureRequest) -> Room:
    """The first room of each layout."""
    return made_room(request.param, 1)


def test_another_hour_changes_nothing_but_the_light(first: Room) -> None:
    hour = "noon" if first.sun is None else "dusk"
    other = make_room(first.name.removesuffix("_1"), 1, hour=hour)
    assert shapes(other) == shapes(first)
    assert other.targets == first.targets
    assert [lamp.centre for lamp in other.lamps] == [lamp.centre for lamp in first.lamps]
    assert (other.sun is None) == (hour == "dusk")
    assert other.sky != first.sky


def test_moved_things_are_the_same_things_on_the_same_furniture(first: Room) -> None:
    layout = first.name.removesuffix("_1")
    room, moved = first, make_room(layout, 1, moved=1)
    things = {*LAYOUTS[layout].contents.required, *LAYOUTS[layout].contents.optional, "pot", "pan", "kettle"}
    furniture = {part.object_name for part in room.parts} - things
    assert shapes(moved, furniture) == shapes(room, furniture)
    assert (moved.sun, moved.lamps) == (room.sun, room.lamps)
    assert set(LAYOUTS[layout].contents.required) <= set(moved.targets)
    assert room_problems(moved) == []
    elsewhere = [name for name in moved.targets if shapes(moved, {name}) != shapes(room, {name})]
    assert len(elsewhere) > len(moved.targets) * 0.7
    for name in set(moved.targets) & set(room.targets):
        heights = [np.ptp(np.concatenate(meshes(one, name))[:, 2]) for one in (room, moved)]
        assert heights[0] == pytest.approx(heights[1], abs=1e-9)


def meshes(room: Room, name: str) -> list[np.ndarray]:
    return [part.mesh.vertices for part in room.parts if part.object_name == name]


def test_an_arrangement_that_does_not_work_out_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    def small(seed: int, attempt: int, contents: Contents, hour: str | None) -> Room:
        if attempt < 2 or contents.moved == 3:
            raise NoRoomError("no room for bread")
        return replace(box_room(), name=f"{attempt} {contents.moved}")

    monkeypatch.setitem(LAYOUTS, "kitchen", Layout(small, Contents(())))
    assert make_room("kitchen", 1).name == "2 None"
    assert make_room("kitchen", 1, moved=5).name == "2 5"
    assert make_room("kitchen", 1, moved=6).name == "2 6"  # in the same arrangement of furniture
    with pytest.raises(LayoutError, match=r"arrangement 3 .*no room for bread.*take another number"):
        make_room("kitchen", 1, moved=3)


@pytest.mark.parametrize(
    ("change", "message"), [({"hour": "midnight"}, "morning, noon, afternoon"), ({"moved": 0}, "at least 1")]
)
def test_unknown_hours_and_arrangements_are_explained(change: dict, message: str) -> None:
    with pytest.raises(LayoutError, match=message):
        make_room("kitchen", 1, **change)


@pytest.mark.parametrize("layout", EACH_LAYOUT)
def test_seeds_differ_in_furniture_light_and_colours(layout: str) -> None:
    rooms = [made_room(layout, seed) for seed in range(1, 7)]
    assert len({room.size for room in rooms}) == 6
    assert len({tuple(sorted(label for label, _ in room.obstacles)) for room in rooms}) >= 3
    assert len({room.sun for room in rooms}) >= 3
    floors = [next(part.material.texture for part in room.parts if part.object_name == "floor") for room in rooms]
    assert len({id(floor) for floor in floors}) >= 3


@pytest.mark.parametrize(
    ("layout", "seed", "message"),
    [("castle", 1, "conference_room, kitchen, living_room"), ("kitchen", 0, "at least 1"), ("", 1, "no room layout")],
)
def test_unknown_layouts_and_seeds_are_explained(layout: str, seed: int, message: str) -> None:
    with pytest.raises(LayoutError, match=message):
        make_room(layout, seed)


def test_a_seed_that_never_works_out_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_small(seed: int, attempt: int, contents: Contents, hour: str | None) -> Room:
        raise NoRoomError("no room for a door")

    monkeypatch.setitem(LAYOUTS, "kitchen", Layout(too_small, Contents(())))
    with pytest.raises(LayoutError, match=r"seed 1 \(no room for a door\); take another seed"):
        make_room("kitchen", 1)


def test_every_thing_has_a_generator_and_known_surfaces() -> None:
    for name, surfaces in ALLOWED.items():
        assert name in OBJECTS or name == "microwave"
        assert surfaces
        assert set(surfaces) <= set(SURFACES)
    assert set(SWING) <= set(ALLOWED)
    for layout in LAYOUTS.values():
        assert {*layout.contents.required, *layout.contents.optional} <= set(ALLOWED)


@together("conference_room")
def test_the_same_things_can_lie_in_another_room() -> None:
    """As in the paper, whose recogniser learned its targets elsewhere."""
    here = made_room("conference_room", 1)
    elsewhere = make_room("living_room", 5, Contents(("scissors", "stapler", "mug"), ("phone",), seed=2001))
    assert {"scissors", "stapler", "mug"} <= set(elsewhere.targets) <= {"scissors", "stapler", "mug", "phone"}

    def edges(room: Room, name: str) -> np.ndarray:
        mesh = next(part.mesh for part in room.parts if part.object_name == name)
        corners = mesh.vertices[mesh.faces]
        return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)

    for name in ("scissors", "stapler", "mug"):
        np.testing.assert_allclose(edges(here, name), edges(elsewhere, name), atol=1e-9)


@given(width=st.floats(2, 8), depth=st.floats(2, 8), along=st.floats(0, 2), out=st.floats(0, 1))
def test_walls_agree_with_the_room(width: float, depth: float, along: float, out: float) -> None:
    walls = four_walls(width, depth)
    for wall in walls.values():
        x, y, _ = wall.point(along, out)
        assert -1e-9 <= x <= width + 1e-9
        assert -1e-9 <= y <= depth + 1e-9
        x0, y0, x1, y1 = wall.rectangle(along, 0.4, out, 0.3)
        assert {round(x1 - x0, 9), round(y1 - y0, 9)} == {0.4, 0.3}
        # To the right along a wall its neighbour follows: the right end of one is the left end of the next.
    order = [walls[name] for name in ("north", "east", "south", "west")]
    for wall, following in zip(order, order[1:] + order[:1], strict=True):
        np.testing.assert_allclose(wall.point(wall.length)[:2], following.left, atol=1e-9)


@given(seed=st.integers(0, 10_000), sizes=st.lists(st.tuples(st.floats(0.2, 1.5), st.floats(0.2, 0.9)), max_size=9))
def test_furniture_never_overlaps(seed: int, sizes: list[tuple[float, float]]) -> None:
    plan, rng = FloorLayout(4.0, 3.5), np.random.default_rng(seed)
    taken = []
    for width, depth in sizes:
        found = plan.somewhere(list(plan.walls.values()), width, depth, rng)
        if found is not None:
            wall, along = found
            taken.append(wall.rectangle(along, width, 0.02, depth))
    for index, (x0, y0, x1, y1) in enumerate(taken):
        assert min(x0, y0) >= 0
        assert x1 <= 4.0
        assert y1 <= 3.5
        for a0, b0, a1, b1 in taken[index + 1 :]:
            assert x1 <= a0 or a1 <= x0 or y1 <= b0 or b1 <= y0


def block(
    name: str, width: float, depth: float = 0.1, height: float = 0.2, surfaces: tuple[str, ...] = ("table",)
) -> Item:
    return Item(name, [(box((-width / 2, -depth / 2, 0.0), (width / 2, depth / 2, height)), beech())], surfaces)


TABLE = Ledge("table", "table", (0.0, 0.0), (1.0, 0.0), 0.7, 0.3)
SHELF = Ledge("bookcase", "shelf", (0.0, 1.0), (0.5, 1.0), 1.0, 0.3, headroom=0.25)


@given(seed=st.integers(0, 10_000), widths=st.lists(st.floats(0.05, 0.3), min_size=1, max_size=8))
def test_things_in_a_row_keep_apart_and_on_their_ledge(seed: int, widths: list[float]) -> None:
    rng = np.random.default_rng(seed)
    items = [block(f"thing {number}", width) for number, width in enumerate(widths)]
    chosen = assign(items, [TABLE], (), rng)[0]
    places = []
    lay_out(
        chosen, TABLE, rng, lambda name, pieces, place, turn: places.append((place, bounds(m for m, _ in pieces)))
    )
    spans = sorted((place[0] + extent[0, 0], place[0] + extent[1, 0]) for place, extent in places)
    assert all(low >= 0 and high <= 1 for low, high in spans)
    assert all(high + 0.04 <= low for (_, high), (low, _) in pairwise(spans))


def test_things_go_where_they_may_and_fit() -> None:
    rng = np.random.default_rng(0)
    tall, low = block("tall", 0.1, height=0.3, surfaces=("shelf", "table")), block("low", 0.1, surfaces=("shelf",))
    deep = block("deep", 0.1, depth=0.5)
    table, shelf = assign([tall, low, deep], [TABLE, SHELF], (), rng)
    assert [item.name for item in table] == ["tall"]
    assert [item.name for item in shelf] == ["low"]
    with pytest.raises(NoRoomError, match="deep"):
        assign([tall, deep], [TABLE, SHELF], ("deep",), rng)


def test_required_things_stand_on_different_furniture() -> None:
    desk = Ledge("desk", "table", (0.0, 2.0), (1.0, 2.0), 0.7, 0.3)
    for seed in range(20):
        rows = assign([block("a", 0.1), block("b", 0.1)], [TABLE, desk], ("a", "b"), np.random.default_rng(seed))
        assert [len(row) for row in rows] == [1, 1]
