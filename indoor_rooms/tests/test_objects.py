"""What every kind of small object keeps to, whatever its seed: sound, standing, in one piece, of a real size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_rooms.geometry.mesh import Mesh
from indoor_rooms.geometry.pieces import Pieces, bounds
from indoor_rooms.materials import prints_devices, prints_paper, prints_patterns
from indoor_rooms.objects import OBJECTS
from indoor_rooms.objects.shaping import (
    blob,
    bulge,
    cap,
    closed_curve,
    facing,
    keypad,
    mirrored,
    prism,
    rounded_rectangle,
    two_colours,
)

SMALLEST, LARGEST = 0.015, 0.6
MOST_TRIANGLES = 4200
SEEDS = st.integers(0, 10_000)
# Kinds that the rooms are to be searched for, and so must be there.
WANTED = {
    *("remote_control", "phone", "laptop", "lamp", "clock", "headphones", "game_controller", "radio", "scissors"),
    *("stapler", "tape_dispenser", "pen_cup", "calculator", "binder", "notebook", "cushion", "candle", "photo_frame"),
    *("house_plant", "bag", "teddy_bear", "globe", "tissue_box", "ball", "water_bottle", "camera", "book_stack"),
    *("basket", "mug", "bottle", "vase", "bowl", "book"),
}


def made(category: str, seed: int) -> Pieces:
    return OBJECTS[category](np.random.default_rng(seed))


def winding(mesh: Mesh) -> np.ndarray:
    """(F, 3) normals of the triangles, as long as twice their area."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def assert_sound(mesh: Mesh) -> None:
    assert np.isfinite(mesh.vertices).all()
    assert np.isfinite(mesh.uvs).all()
    assert mesh.faces.min() >= 0
    assert mesh.faces.max() < len(mesh.vertices)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)
    turned = winding(mesh)
    agreement = (turned * mesh.normals[mesh.faces].mean(axis=1)).sum(axis=1)
    large = np.linalg.norm(turned, axis=1) > 2e-9
    assert (agreement[large] > 0).all(), f"{int((agreement[large] <= 0).sum())} triangles face inwards"


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def assert_hangs_together(pieces: Pieces, gap: float = 0.003) -> None:
    """Every piece's box touches, by way of others, the first one's."""
    boxes = [bounds([mesh]) for mesh, _ in pieces]
    reached, waiting = [boxes[0]], list(range(1, len(boxes)))
    while waiting:
        touching = [
            index
            for index in waiting
            if any(((boxes[index][0] <= b[1] + gap) & (b[0] <= boxes[index][1] + gap)).all() for b in reached)
        ]
        assert touching, f"pieces {waiting} float"
        reached += [boxes[index] for index in touching]
        waiting = [index for index in waiting if index not in touching]


def test_all_kinds_wanted_are_there() -> None:
    assert set(OBJECTS) >= WANTED


@pytest.mark.parametrize("category", OBJECTS)
@settings(max_examples=6, deadline=None, derandomize=True)
@given(seed=SEEDS)
def test_objects_are_sound_and_stand(category: str, seed: int) -> None:
    pieces = made(category, seed)
    for mesh, material in pieces:
        assert_sound(mesh)
        assert material.emission == 0.0
        assert min(material.colour) >= 0.0
        assert max(material.colour) <= 1.0
    low, high = bounds(mesh for mesh, _ in pieces)
    assert abs(low[2]) < 1e-3
    assert SMALLEST < (high - low).max() < LARGEST
    # The origin lies below the object, though a handle or a spout may reach out on one side.
    assert (low[:2] < 0).all()
    assert (high[:2] > 0).all()
    assert sum(len(mesh.faces) for mesh, _ in pieces) <= MOST_TRIANGLES
    assert_hangs_together(pieces)


@pytest.mark.parametrize("category", OBJECTS)
@settings(max_examples=3, deadline=None, derandomize=True)
@given(seed=SEEDS)
def test_objects_follow_their_seed(category: str, seed: int) -> None:
    for (mesh, material), (same, again) in zip(made(category, seed), made(category, seed), strict=True):
        np.testing.assert_array_equal(mesh.vertices, same.vertices)
        np.testing.assert_array_equal(mesh.faces, same.faces)
        assert material.colour == again.colour
        assert material.texture is again.texture


def looks(pieces: Pieces) -> tuple[object, ...]:
    """What the eye tells two things of a kind apart by: colours, prints, and size to half a centimetre."""
    size = np.ptp(bounds(mesh for mesh, _ in pieces), axis=0)
    colours = tuple((material.colour, id(material.texture), material.metalness) for _, material in pieces)
    return (*colours, tuple(np.round(size * 200).astype(int)), tuple(len(mesh.faces) for mesh, _ in pieces))


@pytest.mark.parametrize("category", OBJECTS)
def test_two_of_a_kind_look_different(category: str) -> None:
    seen = {looks(made(category, seed)) for seed in range(12)}
    assert len(seen) >= 10, f"only {len(seen)} of 12 differ to the eye"


@pytest.mark.parametrize("category", sorted(WANTED - {"candle", "laptop"}))
def test_most_kinds_come_in_many_colours(category: str) -> None:
    colours = {
        tuple((material.colour, id(material.texture)) for _, material in made(category, seed)) for seed in range(16)
    }
    assert len(colours) >= 8


SOLIDS = {
    "prism": (prism(rounded_rectangle(0.1, 0.06, 0.02, 12), 0.03, 0.0001), 0.03 * (0.006 - (4 - np.pi) * 0.0004)),
    "sharp prism": (prism([(0, 0), (0.1, 0), (0, 0.1)], 0.02, 1e-5), 0.0001),
    "bulge": (bulge(rounded_rectangle(0.1, 0.1, 0.05, 24), 0.05, 0.05, 1.0, 24), 4 / 3 * np.pi * 0.05**3),
    "blob": (blob((0.1, 0.2, 0.3), (0.02, 0.03, 0.04), 64), 4 / 3 * np.pi * 0.02 * 0.03 * 0.04),
    "upright": (facing(prism(rounded_rectangle(0.1, 0.06, 0.001), 0.03, 1e-5), 0.1, 0.2), 0.00018),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_shapes_are_closed_and_wound_outwards(name: str) -> None:
    mesh, expected = SOLIDS[name]
    assert_sound(mesh)
    assert volume(mesh) == pytest.approx(expected, rel=0.03)
    np.testing.assert_allclose(winding(mesh).sum(axis=0), 0.0, atol=1e-9)


def test_facing_turns_the_top_to_the_front() -> None:
    front = facing(cap(rounded_rectangle(0.1, 0.06, 0.01)), -0.2, 0.5)
    np.testing.assert_allclose(front.normals, np.tile([0.0, -1.0, 0.0], (len(front.normals), 1)), atol=1e-12)
    np.testing.assert_allclose(bounds([front]), [[-0.05, -0.2, 0.47], [0.05, -0.2, 0.53]], atol=1e-12)
    # Seen from the front the print is upright and not mirrored.
    np.testing.assert_allclose(front.uvs[:, 0], (front.vertices[:, 0] + 0.05) / 0.1, atol=1e-9)
    np.testing.assert_allclose(front.uvs[:, 1], (front.vertices[:, 2] - 0.47) / 0.06, atol=1e-9)


@pytest.mark.parametrize("outline", [rounded_rectangle(0.2, 0.1, 0.3), closed_curve([(0, 0), (1, 0), (0, 1)])])
def test_outlines_run_counter_clockwise_without_doubled_points(outline: np.ndarray) -> None:
    following = np.roll(outline, -1, axis=0)
    assert (outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]).sum() > 0
    assert np.linalg.norm(following - outline, axis=1).min() > 1e-6


def test_mirrored_completes_an_outline() -> None:
    np.testing.assert_allclose(mirrored([(0, 0), (1, 0), (0, 2)]), [(0, 0), (1, 0), (0, 2), (-1, 0)])


def test_every_key_gets_its_cell() -> None:
    keys = keypad(3, 2, (0.02, 0.03), 0.5, 0.002, round_=False)
    cells = {tuple(cell) for cell in np.floor(keys.uvs * [3, 2]).astype(int)}
    assert cells == {(x, y) for x in range(3) for y in range(2)}


def test_two_colours_are_two() -> None:
    rng = np.random.default_rng(0)
    assert all(len(set(two_colours(rng))) == 2 for _ in range(50))


PRINTS = {
    **{
        f"pattern {kind}": prints_patterns.pattern(kind, "#efe6d2", "#2f5fa8", "#e0682a")
        for kind in prints_patterns.PATTERNS
    },
    "cane": prints_patterns.cane("#6a4526", "#c9a06a", "#a03020"),
    "football": prints_patterns.football("#222222"),
    "map": prints_patterns.world_map("#3f8fc8", "#c9b87a", "#7fb0d0"),
    "phone": prints_devices.phone_screen(3),
    "laptop": prints_devices.laptop_screen(1),
    "dial": prints_devices.dial("roman", "#f4f0e0", "#202020"),
    "keys": prints_devices.key_grid((("1", "2"),), (("#202020", "#c03020"),), "#ffffff"),
    "spine": prints_paper.spine("THE SEA", "#204060", "#f0e0b0"),
    "portrait": prints_paper.portrait(2, 3),
}


@pytest.mark.parametrize("name", PRINTS)
def test_prints_are_linear_rgb_with_something_on_them(name: str) -> None:
    image = PRINTS[name]
    assert image.dtype == np.float32
    assert image.shape[2:] == (3,)
    assert image.min() >= 0.0
    assert image.max() <= 1.0
    assert image.std(axis=(0, 1)).max() > 0.05
    assert not image.flags.writeable


@pytest.mark.parametrize("kind", prints_patterns.PATTERNS)
@pytest.mark.parametrize("axis", [0, 1])
def test_patterns_tile(kind: str, axis: int) -> None:
    image = prints_patterns.pattern(kind, "#efe6d2", "#2f5fa8", "#e0682a")
    steps = np.abs(np.diff(image, axis=axis, append=np.take(image, [0], axis=axis))).mean(axis=(1 - axis, 2))
    assert steps[-1] <= steps[:-1].max() * 1.05 + 1e-4
