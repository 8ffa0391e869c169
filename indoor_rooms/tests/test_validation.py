"""Rooms that are broken on purpose: each fault is found and named, and nothing else is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

pytest.importorskip("embreex")

from hypothesis import given
from hypothesis import strategies as st

from box_room import GREY, TABLE, make_room, solid, walls
from indoor_rooms.collision import (
    DEEPEST,
    DIRECTIONS,
    NUDGE,
    PRECISION,
    TOLERANCE,
    Solid,
    distance_from_hull,
    inside,
    intersection,
)
from indoor_rooms.geometry.mesh import Mesh, merge, quad, rotation, transform, without_sides
from indoor_rooms.layouts import make_room as furnished
from indoor_rooms.room import Lamp, Part, Room, Sun
from indoor_rooms.validation import room_problems, stem

TABLE_TOP = 0.7
# The tilted DIRECTIONS leave no direction further from one of them than this cosine.
NEAREST_COSINE = 0.88


def table_room(*parts: Part, targets: Sequence[str] = (), **fields: object) -> Room:
    """A room with a table, from (1, 0.4) to (1.6, 1.0) and 0.7 m high, and other parts."""
    table = Part("table", solid((1.0, 0.4, 0.0), (1.6, 1.0, TABLE_TOP)), GREY)
    room = make_room(
        (*walls(), table, *parts), targets={name: name for name in targets}, obstacles=(("table", TABLE),)
    )
    return replace(room, **fields)


def thing(name: str, low: Sequence[float], size: Sequence[float]) -> Part:
    return Part(name, solid(low, np.add(low, size)), GREY)


def mug(lift: float, x: float = 1.2, name: str = "mug") -> Part:
    """A box of 8 x 8 x 10 cm standing `lift` metres above the table."""
    return thing(name, (x, 0.6, TABLE_TOP + lift), (0.08, 0.08, 0.1))


def body(mesh: Mesh) -> Solid:
    return Solid("body", [mesh])


@pytest.mark.parametrize("lift", [0.0008, 0.0, -0.001, -0.0018])
def test_a_thing_that_stands_on_a_table_is_no_fault(lift: float) -> None:
    assert room_problems(table_room(mug(lift), targets=["mug"])) == []


def test_intersections_are_found_and_measured() -> None:
    assert room_problems(table_room(mug(-0.005))) == ["mug intersects table by 5 mm at (1.24, 0.64, 0.70)"]
    first = thing("plate", (1.2, 0.6, TABLE_TOP), (0.1, 0.1, 0.1))
    # They are aligned: all their edges are in each other's faces, and only diagonals cross.
    assert room_problems(table_room(first, thing("mug", (1.295, 0.6, TABLE_TOP), (0.1, 0.1, 0.1)))) == [
        "plate intersects mug by 5 mm at (1.30, 0.65, 0.75)"
    ]
    assert room_problems(table_room(first, thing("mug", (1.299, 0.6, TABLE_TOP), (0.1, 0.1, 0.1)))) == []


def test_what_lies_inside_something_or_in_its_very_place_intersects_it() -> None:
    (sentence,) = room_problems(table_room(thing("box", (1.2, 0.6, 0.3), (0.1, 0.1, 0.1))))
    assert sentence == "box intersects table by 256 mm at (1.25, 0.65, 0.35)"
    (sentence,) = room_problems(table_room(mug(0), mug(0, name="can")))
    assert sentence.startswith("mug intersects can by 8")


def test_bars_and_sheets_that_pierce_each_other_intersect() -> None:
    along = body(solid((-0.3, -0.01, 0), (0.3, 0.01, 0.02)))
    across = body(solid((-0.01, -0.3, 0), (0.01, 0.3, 0.02)))
    found = intersection(along, across)
    assert found is not None
    assert found.depth == pytest.approx(0.02, abs=0.002)
    sheet, other = (
        body(quad((-0.1, 0, -0.1), (0.2, 0, 0), (0, 0, 0.2))),
        body(quad((0, -0.1, -0.1), (0, 0.2, 0), (0, 0, 0.2))),
    )
    assert intersection(sheet, other) is not None
    assert intersection(sheet, body(quad((-0.1, 0.001, -0.1), (0.2, 0, 0), (0, 0, 0.2)))) is None


def test_a_bulb_may_be_in_its_lamp_and_a_sink_in_its_countertop() -> None:
    bulb = thing("lamp_bulb", (2.0, 1.5, 2.0), (0.1, 0.1, 0.1))
    shade = thing("floor_lamp", (1.9, 1.4, 1.9), (0.3, 0.3, 0.3))
    lamp = Lamp("lamp_bulb", (2.05, 1.55, 2.05), None, 0.05, (1.0, 1.0, 1.0))
    assert room_problems(table_room(bulb, shade, lamps=(lamp,))) == []
    assert len(room_problems(table_room(bulb, shade))) == 1
    top = thing("countertop_2", (1.0, 0.4, 0.9), (0.5, 0.5, 0.04))
    assert room_problems(table_room(top, thing("sink", (1.1, 0.5, 0.8), (0.2, 0.2, 0.13)))) == []
    assert len(room_problems(table_room(top, thing("box", (1.1, 0.5, 0.8), (0.2, 0.2, 0.13))))) == 1


def test_numbers_are_no_part_of_a_stem() -> None:
    assert stem("mug_12") == "mug"
    assert stem("wall_cabinet") == "wall_cabinet"


def test_inside_withstands_missing_sides_and_shells_pushed_together() -> None:
    shells = [solid((0, 0, 0), (1, 1, 1)), solid((0.8, 0, 0), (2, 1, 1))]
    points = np.array([[0.5, 0.5, 0.5], [0.9, 0.5, 0.5], [1.5, 0.5, 0.5], [2.5, 0.5, 0.5], [0.5, 0.5, -0.1]])
    expected = [True, True, True, False, False]
    np.testing.assert_array_equal(inside(body(merge(shells)), points), expected)
    np.testing.assert_array_equal(inside(body(without_sides(merge(shells), "+y")), points), expected)
    outside_in = merge([Mesh(mesh.vertices, -mesh.normals, mesh.uvs, mesh.faces[:, ::-1]) for mesh in shells])
    assert not inside(body(outside_in), points).any()


def test_floating_things_are_found() -> None:
    assert room_problems(table_room(mug(0.023, name="mug_2"))) == ["mug_2 floats 23 mm above table"]
    assert room_problems(table_room(mug(0.006))) == ["mug floats 6 mm above table"]
    assert room_problems(table_room(mug(0.0), mug(0.1, name="can"))) == []
    # What hangs on a wall is no fault, nor is what is not known as a thing.
    assert room_problems(table_room(thing("mug", (0.005, 1.5, 1.5), (0.1, 0.1, 0.1)))) == []
    assert room_problems(table_room(thing("picture", (2.0, 1.5, 1.5), (0.1, 0.1, 0.1)))) == []
    (bottomless,) = room_problems(table_room(thing("mug", (1.2, 3.5, 1.5), (0.1, 0.1, 0.1))))[1:]
    assert bottomless == "mug floats over nothing"
    assert room_problems(table_room(thing("mug", (2.0, 1.5, 1.5), (0.1, 0.1, 0.1)))) == [
        "mug floats 1500 mm above floor"
    ]


def test_things_over_an_edge_are_found() -> None:
    assert room_problems(table_room(mug(0, x=1.55))) == ["mug rests on table with only 50 % of its foot"]
    foot, arm = solid((1.5, 0.6, TABLE_TOP), (1.58, 0.68, 0.75)), solid((1.5, 0.6, 0.7501), (1.98, 0.68, 0.8))
    (sentence,) = room_problems(table_room(Part("mug", merge([foot, arm]), GREY)))
    assert sentence.startswith("mug tips over: its weight is ")
    assert sentence.endswith(" mm beyond what supports it on table")
    near = solid((1.5, 0.6, 0.7501), (1.6, 0.68, 0.8))
    assert room_problems(table_room(Part("mug", merge([foot, near]), GREY))) == []


def test_distance_from_the_hull_of_many_points_of_a_line_and_of_one() -> None:
    square = np.array(list(product((0.0, 1.0), repeat=2)))
    assert distance_from_hull(np.array([0.5, 0.5]), square) == 0
    assert distance_from_hull(np.array([1.5, 0.5]), square) == pytest.approx(0.5)
    assert distance_from_hull(np.array([2.0, 2.0]), square) == pytest.approx(2**0.5, rel=1e-3)
    assert distance_from_hull(np.array([0.5, 0.2]), square[:2] * [1, 1]) == pytest.approx(0.5)
    assert distance_from_hull(np.array([3.0, 4.0]), np.zeros((1, 2))) == pytest.approx(5, rel=1e-3)


def test_furniture_stands_on_the_floor_or_on_a_rug() -> None:
    def chair(low: float) -> Room:
        rug = thing("rug", (2.0, 1.0, 0.0006), (1.0, 1.0, 0.01))
        seat = thing("chair", (2.2, 1.2, low), (0.4, 0.4, 0.4))
        polygon = np.array([[2.2, 1.2], [2.6, 1.2], [2.6, 1.6], [2.2, 1.6]])
        return table_room(rug, seat, obstacles=(("table", TABLE), ("chair", polygon), ("counter", TABLE)))

    assert room_problems(chair(0.0108)) == []
    assert room_problems(chair(0.0606)) == ["chair floats 50 mm above a rug"]
    assert room_problems(chair(0.002)) == ["rug intersects chair by 9 mm at (2.40, 1.40, 0.01)"]


def test_what_is_outside_the_room_is_found_unless_it_is_on_a_window_sill() -> None:
    window = Part("window", solid((1.0, 2.9, 0.97), (2.0, 3.14, 1.0)), GREY)
    room = table_room(window, thing("mug", (1.4, 2.98, 1.0), (0.08, 0.08, 0.1)))
    # The recess of the window is where the northern wall has a hole.
    room = replace(room, parts=tuple(part for part in room.parts if part.mesh.vertices[:, 1].min() < 3))
    high = Part("window", solid((1.0, 3.10, 1.0), (2.0, 3.14, 2.0)), GREY)
    tall = replace(room, parts=(*room.parts, Part("window", merge([window.mesh, high.mesh]), GREY)))
    assert room_problems(room) == ["mug reaches 60 mm out of the room"]
    assert room_problems(tall) == []
    plate = thing("box", (2.5, 2.98, 1.0), (0.08, 0.08, 0.1))
    assert "box reaches 60 mm out of the room" in room_problems(replace(tall, parts=(*tall.parts, plate)))


def test_a_room_without_room_is_found() -> None:
    blocked = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]])
    (sentence,) = room_problems(table_room(obstacles=(("block", blocked),)))
    assert sentence.startswith("a robot has only ")
    assert sentence.endswith(" free positions in one connected part, fewer than 25")
    assert room_problems(table_room(obstacles=(("block", blocked),)), smallest_free=5) == []
    everything = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    (sentence,) = room_problems(table_room(obstacles=(("block", everything),)))
    assert "no free position" in sentence


def test_targets_must_be_near_and_in_sight() -> None:
    low = np.array([1.1, 0.5, TABLE_TOP])
    walls_of_chest = [
        solid(low + np.multiply(a, 0.3), low + np.multiply(b, 0.3))
        for a, b in (
            ((0, 0, 0), (0.1, 1, 1)),
            ((0.9, 0, 0), (1, 1, 1)),
            ((0.1, 0, 0), (0.9, 0.1, 1)),
            ((0.1, 0.9, 0), (0.9, 1, 1)),
            ((0.1, 0.1, 0.9), (0.9, 0.9, 1)),
        )
    ]
    chest = Part("chest", merge(walls_of_chest), GREY)
    cup = mug(0)
    (sentence,) = room_problems(table_room(chest, cup, targets=["mug"]))
    assert sentence == (
        "mug at (1.24, 0.64, 0.75) is hidden: from no free position within 1.5 m are more than 0 of 24 points of it "
        "in sight"
    )
    open_chest = Part("chest", merge(walls_of_chest[:3]), GREY)
    assert room_problems(table_room(open_chest, cup, targets=["mug"])) == []
    wide = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]])
    far = table_room(cup, targets=["mug"], obstacles=(("block", wide),))
    assert room_problems(far, smallest_free=1) == [
        "mug at (1.24, 0.64, 0.75) is more than 1.5 m from every free position"
    ]
    assert room_problems(table_room(targets=["ghost"])) == ["the target 'ghost' is no part of the room"]


def test_what_is_inside_a_target_need_not_be_seen() -> None:
    pages = [solid((1.205 + 0.001 * page, 0.605, 0.705), (1.2055 + 0.001 * page, 0.675, 0.795)) for page in range(60)]
    book = Part("book", merge([mug(0).mesh, *pages]), GREY)
    assert room_problems(table_room(book, targets=["book"])) == []


def test_lamps_shine_from_parts_and_the_sun_from_above() -> None:
    lamp = Lamp("nowhere", (2.0, 1.5, 2.0), None, 0.05, (1.0, 1.0, 1.0))
    sun = Sun((0.3, -0.5, 0.1), (1.0, 1.0, 1.0), 1.0)
    assert room_problems(table_room(lamps=(lamp,), sun=sun)) == [
        "the lamp 'nowhere' is no part of the room",
        "the sun shines upwards: its direction is (0.30, -0.50, 0.10)",
    ]


def test_broken_meshes_are_found() -> None:
    cup = mug(0).mesh

    def problems(**fields: np.ndarray) -> list[str]:
        return room_problems(table_room(Part("mug", replace(cup, **fields), GREY)))

    assert problems() == []
    flipped = cup.faces.copy()
    flipped[3] = flipped[3, ::-1]
    assert problems(faces=flipped) == ["mug has 1 of 12 triangles wound against their normals"]
    assert problems(normals=cup.normals * 1.5) == ["mug has normals whose length is off by 0.5"]
    assert "not finite" in problems(vertices=np.where(cup.vertices > 0.75, np.nan, cup.vertices))[0]
    assert "do not exist" in problems(faces=cup.faces + 1)[0]
    assert "without triangles" in problems(faces=cup.faces[:0])[0]
    (sentence,) = problems(faces=np.tile(cup.faces, (21_000, 1)))
    assert sentence == "the room has 252024 triangles, 250000 or more"


numbers = st.floats(-1.0, 1.0)
poses = st.tuples(*[numbers] * 6)
sizes = st.tuples(*[st.floats(0.03, 0.3)] * 3)


def posed(mesh: Mesh, pose: Sequence[float]) -> Mesh:
    """A mesh turned at will and moved by up to 25 cm."""
    offset = np.multiply(pose[:3], 0.25)
    return transform(mesh, tuple(offset), tuple(np.multiply(pose[3:], 180.0)))


def box_of(size: Sequence[float]) -> Mesh:
    return solid(np.multiply(size, -0.5), np.multiply(size, 0.5))


def overlap_of_boxes(
    size: Sequence[float], other_size: Sequence[float], pose: Sequence[float], other_pose: Sequence[float]
) -> float:
    """How far two boxes have to be moved apart, exactly, by the 15 axes of the separating axis theorem."""
    axes, other_axes = (rotation(*np.multiply(each[3:], 180.0)).T for each in (pose, other_pose))
    ways = np.concatenate([axes, other_axes, np.cross(axes[:, None], other_axes[None]).reshape(-1, 3)])
    length = np.linalg.norm(ways, axis=1)
    ways = ways[length > 1e-6] / length[length > 1e-6, None]
    reach = np.abs(ways @ axes.T) @ np.multiply(size, 0.5) + np.abs(ways @ other_axes.T) @ np.multiply(
        other_size, 0.5
    )
    between = np.abs(ways @ (np.subtract(pose[:3], other_pose[:3]) * 0.25))
    return float((reach - between).min())


def test_no_direction_is_far_from_those_tried() -> None:
    ways = np.random.default_rng(1).normal(size=(20_000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    assert (ways @ DIRECTIONS.T).max(axis=1).min() > NEAREST_COSINE


@given(sizes, sizes, poses, poses)
def test_boxes_agree_with_the_separating_axis_theorem(size, other_size, pose, other_pose) -> None:
    depth = overlap_of_boxes(size, other_size, pose, other_pose)
    found = intersection(body(posed(box_of(size), pose)), body(posed(box_of(other_size), other_pose)))
    if depth < TOLERANCE * NEAREST_COSINE:
        assert found is None
    elif depth > TOLERANCE * 1.05:
        assert found is not None
        assert found.depth > min(depth, DEEPEST) - 1e-4
        assert found.depth < depth / NEAREST_COSINE + PRECISION


def any_edge_crosses(first: Mesh, second: Mesh) -> bool:
    """Every edge of each mesh against every triangle of the other, by signed volumes."""

    def volume(a, b, c, d):
        return (np.cross(b - a, c - a) * (d - a)).sum(axis=-1)

    for one, other in ((first, second), (second, first)):
        p, q = (
            one.vertices[np.concatenate([one.faces, np.roll(one.faces, end, axis=1)][end]).reshape(-1)]
            for end in (0, 1)
        )
        a, b, c = (other.vertices[other.faces[:, corner]][None] for corner in range(3))
        p, q = p[:, None], q[:, None]
        turns = np.stack([volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)])
        through = (turns > 0).all(axis=0) | (turns < 0).all(axis=0)
        if (through & (volume(a, b, c, p) * volume(a, b, c, q) < 0)).any():
            return True
    return False


@given(sizes, sizes, poses, poses)
def test_open_boxes_agree_with_every_edge_against_every_triangle(size, other_size, pose, other_pose) -> None:
    first = posed(without_sides(box_of(size), "+z"), pose)
    second = posed(without_sides(box_of(other_size), "+z", "-x"), other_pose)
    one, other = body(first), body(second)
    if (one.low >= other.low).all() and (one.high <= other.high).all():
        return
    if (other.low >= one.low).all() and (other.high <= one.high).all():
        return
    held = all(any_edge_crosses(transform(first, tuple(shift)), second) for shift in (*DIRECTIONS * TOLERANCE, NUDGE))
    assert (intersection(one, other) is not None) == held


@pytest.mark.parametrize("seed", [1, 2])
def test_the_kitchen_is_sound_until_something_is_moved(seed: int) -> None:
    room = furnished("kitchen", seed)
    assert room_problems(room) == []
    name = min(room.targets)
    sunk = tuple(
        replace(part, mesh=transform(part.mesh, (0.0, 0.0, -0.01))) if part.object_name == name else part
        for part in room.parts
    )
    problems = room_problems(replace(room, parts=sunk))
    assert any(f"{name} intersects" in problem for problem in problems), problems
