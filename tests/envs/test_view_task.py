"""Views as targets: one goal each, no boxes, and what is refused."""

from dataclasses import replace

import networkx
import numpy as np
import pytest

from active_perceiver.envs import SearchError, view_observations, view_task
from active_perceiver.envs.view_task import view_name, viewed_state


def test_the_state_itself_is_the_only_goal_and_all_there_is_to_see(scene):
    states = (5, 40, 17)
    task = view_task(scene, states)
    assert task.targets == ("view_5", "view_40", "view_17")
    assert [np.flatnonzero(column).tolist() for column in task.goals.T] == [[5], [40], [17]]
    np.testing.assert_array_equal(task.areas, task.goals.astype(np.float32))
    np.testing.assert_array_equal(task.goal_areas, 1)


def test_steps_are_shortest_paths(scene):
    task = view_task(scene, [40])
    graph = networkx.DiGraph((int(n), s) for s, row in enumerate(scene.transitions) for n in row)
    lengths = networkx.single_source_dijkstra_path_length(graph, 40)
    assert task.steps[:, 0].tolist() == [lengths.get(state, -1) for state in range(len(scene))]


def test_a_target_is_shown_as_the_view_it_is_and_nothing_has_a_location(scene):
    features = np.random.default_rng(0).random((len(scene), 7), np.float32)
    observations = view_observations(features, (5, 40))
    observations.check_fits(view_task(scene, (5, 40)))
    np.testing.assert_array_equal(observations.target_features, features[[5, 40]][:, None])
    assert observations.pictures == 1
    assert not observations.masks.any()


@pytest.mark.parametrize(
    ("states", "message"),
    [
        ((), "no targets"),
        ((3, 9, 3), "state 3 of 'toy_0' is given twice"),
        ((-1,), "has no state -1; its states are 0 to 191"),
        ((192,), "has no state 192"),
    ],
)
def test_bad_states_are_refused(scene, states, message):
    with pytest.raises(SearchError, match=message):
        view_task(scene, states)


def test_a_state_that_nothing_leads_to_is_refused(scene):
    transitions = scene.transitions.copy()
    here = np.arange(len(scene))[:, None]
    transitions[transitions == 7] = np.broadcast_to(here, transitions.shape)[transitions == 7]
    with pytest.raises(SearchError, match="no start leads to 'view_7'"):
        view_task(replace(scene, transitions=transitions), [7])


def test_names_of_views_tell_their_states():
    assert viewed_state(view_name(345)) == 345
    for name in ("view_", "mug", "12", "view_1x", "view_-1", "view_²"):
        with pytest.raises(SearchError, match="not the name of a view"):
            viewed_state(name)
