"""Each goal is known to every layer that has to know it."""

from typing import get_args, get_type_hints

import pytest

from active_perceiver.agent.config import AgentConfig, AgentError, GoalName
from active_perceiver.agent.goals import GOALS
from active_perceiver.evaluation.evaluate import MEASURES
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.policy_stage import learner_config
from active_perceiver.training.train import PIPELINES


def test_every_layer_knows_the_same_goals():
    names = get_args(GoalName)
    assert tuple(GOALS) == tuple(goal.name for goal in GOALS.values()) == names
    assert tuple(PIPELINES) == tuple(MEASURES) == names
    assert get_args(get_type_hints(TrainConfig)["task"]) == names


def test_an_agent_that_searches_for_something_else_is_refused():
    with pytest.raises(AgentError, match="one of object, view, not 'smell'"):
        AgentConfig("efficientnet_lite0", 96, None, 1.0, {}, [], 1.0, 1.0, task="smell")


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("learner", LEARNERS)
def test_a_goal_s_reward_is_one_that_its_learner_knows(goal, learner):
    config = learner_config(TrainConfig(task=goal, learner=learner))
    own = LEARNERS[learner].config()
    if hasattr(own, "reward"):
        assert config.reward == (GOALS[goal].default_reward or own.reward)
