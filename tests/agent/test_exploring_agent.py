"""An agent whose policy leads in circles goes round the room; as the tables say, and not if it is told not to."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from active_perceiver.agent.controller import REVISIT_LIMIT
from active_perceiver.agent.exploration import map_file
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.evaluation import stop_evaluation, stop_tables
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.object_measures import agent_detections, with_query_pictures
from active_perceiver.live import SearchConfig, search
from active_perceiver.robots import RecordedRobot
from active_perceiver.scenes import Action

STARTS = (0, 50, 101, 150)


class Turning:
    """A policy that turns left for ever, as one might where a target has been taken away."""

    def probabilities(self, views, targets, masks, scene):
        shape = (*np.shape(masks)[:-1], len(Action))
        certain = np.zeros(shape)
        certain[..., list(Action).index(Action.ROTATE_LEFT)] = 1.0
        return certain


def turning(agent_folder, *, explore: bool) -> ActivePerceiver:
    agent = ActivePerceiver.from_pretrained(agent_folder, explore=explore)
    agent.policy = Turning()
    return agent


def states_of(record, scene):
    return [
        int(np.abs(scene.poses - np.array(step_record.pose)).sum(axis=1).argmin())
        for step_record in record.step_records
    ]


def test_it_gets_out_and_finds_what_it_can_see(agent_folder, scene):
    found, config = {}, SearchConfig(max_steps=150, seed=0)
    for explore in (False, True):
        agent = turning(agent_folder, explore=explore)
        found[explore] = [
            search(agent, RecordedRobot(scene, start), scene.targets[target].picture(0), config).found
            for start in STARTS
            for target in range(3)
        ]
    assert np.mean(found[True]) > np.mean(found[False]) + 0.3


@pytest.mark.parametrize("confirm", [False, True])
@pytest.mark.parametrize("explore", [False, True])
def test_the_tables_take_the_same_way(agent_folder, scene, monkeypatch, confirm, explore):
    """All that evaluation computes for an agent, against that agent; `test_one_controller` has more starts."""
    monkeypatch.setattr(stop_evaluation, "LIMIT", 60)
    agent = ActivePerceiver.from_pretrained(agent_folder, confirm=confirm, explore=explore)
    (seen,) = [with_query_pictures(agent, one) for one in agent_detections(agent)]
    tables = stop_tables.scene_tables(agent, seen, [0], EvaluateConfig(confirm=confirm, explore=explore))
    same = []
    for target, start in itertools.product(range(3), STARTS):
        picture = scene.targets[target].picture(0)
        record = search(
            agent, RecordedRobot(scene, start), picture, SearchConfig(max_steps=stop_evaluation.LIMIT, seed=0)
        )
        ours = stop_evaluation.search_once(tables[target], start, 0, seed=0)
        same.append((states_of(record, scene), record.found) == (list(ours.states), ours.found))
    # Maps that were cached as float16 may tip a detection at the threshold.
    assert np.mean(same) > 0.8


def test_an_agent_without_a_map_follows_its_policy(agent_folder, scene, tmp_path):
    agent = ActivePerceiver.from_pretrained(agent_folder)
    assert agent.room(scene.name) is not None
    agent.save_pretrained(tmp_path / "copy")
    map_file(tmp_path / "copy", scene.name).unlink()
    bare = ActivePerceiver.from_pretrained(tmp_path / "copy")
    assert bare.room(scene.name) is None
    bare.reset(scene.targets[0].picture(0), seed=0)
    agent.reset(scene.targets[0].picture(0), seed=0)
    np.testing.assert_array_equal(bare.act(scene.view(7)).probabilities, agent.act(scene.view(7)).probabilities)


def test_it_says_what_it_is_going_to_do(agent_folder, scene):
    """While it explores, one action has the probability 1."""
    agent = turning(agent_folder, explore=True)
    agent.reset(scene.targets[0].picture(0), seed=0)
    for _ in range(REVISIT_LIMIT):
        agent.act(scene.view(0))
    step = agent.act(scene.view(0))
    assert step.found or step.probabilities.max() == 1.0
    assert step.found or step.action is agent.actions[int(step.probabilities.argmax())]


def test_what_is_blocked_is_not_tried_again_until_it_has_moved(agent_folder, scene):
    agent = ActivePerceiver.from_pretrained(agent_folder, explore=False)
    agent.reset(scene.targets[0].picture(0), seed=0)
    tried, step = set(), agent.act(scene.view(0))
    for _ in range(len(agent.actions) - 1):
        tried.add(step.action)
        step = agent.act(scene.view(0), robot_moved=False)
        assert step.action not in tried
        assert step.probabilities.sum() == pytest.approx(1)
    assert (agent.act(scene.view(0), robot_moved=False).probabilities > 0).all()  # nothing is left that was not tried
    assert (agent.act(scene.view(1), robot_moved=True).probabilities > 0).all()
