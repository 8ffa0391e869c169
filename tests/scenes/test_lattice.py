"""Transitions, islands, goal states and shortest paths, against slow ones and networkx."""

import itertools

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action
from active_perceiver.scenes.lattice import (
    UNREACHABLE,
    goal_states,
    islands,
    lattice_poses,
    lattice_transitions,
    nearest_tilt,
    shortest_path,
    steps_from,
    steps_to_goal,
)

HEADINGS, TILTS = (0, 90, 180, 270), (-30, 0, 30)


@st.composite
def lattices(draw, actions=EIGHT_ACTIONS):
    """Poses and transitions over a random set of grid cells, offset and spaced at random."""
    cells = draw(st.sets(st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=1, max_size=12))
    step = draw(st.sampled_from([0.25, 0.3, 0.35, 1.0]))
    offset = draw(st.floats(-3, 3))
    positions = np.array(sorted(cells)) * step + offset
    poses = lattice_poses(positions, HEADINGS, TILTS)
    return poses, lattice_transitions(poses, actions, step), step


def graph_of(transitions):
    graph = networkx.DiGraph()
    graph.add_nodes_from(range(len(transitions)))
    graph.add_edges_from((s, int(n)) for s, row in enumerate(transitions) for n in row if n != s)
    return graph


@settings(max_examples=40, deadline=None)
@given(lattices())
def test_each_action_does_what_its_name_says(lattice):
    poses, transitions, step = lattice
    ahead = {0: (0, 1), 90: (1, 0), 180: (0, -1), 270: (-1, 0)}
    turn = {Action.MOVE_AHEAD: 0, Action.MOVE_RIGHT: 90, Action.MOVE_BACK: 180, Action.MOVE_LEFT: 270}
    for state, (x, z, heading, tilt) in enumerate(poses.astype(float)):
        for column, action in enumerate(EIGHT_ACTIONS):
            if action in turn:
                dx, dz = ahead[int(heading + turn[action]) % 360]
                wanted = (x + dx * step, z + dz * step, heading, tilt)
            elif action in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
                wanted = (x, z, (heading + (90 if action == Action.ROTATE_RIGHT else -90)) % 360, tilt)
            else:
                wanted = (x, z, heading, tilt + (30 if action == Action.LOOK_UP else -30))
            reached = tuple(poses[transitions[state, column]].astype(float))
            if np.abs(poses - np.array(wanted)).max(axis=1).min() < 0.02:
                np.testing.assert_allclose(reached, wanted, atol=0.02)
            else:
                assert transitions[state, column] == state


@settings(max_examples=40, deadline=None)
@given(lattices(), st.data())
def test_steps_and_paths_agree_with_networkx(lattice, data):
    _, transitions, _ = lattice
    states = len(transitions)
    goals = np.zeros(states, bool)
    goals[data.draw(st.lists(st.integers(0, states - 1), min_size=1, max_size=5))] = True
    reverse = graph_of(transitions).reverse()
    expected = networkx.multi_source_dijkstra_path_length(reverse, set(np.flatnonzero(goals).tolist()))
    steps = steps_to_goal(transitions, goals)
    assert [expected.get(s, UNREACHABLE) for s in range(states)] == steps.tolist()
    start = data.draw(st.integers(0, states - 1))
    away = networkx.single_source_shortest_path_length(graph_of(transitions), start)
    assert [away.get(s, UNREACHABLE) for s in range(states)] == steps_from(transitions, start).tolist()
    path = shortest_path(transitions, goals, start)
    assert len(path) == steps[start] + 1
    if path:
        assert goals[path[-1]]
        assert all(b in transitions[a] for a, b in itertools.pairwise(path))


@settings(max_examples=30, deadline=None)
@given(lattices())
def test_islands_are_the_strong_components_largest_first(lattice):
    _, transitions, _ = lattice
    labels = islands(transitions)
    components = list(networkx.strongly_connected_components(graph_of(transitions)))
    assert len(components) == labels.max() + 1
    assert all(len(set(labels[list(part)])) == 1 for part in components)
    sizes = np.bincount(labels)
    assert (np.diff(sizes) <= 0).all()


def test_turtlebot_has_no_sideways_moves():
    assert len(TURTLEBOT_ACTIONS) == 6
    poses = lattice_poses(np.array([[0.0, 0.0], [0.5, 0.0]]), HEADINGS, (0, 30))
    transitions = lattice_transitions(poses, TURTLEBOT_ACTIONS, 0.5)
    assert transitions.shape == (16, 6)
    assert islands(transitions).max() == 0


def test_no_goal_is_reachable_from_nowhere():
    poses = lattice_poses(np.zeros((1, 2)), HEADINGS, TILTS)
    transitions = lattice_transitions(poses, EIGHT_ACTIONS, 0.5)
    assert (steps_to_goal(transitions, np.zeros(12, bool)) == UNREACHABLE).all()
    assert shortest_path(transitions, np.zeros(12, bool), 3) == []


def test_poses_that_occur_twice_are_refused():
    poses = lattice_poses(np.zeros((2, 2)), (0,), (0,))
    with pytest.raises(ValueError, match="occur twice"):
        lattice_transitions(poses, EIGHT_ACTIONS, 0.5)


@given(st.lists(st.floats(0, 1), min_size=1, max_size=30), st.integers(1, 8))
def test_goal_states_are_those_as_large_as_the_nth_largest(areas, rank):
    column = np.array(areas, np.float32)[:, None]
    goals = goal_states(column, rank)[:, 0]
    ranked = sorted(column[:, 0], reverse=True)
    threshold = ranked[min(rank, len(ranked)) - 1]
    assert goals.tolist() == [bool(a >= threshold and a > 0) for a in column[:, 0]]


@pytest.mark.parametrize(("tilt", "number"), [(-90, 0), (-16, 0), (-15, 0), (-14, 1), (14.0, 1), (40, 2)])
def test_the_nearest_tilt_of_a_lattice(tilt, number):
    assert nearest_tilt((-30.0, 0.0, 30.0), tilt) == number


def test_rank_must_be_positive():
    with pytest.raises(ValueError, match="at least 1"):
        goal_states(np.ones((3, 1)), 0)
