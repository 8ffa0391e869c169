"""What rooms are made of: primitives, textures, objects, furniture, and the kitchen they make up."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from active_perceiver.rooms import prints, textures
from active_perceiver.rooms.boxes import box, rounded_box, slab
from active_perceiver.rooms.curves import arc, cylinder, disc, lathe, leaf, smooth_profile, sphere, tube
from active_perceiver.rooms.furniture import appliances, cabinets, fixtures, seating
from active_perceiver.rooms.geometry import Mesh, merge, quad, transform, without_sides
from active_perceiver.rooms.layouts import LAYOUTS, make_room
from active_perceiver.rooms.materials import from_hex
from active_perceiver.rooms.objects import OBJECTS, decor
from active_perceiver.rooms.pieces import Pieces, bounds
from active_perceiver.rooms.room import Room
from active_perceiver.rooms.surfaces import beech

OF_RECORD = ("mug", "plate", "bread", "apple")
NAMED = (*OF_RECORD, "bowl", "bottle", "kettle", "toaster", "pot", "pan", "vase", "banana", "cereal", "milk", "can")
NAMED += ("soap", "book", "knife_block", "orange", "green_apple")


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
    assert 0.015 < np.ptp(box_of, axis=0).max() < 0.5
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
    "backdrop": fixtures.backdrop(0.0, 6.0, 2.0, 1.0),
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


@pytest.fixture(scope="module", params=[1, 2, 3, 4, 5, 6])
def room(request: pytest.FixtureRequest) -> Room:
    return make_room("kitchen", request.param)


def extents(room: Room) -> dict[str, np.ndarray]:
    meshes: dict[str, list[Mesh]] = {}
    for part in room.parts:
        meshes.setdefault(part.object_name, []).append(part.mesh)
    return {name: bounds(group) for name, group in meshes.items()}


def test_kitchen_has_its_targets(room: Room) -> None:
    names = {part.object_name for part in room.parts}
    assert set(NAMED) <= set(room.targets)
    assert set(room.targets) <= names
    assert all(room.targets[name] == name for name in NAMED)
    assert sum(len(part.mesh.faces) for part in room.parts) < 200_000
    for lamp in room.lamps:
        assert lamp.object_name in names


def test_things_do_not_intersect(room: Room) -> None:
    boxes = {name: box_of for name, box_of in extents(room).items() if name in OBJECTS}
    names = sorted(boxes)
    for index, first in enumerate(names):
        for second in names[index + 1 :]:
            low = np.maximum(boxes[first][0], boxes[second][0])
            high = np.minimum(boxes[first][1], boxes[second][1])
            # The pan's long handle slants past the kettle's and the pot's boxes, high above their burners.
            if {first, second} <= {"pan", "pot", "kettle"}:
                continue
            assert not (high - low > 1e-3).all(), f"{first} and {second} intersect"


def test_pots_do_not_intersect(room: Room) -> None:
    points = {
        name: np.concatenate([part.mesh.vertices for part in room.parts if part.object_name == name])
        for name in ("pot", "pan", "kettle")
    }
    for first, second in (("pot", "pan"), ("pot", "kettle"), ("pan", "kettle")):
        gap = min(np.linalg.norm(points[second] - point, axis=1).min() for point in points[first][::3])
        assert gap > 0.005, f"{first} and {second} are {gap:.3f} m apart"


def test_things_rest_on_a_surface(room: Room) -> None:
    """Straight below each thing's lowest points there is an upward face, at most 3 mm away."""
    supports = [part.mesh for part in room.parts if part.object_name not in OBJECTS]
    corners = np.concatenate([mesh.vertices[mesh.faces] for mesh in supports])
    upward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 1e-12
    corners = corners[upward]
    for name, box_of in extents(room).items():
        if name not in OBJECTS:
            continue
        vertices = np.concatenate([part.mesh.vertices for part in room.parts if part.object_name == name])
        low = vertices[vertices[:, 2] < box_of[0, 2] + 0.002].mean(axis=0)
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]

        def side(p: np.ndarray, q: np.ndarray, point: np.ndarray = low) -> np.ndarray:
            return (q[:, 0] - p[:, 0]) * (point[1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (point[0] - p[:, 0])

        inside = (side(a, b) >= -1e-9) & (side(b, c) >= -1e-9) & (side(c, a) >= -1e-9)
        drops = box_of[0, 2] - corners[inside].mean(axis=1)[:, 2]
        below = drops[drops > -1e-3]
        assert len(below), f"nothing is below {name}"
        assert 0.0002 < below.min() < 0.003, f"{name} is {below.min() * 1000:.1f} mm above what is below it"


def test_objects_of_record_are_apart(room: Room) -> None:
    centres = {name: extents(room)[name].mean(axis=0) for name in OF_RECORD}
    for index, first in enumerate(OF_RECORD):
        for second in OF_RECORD[index + 1 :]:
            assert np.linalg.norm(centres[first] - centres[second]) > 0.6


def distance_to(polygon: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance of points (N, 2) to a convex counter-clockwise polygon, 0 inside."""
    edge = np.roll(polygon, -1, axis=0) - polygon
    to_point = points[:, None] - polygon
    share = np.clip((to_point * edge).sum(-1) / (edge**2).sum(-1), 0, 1)
    gap = np.linalg.norm(to_point - share[..., None] * edge, axis=-1).min(axis=1)
    inside = (edge[:, 0] * to_point[..., 1] - edge[:, 1] * to_point[..., 0] >= 0).all(axis=1)
    return np.where(inside, 0.0, gap)


def test_robot_can_reach_everything(room: Room) -> None:
    from scipy.ndimage import label

    width, depth, _ = room.size
    for _, polygon in room.obstacles:
        assert polygon.ndim == 2
        assert (polygon >= -0.2).all()
        assert (polygon <= np.array([width, depth]) + 0.2).all()
    xs, ys = np.arange(0.2, width - 0.19, 0.35), np.arange(0.2, depth - 0.19, 0.35)
    grid = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
    free = np.all([distance_to(polygon, grid) >= 0.2 for _, polygon in room.obstacles], axis=0)
    pieces, count = label(free.reshape(len(xs), len(ys)))
    assert count >= 1
    largest = grid[pieces.ravel() == 1 + np.bincount(pieces.ravel())[1:].argmax()]
    assert len(largest) >= 50
    boxes = extents(room)
    for name in room.targets:
        centre = boxes[name].mean(axis=0)[:2]
        assert np.linalg.norm(largest - centre, axis=1).min() < 1.0, f"{name} cannot be approached"


def test_room_follows_its_seed() -> None:
    first, again, other = make_room("kitchen", 3), make_room("kitchen", 3), make_room("kitchen", 8)
    for part, same in zip(first.parts, again.parts, strict=True):
        assert part.object_name == same.object_name
        np.testing.assert_array_equal(part.mesh.vertices, same.mesh.vertices)
    assert first.sun != other.sun
    mug, moved = (extents(room)["mug"] for room in (first, other))
    assert not np.allclose(mug, moved)


def test_unknown_layouts_and_seeds_are_explained() -> None:
    assert "kitchen" in LAYOUTS
    with pytest.raises(ValueError, match=r"no room layout 'castle'; choose one of: kitchen"):
        make_room("castle", 1)
    with pytest.raises(ValueError, match="at least 1"):
        make_room("kitchen", 0)


@pytest.mark.parametrize("category", ["apple", "banana", "bread", "green_apple", "lemon", "orange"])
def test_food_is_wound_outwards(category):
    mesh = OBJECTS[category](np.random.default_rng(1))[0][0]
    centred = transform(mesh, tuple(-mesh.vertices.mean(axis=0)))
    assert volume(centred) > 0
