"""The order in which a robot looks from many poses: ways between neighbours, what is blocked, how much it turns."""

import itertools

import networkx
import numpy as np
import pytest

from active_perceiver.capture.tour import PlacesError, Tour, grid_poses, neighbours, seen_from

GRID = grid_poses(3, 3, 0.5, 4, (-30.0, 0.0))


def turned(order, poses, heading):
    """Degrees turned from a heading on, as the robot turns: the shorter way round; counted clockwise, and in all."""
    turns = (np.diff([heading, *poses[order, 2]]) + 180) % 360 - 180
    return turns.sum(), np.abs(turns).sum()


@pytest.mark.parametrize("seed", range(3))
def test_neighbours_have_nobody_between_them_and_reach_everybody(seed):
    places = np.random.default_rng(seed).uniform(0, 5, (14, 2))
    lengths = neighbours(places)
    for one, other in itertools.combinations(range(len(places)), 2):
        middle, apart = (places[one] + places[other]) / 2, np.linalg.norm(places[one] - places[other])
        between = [
            third
            for third in range(len(places))
            if third not in (one, other) and np.linalg.norm(places[third] - middle) <= apart / 2
        ]
        assert lengths[one, other] == pytest.approx(0 if between else apart)
        assert lengths[one, other] == lengths[other, one]
    assert networkx.is_connected(networkx.from_numpy_array(lengths))


def test_on_a_grid_the_ways_lead_along_it():
    tour = Tour(GRID)
    assert tour.places.tolist() == [[x / 2, z / 2] for x in range(3) for z in range(3)]
    assert tour.place_of.tolist() == [number // 8 for number in range(72)]
    assert tour.way(0, {0, 4}) == []
    assert tour.way(0, {4, 7}) in ([1, 4], [3, 4])
    assert tour.way(0, set()) is None


def test_it_goes_round_what_is_blocked_and_gives_up_what_it_cannot_reach():
    tour = Tour(GRID)
    tour.blocked(0, 1)
    assert tour.way(0, {1}) == [3, 4, 1]
    tour.blocked(4, 1)
    assert tour.given_up == {1}
    assert tour.way(0, {1}) is None
    assert tour.way(0, {1, 2}) == [3, 4, 5, 2]
    tour.blocked(0, 3)
    assert tour.way(0, {2, 8}) is None


def test_no_way_is_longer_than_a_room():
    tour = Tour(np.array([[0.0, 0, 0, 0], [9, 0, 0, 0], [18, 0, 0, 0], [28.5, 0, 0, 0]]))
    assert tour.way(0, {2}) == [1, 2]
    assert tour.way(0, {3}) is None


def test_a_place_that_was_reached_is_not_given_up():
    tour = Tour(GRID)
    tour.reached(1)
    for other in (0, 4):
        tour.blocked(other, 1)
    assert tour.way(2, {1}) == [1]


def test_places_are_in_the_order_of_the_table():
    tour = Tour(np.array([[1.0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 90, 0], [0, 0.5, 0, 0]]))
    assert tour.places.tolist() == [[1, 0], [0, 0], [0, 0.5]]
    assert tour.place_of.tolist() == [0, 1, 0, 2]


@pytest.mark.parametrize("heading", [0.0, 90.0, 135.0, -450.0, 770.0])
def test_at_a_place_it_turns_as_little_as_it_can(heading):
    order = Tour(GRID).views(list(range(8, 16)), heading, -30.0)
    assert sorted(order) == list(range(8, 16))
    first_of_each = order[::2]
    assert [GRID[number, 2] for number in first_of_each] == [GRID[number, 2] for number in order[1::2]]
    # From one heading to the next the tilt stays.
    assert GRID[order, 3].tolist() == [-30, 0, 0, -30, -30, 0, 0, -30]
    least = min(turned(list(other), GRID, heading)[1] for other in itertools.permutations(first_of_each))
    assert turned(first_of_each, GRID, heading)[1] == least


def test_turns_undo_each_other():
    tour, heading, most = Tour(GRID), 0.0, 0.0
    for place in range(9):
        heading += turned(tour.views(list(range(8 * place, 8 * place + 8)), heading, 0.0), GRID, heading)[0]
        most = max(most, abs(heading))
    assert most <= 270


def test_poses_as_they_are_seen_from_one():
    poses = np.array([[1.0, 2, 90, -30], [2, 2, 90, 0], [1, 1, 180, 0]])
    np.testing.assert_allclose(seen_from(poses, 0), [[0, 0, 0, -30], [0, 1, 0, 0], [1, 0, 90, 0]], atol=1e-12)
    np.testing.assert_allclose(seen_from(poses, 1)[0], [0, -1, 0, -30], atol=1e-12)
    rng = np.random.default_rng(0)
    many = rng.uniform(-5, 5, (9, 4))
    for first in (0, 4):
        seen = seen_from(many, first)
        assert seen[first, :3] == pytest.approx(0)
        np.testing.assert_allclose(
            np.linalg.norm(seen[:, :2], axis=1), np.linalg.norm(many[:, :2] - many[first, :2], axis=1)
        )


@pytest.mark.parametrize(
    ("grid", "said"),
    [
        ((0, 3, 0.5, 4, (0.0,)), "across must be"),
        ((3, 101, 0.5, 4, (0.0,)), "along must be"),
        ((3, 3, float("nan"), 4, (0.0,)), "step must be"),
        ((3, 3, 0.5, 0, (0.0,)), "headings must be"),
        ((3, 3, 0.5, 4, ()), "tilts must be"),
        ((3, 3, 0.5, 4, (0.0, 0.0)), "tilts must be"),
        ((3, 3, 0.5, 4, (float("nan"),)), "tilts must be"),
    ],
)
def test_a_grid_that_is_none_is_refused(grid, said):
    with pytest.raises(PlacesError, match=said):
        grid_poses(*grid)
