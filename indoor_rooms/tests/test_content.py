"""What rooms are made of: primitives, textures, objects, furniture."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from indoor_rooms.furniture import appliances, cabinets, fixtures, seating
from indoor_rooms.geometry.boxes import box, rounded_box, slab
from indoor_rooms.geometry.curves import arc, cylinder, disc, lathe, leaf, smooth_profile, sphere, tube
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform, without_sides
from indoor_rooms.geometry.pieces import Pieces, bounds
from indoor_rooms.materials import prints, textures
from indoor_rooms.materials.material import from_hex
from indoor_rooms.materials.surfaces import beech
from indoor_rooms.objects import OBJECTS, decor


def assert_sound(mesh: Mesh) -> None:
    """Finite, unit normals, and every triangle wound so that its normal agrees with its vertices'."""
    assert np.isfinite(mesh.vertices).all()
    assert np.isfinite(mesh.uvs).all()
    assert mesh.faces.min() >= 0
    assert mesh.faces.max() < len(mesh.vertices)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    winding = np.cross(b - a, c - a)
    agreement = (winding * mesh.normals[mesh.faces].mean(axis=1)).sum(axis=1)
    large = np.linalg.norm(winding, axis=1) > 2e-9
    assert (agreement[large] > 0).all(), (
        f"{int((agreement[large] <= 0).sum())} of {len(large)} triangles face inwards"
    )


def volume(mesh: Mesh) -> float:
    """Signed volume of a closed mesh, positive if it is wound outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


PRIMITIVES: dict[str, tuple[Mesh, float | None]] = {
    "rounded box": (rounded_box((0.3, 0.2, 0.1), 0.02, 3), None),
    "box": (box((0, 0, 0), (0.3, 0.2, 0.1)), 0.006),
    "slab with a hole": (slab((0, 1, 2, 3), (0, 1, 2, 3), [[1, 1, 1], [1, 0, 1], [1, 1, 1]], 0, 0.5), 4.0),
    "cylinder": (cylinder(0.1, 0.2, 96, 0.0), np.pi * 0.002),
    "sphere": (sphere(0.1, 96), 4 / 3 * np.pi * 0.001),
    "bevelled cylinder": (cylinder(0.1, 0.2, 96), np.pi * 0.002),
    "lathe with an edge": (lathe([(0, 0), (0.1, 0), (0.1, 0), (0.1, 0.2), (0.1, 0.2), (0, 0.2)], 96), np.pi * 0.002),
    "straight tube": (tube([[0, 0, 0], [0, 0, 0.1], [0, 0, 0.2]], 0.1, 96), np.pi * 0.002),
    "bent tube": (tube(arc((0, 0, 0), 0.2, 0, 180, 48), 0.02, 48), np.pi**2 * 0.2 * 0.0004),
    "disc": (disc(0.1), None),
    "leaf": (leaf(0.2, 0.04, 0.6), None),
    "quad": (quad((0, 0, 0), (1, 0, 0), (0, 0, 1), 2.0), None),
}


@pytest.mark.parametrize("name", PRIMITIVES)
def test_primitives_are_wound_outwards(name: str) -> None:
    mesh, expected = PRIMITIVES[name]
    assert_sound(mesh)
    if expected is not None:
        assert volume(mesh) == pytest.approx(expected, rel=0.01)


def test_transform_moves_turns_and_scales() -> None:
    mesh = transform(box((0, 0, 0), (1, 2, 3)), (10.0, 0.0, 0.0), (0.0, 0.0, 90.0), (1.0, 2.0, 1.0))
    np.testing.assert_allclose(bounds([mesh]), [[6.0, 0.0, 0.0], [10.0, 1.0, 3.0]], atol=1e-12)
    assert_sound(mesh)
    assert volume(mesh) == pytest.approx(12.0)


def test_merge_and_without_sides() -> None:
    both = merge([box((0, 0, 0), (1, 1, 1)), box((2, 0, 0), (3, 1, 1))])
    assert len(both.faces) == 24
    open_box = without_sides(both, "+z", "-x")
    assert len(open_box.faces) == 16
    assert_sound(open_box)


def test_smooth_profile_keeps_its_ends() -> None:
    line = smooth_profile([(0, 0), (1, 0), (1, 1)], 3)
    np.testing.assert_allclose(line[[0, -1]], [[0, 0], [1, 1]])
    assert np.linalg.norm(line - [1, 0], axis=1).min() > 0.1


TILEABLE: dict[str, Callable[[int], textures.Texture]] = {
    "wood": lambda seed: textures.wood("#a9784a", "#d2a670", seed, 128),
    "planks": lambda seed: textures.planks("#a9784a", "#d2a670", seed, 8, 256),
    "tiles": lambda seed: textures.tiles("#f0f0ee", "#c0c0bc", seed, size=128),
    "marble": lambda seed: textures.marble(seed=seed, size=128),
    "granite": lambda seed: textures.granite(seed=seed, size=128),
    "plaster": lambda seed: textures.plaster("#f0ece0", seed),
    "linen": lambda seed: textures.linen("#8090a0", seed),
    "gingham": lambda seed: textures.gingham("#a03030", seed=seed),
    "brushed metal": lambda seed: textures.brushed_metal(seed=seed),
}
SINGLE: dict[str, Callable[[int], textures.Texture]] = {
    "rug": lambda seed: textures.rug("#e0d8c8", "#305070", "#c07040", seed),
    "bread": lambda seed: textures.bread_crust(seed, 128),
    "apple": lambda seed: textures.apple_skin("#a01820", "#e0a040", seed, 128),
    "citrus": lambda seed: textures.citrus_peel("#f08020", seed=seed, size=128),
    "banana": lambda seed: textures.banana_skin(seed=seed, size=128),
    "cereal": lambda seed: prints.cereal_box("CRUNCH", "#c03020", "#e06030", seed),
    "label": lambda seed: prints.wrap_label("SOUP", "#c03020", "#f0c040", "#fff0e0", seed),
    "book": lambda seed: prints.book_cover("BREAD", "#206060", "#f0c040", seed),
    "painting": lambda seed: prints.painting(seed, 128),
    "outside": lambda seed: prints.outside_view(seed, 128),
}


@pytest.mark.parametrize("name", [*TILEABLE, *SINGLE])
def test_textures_are_linear_rgb_and_follow_their_seed(name: str) -> None:
    make = {**TILEABLE, **SINGLE}[name]
    image = make(3)
    assert image.ndim == 3
    assert image.shape[2] == 3
    assert image.dtype == np.float32
    assert image.min() >= 0.0
    assert image.max() <= 1.0
    textures_before = image.copy()
    for module in (textures, prints):
        for function in vars(module).values():
            if hasattr(function, "cache_clear"):
                function.cache_clear()
    np.testing.assert_array_equal(make(3), textures_before)
    assert make(3) is make(3)
    assert not np.array_equal(make(3), make(4))


@pytest.mark.parametrize("name", TILEABLE)
@pytest.mark.parametrize("axis", [0, 1])
def test_tileable_textures_have_no_seam(name: str, axis: int) -> None:
    image = TILEABLE[name](3)
    steps = np.abs(np.diff(image, axis=axis, append=np.take(image, [0], axis=axis))).mean(axis=(1 - axis, 2))
    assert steps[-1] <= steps[:-1].max() * 1.3 + 1e-4


def test_hex_colours_become_linear() -> None:
    assert from_hex("#ffffff") == pytest.approx((1.0, 1.0, 1.0))
    assert from_hex("#808080")[0] == pytest.approx(0.2159, abs=1e-3)


@pytest.mark.parametrize("category", OBJECTS)
def test_objects_stand_on_the_ground_and_vary(category: str) -> None:
    pieces = OBJECTS[category](np.random.default_rng(1))
    for mesh, _ in pieces:
        assert_sound(mesh)
    box_of = bounds(mesh for mesh, _ in pieces)
    assert abs(box_of[0, 2]) < 1e-3
    assert 0.015 < np.ptp(box_of, axis=0).max() < 0.6
    again = OBJECTS[category](np.random.default_rng(1))
    other = OBJECTS[category](np.random.default_rng(2))
    for (mesh, material), (same, same_material) in zip(pieces, again, strict=True):
        np.testing.assert_array_equal(mesh.vertices, same.vertices)
        assert material.colour == same_material.colour
        assert material.texture is same_material.texture
    assert not all(
        mesh.vertices.shape == changed.vertices.shape and np.array_equal(mesh.vertices, changed.vertices)
        for (mesh, _), (changed, _) in zip(pieces, other, strict=True)
    )


WOOD = beech()
OPENING = (-0.5, 0.5, 1.0, 2.0)
STANDING: dict[str, Pieces] = {
    "base cabinet": cabinets.base_cabinet(0.5, WOOD, 1),
    "sideboard": cabinets.sideboard(1.2, WOOD, WOOD),
    "faucet": cabinets.faucet(),
    "stove": appliances.stove(),
    "fridge": appliances.fridge("#c3dcd6"),
    "microwave": appliances.microwave(),
    "table": seating.table(1.3, 0.8, WOOD, WOOD),
    "chair": seating.chair(WOOD),
    "rug": seating.rug(2.0, 1.4, "#e0d8c8", "#305070", "#c07040"),
    "wall": [(fixtures.wall(4.0, 2.6, OPENING), WOOD)],
    "door": fixtures.door(WOOD),
    "bin": fixtures.bin_with_pedal(),
    "floor plant": decor.floor_plant(np.random.default_rng(1)),
    "baseboard": fixtures.baseboard(2.0),
    "wall cabinet": cabinets.wall_cabinet(0.6, WOOD, doors=2),
}
HANGING: dict[str, Pieces] = {
    "countertop": cabinets.countertop((0, 1), (0, 0.6), [[True]], WOOD),
    "sink": cabinets.sink(0.5, 0.4),
    "shelf": cabinets.shelf(1.0, WOOD),
    "hood": appliances.hood(),
    "window": fixtures.window(OPENING),
    "backdrop": fixtures.backdrop(6.0, 2.0, (1.0, 1.0, 1.0)),
    "ceiling lamp": [piece for half in fixtures.ceiling_lamp(0.5, (1, 1, 1)) for piece in half],
    "pendant lamp": [piece for half in fixtures.pendant_lamp(0.9, WOOD, (1, 1, 1)) for piece in half],
    "picture": fixtures.picture(0.9, 0.6, WOOD),
    "clock": fixtures.clock(),
}


@pytest.mark.parametrize("name", [*STANDING, *HANGING])
def test_furniture_is_sound(name: str) -> None:
    pieces = {**STANDING, **HANGING}[name]
    for mesh, _ in pieces:
        assert_sound(mesh)
    if name in STANDING:
        assert abs(bounds(mesh for mesh, _ in pieces)[0, 2]) < 1e-3


@pytest.mark.parametrize("category", ["apple", "banana", "bread", "green_apple", "lemon", "orange"])
def test_food_is_wound_outwards(category):
    mesh = OBJECTS[category](np.random.default_rng(1))[0][0]
    centred = transform(mesh, tuple(-mesh.vertices.mean(axis=0)))
    assert volume(centred) > 0
