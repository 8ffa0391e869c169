"""Search tasks: goals, starts and steps of a scene, and what is refused."""

from dataclasses import replace

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from active_perceiver.envs import SearchError, SearchTask
from active_perceiver.scenes import SceneError
from helpers.toy import toy_scene


@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 1000), side=st.integers(2, 4), rank=st.integers(1, 8))
def test_steps_are_shortest_paths_and_starts_are_neither_goals_nor_lost(seed, side, rank):
    scene = toy_scene(seed, side=side, targets=2, image_size=24)
    visible = [name for index, name in enumerate(scene.target_names) if (scene.areas[:, index] > 0).any()]
    task = SearchTask.from_scene(scene, visible, rank)
    graph = networkx.DiGraph((s, int(n)) for s, row in enumerate(task.transitions) for n in row)
    for target in range(len(task.targets)):
        goals = np.flatnonzero(task.goals[:, target])
        assert len(goals) >= min(rank, int((task.areas[:, target] > 0).sum()))
        lengths = networkx.multi_source_dijkstra_path_length(graph.reverse(), set(goals.tolist()))
        assert [lengths.get(state, -1) for state in range(len(task))] == task.steps[:, target].tolist()
        assert set(task.starts(target)) == {s for s in lengths if s not in goals}
    assert task.warnings == ()


def test_chooses_targets_in_the_order_given(scene):
    task = SearchTask.from_scene(scene, ["ball2", "ball0"])
    assert task.targets == ("ball2", "ball0")
    np.testing.assert_array_equal(task.areas, scene.areas[:, [2, 0]])
    assert task.target_index("ball0") == 1
    np.testing.assert_array_equal(
        task.goal_areas, [task.areas[goals, t].min() for t, goals in enumerate(task.goals.T)]
    )
    assert len(task) == len(scene)


def cut_off(scene, state):
    """The scene with one state that no action leaves."""
    transitions = scene.transitions.copy()
    transitions[state] = state
    return replace(scene, transitions=transitions)


def test_says_how_many_states_are_lost(scene):
    outside = int(SearchTask.from_scene(scene).starts(0)[0])
    task = SearchTask.from_scene(cut_off(scene, outside), ["ball0"])
    assert outside not in task.starts(0)
    assert len(task.warnings) == 1
    assert "1 states from which no goal of 'ball0'" in task.warnings[0]


def test_refuses_what_cannot_be_searched(scene):
    with pytest.raises(SceneError, match="no target 'sofa'"):
        SearchTask.from_scene(scene, ["sofa"])
    with pytest.raises(SearchError, match="no targets"):
        SearchTask.from_scene(scene, [])
    with pytest.raises(SearchError, match="twice"):
        SearchTask.from_scene(scene, ["ball0", "ball0"])
    hidden = scene.boxes.copy()
    hidden[:, 1] = np.nan
    with pytest.raises(SearchError, match="'ball1' has no goal state"):
        SearchTask.from_scene(replace(scene, boxes=hidden))
    with pytest.raises(SearchError, match="no start leads to 'ball0'"):
        SearchTask.from_scene(frozen(scene), ["ball0"])
    with pytest.raises(SearchError, match="no target 'sofa'"):
        SearchTask.from_scene(scene).target_index("sofa")


def frozen(scene):
    """The scene with all actions blocked."""
    own = np.arange(len(scene), dtype=np.int32)[:, None]
    return replace(scene, transitions=np.broadcast_to(own, scene.transitions.shape))


@pytest.mark.parametrize(
    ("field", "change", "message"),
    [
        ("transitions", lambda array: array[:, :-1], "transitions has shape"),
        ("transitions", lambda array: array + 1000, "lead outside"),
        ("areas", lambda array: array[:-1], "areas has shape"),
        ("areas", lambda array: np.full_like(array, np.nan), "finite"),
        ("areas", np.zeros_like, "must be visible at its goals"),
        ("goals", lambda array: array[:, :1], "goals has shape"),
        ("goals", np.zeros_like, "no goal state"),
        ("steps", lambda array: array + 1, "steps must be 0 at the goals"),
    ],
)
def test_refuses_unsound_arrays(scene, field, change, message):
    task = SearchTask.from_scene(scene)
    with pytest.raises(SearchError, match=message):
        replace(task, **{field: change(getattr(task, field))})
