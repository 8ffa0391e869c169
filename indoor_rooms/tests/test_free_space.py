"""Where a robot can stand: distances against brute force, islands, and what cannot be had."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from box_room import DEPTH, TABLE, box_room
from indoor_rooms.free_space import FreeSpaceError, clearance, free_positions


def outline_points(polygon: np.ndarray, count: int = 200) -> np.ndarray:
    share = np.linspace(0, 1, count)[:, None, None]
    return (polygon + share * (np.roll(polygon, -1, axis=0) - polygon)).reshape(-1, 2)


def test_clearance_equals_brute_force() -> None:
    rng = np.random.default_rng(0)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 7))
    polygon = np.stack([np.cos(angles), np.sin(angles)], 1) * rng.uniform(0.3, 1.0, (7, 1))
    starts, ends = rng.uniform(-2, 2, (2, 40, 2))
    outline = outline_points(polygon, 60)
    along = starts[:, None] + np.linspace(0, 1, 60)[None, :, None] * (ends - starts)[:, None]
    brute = np.linalg.norm(along[:, :, None] - outline[None, None], axis=-1).min(axis=(1, 2))
    exact = clearance(starts, ends, [polygon])
    outside = exact > 0
    np.testing.assert_allclose(exact[outside], brute[outside], atol=0.04)
    assert 5 < outside.sum() < 38
    assert clearance(np.zeros((1, 2)), np.zeros((1, 2)), [TABLE - TABLE.mean(0)])[0] == 0


@pytest.mark.parametrize("reach", [0.0, 0.2, 0.5])
def test_what_is_out_of_reach_is_only_left_out(reach: float) -> None:
    """Together, and with what is far away left out, polygons are as near as one by one, to the last bit."""
    rng = np.random.default_rng(1)
    polygons = [TABLE, *(TABLE[::-1] * rng.uniform(0.1, 0.5) + rng.uniform(-3, 3, 2) for _ in range(6))]
    starts = np.concatenate([rng.uniform(-3, 3, (200, 2)), TABLE])
    for ends in (starts, starts + rng.normal(0, 0.4, starts.shape)):
        nearest = np.min([clearance(starts, ends, [polygon]) for polygon in polygons], axis=0)
        np.testing.assert_array_equal(clearance(starts, ends, polygons), nearest)
        within = clearance(starts, ends, polygons, reach)
        np.testing.assert_array_equal(within < reach, nearest < reach)
        np.testing.assert_array_equal(within[nearest <= reach], nearest[nearest <= reach])
        assert (within >= nearest).all()
        assert (nearest > reach).any()
    assert np.isinf(clearance(starts, starts, [])).all()
    assert clearance(starts[:0], starts[:0], polygons).shape == (0,)


def test_a_notch_is_free_and_a_way_across_a_polygon_is_not() -> None:
    notched = np.array([[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]], float)
    points = np.array([[1.5, 2.0], [0.5, 2.0], [-1.0, 1.0], [3.0, 3.0]])
    np.testing.assert_allclose(clearance(points, points, [notched]), [0.5, 0.0, 1.0, 0.0], atol=1e-12)
    across = clearance(np.array([[-1.0, 2.0], [1.5, 1.5]]), np.array([[4.0, 2.0], [1.5, 4.0]]), [notched])
    np.testing.assert_allclose(across, [0.0, 0.5], atol=1e-12)


def test_only_the_largest_part_of_a_divided_room_is_kept() -> None:
    fence = np.array([[1.2, 0.0], [1.25, 0.0], [1.25, DEPTH], [1.2, DEPTH]])
    positions = free_positions(replace(box_room(), obstacles=(("fence", fence),)), 0.35, 0.2)
    assert (positions[:, 0] > 1.25).all()


@pytest.mark.parametrize(("spacing", "radius", "message"), [(0.35, 3.0, "smaller radius"), (0.0, 0.2, "positive")])
def test_no_free_position_is_an_error(spacing: float, radius: float, message: str) -> None:
    with pytest.raises(FreeSpaceError, match=message):
        free_positions(box_room(), spacing, radius)


def test_too_many_places_are_an_error_that_says_how_many_there_are() -> None:
    there = len(free_positions(box_room(), 0.5, 0.2))
    with pytest.raises(FreeSpaceError, match=f"has {there} positions"):
        free_positions(box_room(), 0.5, 0.2, there + 1)
    assert len(free_positions(box_room(), 0.5, 0.2, there)) == there
