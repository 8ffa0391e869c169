"""The renderer against geometry and light worked out by hand."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
import pytest

from box_room import BOX, DEPTH, HEIGHT, WIDTH, box_room, make_room, solid, walls
from indoor_rooms.geometry.mesh import quad
from indoor_rooms.materials.material import Material
from indoor_rooms.renderer import camera, compiled, vectors
from indoor_rooms.renderer.camera import NOTHING, Quality, camera_axes, render
from indoor_rooms.renderer.compiled import compile_room
from indoor_rooms.renderer.direct_light import Lights, LightSample
from indoor_rooms.renderer.lighting import BakedRoom, bake
from indoor_rooms.renderer.raycast import RayCaster, RoomsExtraError, open_image_denoise
from indoor_rooms.renderer.sunlight import SUN_RADIUS, SunShafts
from indoor_rooms.renderer.tessellation import tessellate
from indoor_rooms.renderer.texture_lookup import TextureAtlas
from indoor_rooms.renderer.tone import tone_map
from indoor_rooms.room import Lamp, Part, Sun

CAMERA = (1.0, 1.5, 1.2)


@pytest.fixture(scope="module", autouse=True)
def coarse_mesh() -> Iterator[None]:
    """A few thousand triangles: enough for these rooms, and quickly baked."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "MAX_TRIANGLES", 4000)
        yield


@pytest.fixture(scope="module")
def baked() -> BakedRoom:
    return bake(box_room(), rays=16, bounces=2)


def vertices_of(baked: BakedRoom, name: str) -> np.ndarray:
    surfaces = baked.surfaces
    parts = surfaces.parts.object_index[surfaces.part_of_face] == surfaces.object_names.index(name)
    return np.unique(surfaces.faces[parts])


# Rays


def test_ray_hits_a_triangle_where_geometry_says() -> None:
    caster = RayCaster(np.array([[[0, 0, 0], [2, 0, 0], [0, 2, 0]]], np.float32))
    origins = np.array([[0.5, 0.25, 3], [1.5, 1.5, 3], [0.5, 0.25, -1]], np.float32)
    directions = np.array([[0, 0, -1], [0, 0, -1], [0, 0, 1]], np.float32)
    hits = caster.hits(origins, directions)
    assert hits.triangle.tolist() == [0, -1, 0]
    np.testing.assert_allclose(hits.distance[[0, 2]], [3, 1], atol=1e-6)
    np.testing.assert_allclose([hits.u[0], hits.v[0]], [0.25, 0.125], atol=1e-6)
    assert caster.occluded(origins, directions).tolist() == [True, False, True]
    assert caster.occluded(origins, directions, np.full(3, 2.0, np.float32)).tolist() == [False, False, True]
    assert len(caster.hits(origins[:0], directions[:0]).triangle) == 0


def test_random_rays_in_a_box_hit_the_wall_slabs_say() -> None:
    surfaces = compile_room(make_room(walls()))
    rng = np.random.default_rng(0)
    size = np.array([WIDTH, DEPTH, HEIGHT])
    origins = rng.uniform(0.1, 0.9, (500, 3)) * size
    directions = rng.standard_normal((500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    expected = np.where(directions > 0, (size - origins) / directions, -origins / directions).min(axis=1)
    hits = surfaces.caster.hits(origins.astype(np.float32), directions.astype(np.float32))
    np.testing.assert_allclose(hits.distance, expected, rtol=1e-4)
    points = surfaces.interpolate(surfaces.positions, hits)
    np.testing.assert_allclose(points, origins + directions * expected[:, None], atol=1e-3)


def test_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "embreex.mesh_construction", None)
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    with pytest.raises(RoomsExtraError, match=r"pip install 'active-perceiver\[rooms\]'"):
        RayCaster(np.zeros((1, 3, 3), np.float32))
    with pytest.raises(RoomsExtraError, match="'rooms' extra"):
        open_image_denoise()


def test_tessellation_keeps_area_and_shares_vertices() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    vertices, faces, source = tessellate(square, np.array([[0, 1, 2], [0, 2, 3]]), np.array([0.2, 0.2]))
    sides = vertices[faces] - np.roll(vertices[faces], -1, axis=1)
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    assert np.linalg.norm(sides, axis=2).max() <= 0.2
    np.testing.assert_allclose(np.bincount(source, areas), [0.5, 0.5])
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    # Euler's formula of a disc: no cracks, no doubled vertices.
    assert len(vertices) - len(uses) + len(faces) == 1


def test_texture_lookup_filters_wraps_and_averages() -> None:
    texture = np.zeros((8, 8, 3), np.float32)
    texture[0, :, 0] = 1.0  # row 0 is the top, v = 1
    atlas = TextureAtlas([texture, np.full((4, 4, 3), 0.5, np.float32)])
    uv = np.array([[0.5, 1 - 1 / 16], [3.5, -1 / 16], [0.5, 0.5], [0.5, 1 - 1 / 8], [0.2, 0.9]], np.float32)
    index = np.array([0, 0, 0, 0, 1])
    colour = atlas.sample(index, uv, np.zeros(5, np.float32))
    np.testing.assert_allclose(colour[:, 0], [1, 1, 0, 0.5, 0.5], atol=1e-3)
    # What a whole number of tiles away is the same texel, at the very edges too.
    edges = np.array([[-1e-9, 0.9], [0.0, 0.9], [1.0, 0.9], [5.0, -0.1]], np.float32)
    colours = atlas.sample(np.zeros(4, np.int64), edges, np.zeros(4, np.float32))
    np.testing.assert_allclose(colours, np.tile(colours[:1], (4, 1)), atol=1e-3)
    whole = atlas.sample(index[:1], np.array([[0.5, 1 - 1 / 8]], np.float32), np.array([0.25], np.float32))
    np.testing.assert_allclose(whole[0, 0], 0.5, atol=1e-3)


def test_vector_columns_agree_with_plain_arithmetic() -> None:
    rng = np.random.default_rng(0)
    first, second = rng.standard_normal((2, 50, 3)).astype(np.float32)
    index = rng.integers(0, 50, 20)
    np.testing.assert_array_equal(vectors.rows(first, index), first[index])
    np.testing.assert_array_equal(vectors.columns(*first.T), first)
    np.testing.assert_allclose(vectors.dot(first, second), (first * second).sum(axis=1), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(vectors.dot(first, second[:1]), first @ second[0], rtol=1e-5, atol=1e-6)
    normals = vectors.unit(first)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=1e-6)
    share, turn = rng.random((2, 50)).astype(np.float32)
    directions = vectors.cosine_directions(normals, share, turn)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, rtol=1e-5)
    np.testing.assert_allclose(vectors.dot(directions, normals) ** 2, 1 - share, atol=1e-5)


def test_uv_gradients_continue_the_texture_of_a_triangle() -> None:
    surfaces = compile_room(make_room((Part("floor", quad((0, 0, 0), (2, 0.5, 0), (0, 1, 1)), Material()),)))
    corners, uvs = surfaces.positions[surfaces.faces], surfaces.uvs[surfaces.faces]
    for corner in range(1, 3):
        step = corners[:, corner] - corners[:, 0]
        for axis in range(2):
            grown = (surfaces.uv_gradients[:, 3 * axis : 3 * axis + 3] * step).sum(axis=1)
            np.testing.assert_allclose(grown, uvs[:, corner, axis] - uvs[:, 0, axis], atol=1e-4)


# Light


def test_a_chosen_lamp_stands_for_all_of_them() -> None:
    table = Part("table", solid((0.5, 0.5, 0.7), (1.5, 1.5, 0.75)), Material())
    edges = ((0.0, 0.6, 0.0), (0.6, 0.0, 0.0))
    lamps = (
        Lamp("panel", (1.0, 1.0, 2.4), edges, 0.0, (5.0, 5.0, 4.0)),
        Lamp("bulb", (3.0, 2.0, 1.5), None, 0.05, (60.0, 30.0, 20.0)),
        Lamp("far", (3.5, 0.5, 2.0), None, 0.1, (10.0, 20.0, 30.0)),
    )
    room = make_room((*walls(), table), lamps=lamps)
    lights = Lights(room, compile_room(room))
    # In full light, in half shadow and under the table; the visibility given is a guess, and a wrong one.
    places = np.array([[3.0, 1.5, 0.0], [1.6, 1.2, 0.0], [1.0, 1.0, 0.0]], np.float32)
    visible = np.array([[1.0, 0.0, 0.5], [0.0, 0.3, 1.0], [1.0, 0.2, 0.0]], np.float32)
    count = 40_000
    points, guesses = np.repeat(places, count, axis=0), np.repeat(visible, count, axis=0)
    normals = np.tile(np.array([[0, 0, 1]], np.float32), (len(points), 1))
    rng = np.random.default_rng(1)

    def mean(*samples: LightSample) -> np.ndarray:
        total = np.zeros((len(points), 3))
        for sample in samples:
            total[sample.index] += sample.irradiance
        return total.reshape(len(places), count, 3).mean(axis=1)

    every = mean(*(lights.lamplight(np.full(len(points), lamp), points, normals, rng) for lamp in range(3)))
    draws = rng.random(len(points), np.float32)
    lamp, weight = lights.choose_lamps(points, normals, guesses, draws)
    assert set(lamp[:count]) == {0, 1, 2}
    np.testing.assert_allclose(mean(lights.lamplight(lamp, points, normals, rng, weight)), every, rtol=0.05)


def test_sun_shafts_hold_every_point_the_sun_reaches() -> None:
    wall = [Part("wall", solid((0.0, 2.9, 0.0), (1.0, 3.0, 2.5)), Material())]
    wall += [Part("wall", solid((1.1, 2.9, 0.0), (4.0, 3.0, 2.5)), Material())]
    roof = Part("roof", solid((-0.5, 0.0, 2.5), (4.5, 3.0, 2.6)), Material())
    sun = Sun((0.3, -1.0, -0.7), (1.0, 1.0, 1.0), 5.0)
    surfaces = compile_room(make_room((*walls()[:1], *wall, roof), sun=sun))
    shafts = SunShafts(sun, surfaces)
    rng = np.random.default_rng(0)
    points = (rng.random((40_000, 3)) * [WIDTH, 2.8, 2.4]).astype(np.float32)
    towards = shafts.towards + SUN_RADIUS * rng.standard_normal(points.shape).astype(np.float32)
    lit = ~surfaces.shadow_caster.occluded(points, towards)
    may = shafts.may_reach(points)
    assert may[lit].mean() > 0.999
    assert 100 < lit.sum() < may.sum() < len(points) / 2


def test_open_floor_under_constant_sky_gets_pi_times_its_radiance() -> None:
    floor = Part("floor", quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), Material())
    lit = bake(make_room((floor,), sky=(1.0, 2.0, 3.0)), rays=8, bounces=1)
    np.testing.assert_allclose(lit.indirect, np.tile(np.pi * np.array([1, 2, 3]), (len(lit.indirect), 1)), rtol=1e-4)


def test_white_furnace_returns_what_it_gets() -> None:
    white = Material((1.0, 1.0, 1.0))
    parts = (
        Part("floor", quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), white),
        Part("box", solid((0.7, 0.7, 0.0), (1.3, 1.3, 0.6)), white),
    )
    lit = bake(make_room(parts, sky=(1.0, 1.0, 1.0)), rays=32, bounces=20)
    seen = np.concatenate([vertices_of(lit, "floor"), vertices_of(lit, "box")])
    assert np.median(lit.total[seen]) == pytest.approx(np.pi, rel=0.01)
    # Just under the box's edge, too: what lies inside a solid takes the light of what is around it.
    places = lit.surfaces.positions[seen]
    hidden = (np.abs(places[:, :2] - 1).max(axis=1) < 0.2) & (places[:, 2] < 0.01)
    assert lit.total[seen[~hidden]].min() > 0.9 * np.pi
    assert lit.total[seen].max() < 1.02 * np.pi


def test_no_light_leaks_into_a_closed_room() -> None:
    lit = bake(make_room(walls(), sky=(100.0, 100.0, 100.0)), rays=32, bounces=2)
    assert lit.total.max() < 1e-3


def test_sun_and_lamps_light_what_they_face() -> None:
    floor = Part("floor", quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), Material())
    shade = Part("shade", solid((0.0, 0.0, 0.5), (1.0, 2.0, 0.55)), Material())
    slanted = Sun((0.0, np.sin(np.radians(60)), -np.cos(np.radians(60))), (1.0, 0.5, 0.25), 4.0)
    lit = bake(make_room((floor,), sun=slanted), rays=4, bounces=1)
    np.testing.assert_allclose(lit.total.mean(axis=0), [2.0, 1.0, 0.5], rtol=0.03)
    overhead = bake(make_room((floor, shade), sun=Sun((0.0, 0.0, -1.0), (1.0, 1.0, 1.0), 2.0)), rays=4, bounces=0)
    vertices = vertices_of(overhead, "floor")
    places, light = overhead.surfaces.positions[vertices], (overhead.total - overhead.indirect)[vertices, 0]
    assert light[np.abs(places - [0.5, 1, 0]).max(axis=1) < 0.4].max() < 1e-3
    np.testing.assert_allclose(light[places[:, 0] > 1.1], 2.0, rtol=0.01)
    # A small lamp far away: radiance x area / distance squared, straight below it.
    for edges, radius, area in ((((0, 0.1, 0), (0.1, 0, 0)), 0.0, 0.01), (None, 0.05, np.pi * 0.05**2)):
        lamp = Lamp("lamp", (1.0, 1.0, 2.0), edges, radius, (10.0, 10.0, 10.0))
        lit = bake(make_room((floor,), lamps=(lamp,)), rays=4, bounces=0)
        below = np.linalg.norm(lit.surfaces.positions - [1, 1, 0], axis=1).argmin()
        assert lit.total[below, 0] == pytest.approx(10 * area / 4, rel=0.03)


# Pictures


def test_mask_is_the_projection_of_the_box(baked: BakedRoom) -> None:
    size, fov = 120, 60.0
    view = render(baked, CAMERA, heading=90, image_size=size, fov=fov, quality=Quality(denoise=False))
    mask = view.mask == baked.object_names.index("box")
    # Looking along +x: right is -y, and the near face of the box spans it.
    scale = size / 2 / np.tan(np.radians(fov / 2)) / (BOX[0][0] - CAMERA[0])
    left, right = (size / 2 + scale * (CAMERA[1] - y) for y in (BOX[1][1], BOX[0][1]))
    top, bottom = (size / 2 - scale * (z - CAMERA[2]) for z in (BOX[1][2], BOX[0][2]))
    rows, columns = np.nonzero(mask)
    expected = [left, right, top, bottom]
    found = [columns.min(), columns.max() + 1, rows.min(), rows.max() + 1]
    np.testing.assert_allclose(found, expected, atol=1.0)
    assert mask.sum() == pytest.approx((right - left) * (bottom - top), rel=0.05)
    np.testing.assert_allclose(view.depth[mask], BOX[0][0] - CAMERA[0], atol=1e-3)
    np.testing.assert_allclose(view.depth[25, size // 2], WIDTH - CAMERA[0], atol=1e-2)


def test_one_ray_suffices_where_there_is_no_edge(baked: BakedRoom, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = {"heading": 70, "tilt": -15, "image_size": 96, "quality": Quality(denoise=False)}
    fast = render(baked, CAMERA, **settings)
    monkeypatch.setattr(camera, "_edges", lambda first, lens: np.ones(len(first.part), bool))
    slow = render(baked, CAMERA, **settings)
    assert (fast.mask != slow.mask).mean() < 0.001
    # Noise of soft shadows differs; edges would by far more.
    assert np.abs(fast.image.astype(int) - slow.image).mean() < 4
    box = slow.mask == baked.object_names.index("box")
    assert fast.image[box].mean() == pytest.approx(slow.image[box].mean(), abs=2)


@pytest.mark.parametrize("samples", [1, 9])
def test_other_numbers_of_rays_show_the_same(baked: BakedRoom, samples: int) -> None:
    usual = render(baked, CAMERA, 90, 0, 48)
    other = render(baked, CAMERA, 90, 0, 48, quality=Quality(samples))
    assert (usual.mask != other.mask).mean() < 0.02
    assert other.image.mean() == pytest.approx(usual.image.mean(), abs=4)


def test_directions_of_heading_and_tilt(baked: BakedRoom) -> None:
    np.testing.assert_allclose(camera_axes(0, 0), [[1, 0, 0], [0, 0, 1], [0, 1, 0]], atol=1e-6)
    np.testing.assert_allclose(camera_axes(90, 0)[2], [1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(camera_axes(0, 30)[2], [0, np.sqrt(0.75), 0.5], atol=1e-6)
    middle = (16, 16)
    name = baked.object_names
    seen = {
        (heading, tilt): name[render(baked, CAMERA, heading, tilt, 32, quality=Quality(denoise=False)).mask[middle]]
        for heading, tilt in ((90, 0), (270, 0), (0, 89), (0, -89))
    }
    assert seen == {(90, 0): "box", (270, 0): "wall", (0, 89): "ceiling", (0, -89): "floor"}
    # Turning right moves things to the left.
    turned = render(baked, CAMERA, 105, 0, 32, quality=Quality(denoise=False)).mask == name.index("box")
    assert np.nonzero(turned)[1].mean() < 16


def test_a_view_follows_from_its_pose_alone(baked: BakedRoom) -> None:
    first = render(baked, CAMERA, 90, 0, 48)
    other = render(baked, CAMERA, 180, 0, 48)
    again = render(baked, CAMERA, 90, 0, 48)
    np.testing.assert_array_equal(first.image, again.image)
    assert (first.image != other.image).any()
    twin = bake(box_room(), rays=16, bounces=2)
    np.testing.assert_array_equal(render(twin, CAMERA, 90, 0, 48).image, first.image)


def test_picture_is_well_exposed_and_coloured(baked: BakedRoom) -> None:
    view = render(baked, CAMERA, 90, 0, 64)
    assert view.image.shape == (64, 64, 3)
    assert view.image.dtype == np.uint8
    assert 70 < view.image.mean() < 200
    red, green, _ = view.image[view.mask == baked.object_names.index("box")].mean(axis=0)
    assert red > 1.5 * green
    brighter = render(baked, CAMERA, 90, 0, 64, exposure=2.0)
    assert brighter.image.mean() > view.image.mean() + 10


def test_nothing_is_marked_as_nothing() -> None:
    floor = Part("floor", quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), Material())
    lit = bake(make_room((floor,), sky=(0.5, 0.5, 0.5)), rays=4, bounces=1)
    view = render(lit, (0.5, 0.5, 0.5), 0, 45, 16)
    assert (view.mask == NOTHING).all()
    assert np.isinf(view.depth).all()


def test_bad_camera_settings_are_refused(baked: BakedRoom) -> None:
    with pytest.raises(ValueError, match="square number"):
        render(baked, CAMERA, 0, quality=Quality(3))
    with pytest.raises(ValueError, match="field of view"):
        render(baked, CAMERA, 0, fov=180.0)
    with pytest.raises(ValueError, match="no parts"):
        bake(make_room(()))


def test_tone_curve_is_monotonic_from_black_to_white() -> None:
    ramp = np.geomspace(1e-4, 6, 200, dtype=np.float32)
    grey = tone_map(np.repeat(ramp[None, :, None], 3, axis=2))[0, :, 0].astype(int)
    assert (np.diff(grey) >= 0).all()
    assert grey[0] < 5
    assert grey[-1] > 250
