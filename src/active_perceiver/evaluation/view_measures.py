"""How good an agent is that searches for views: its policy, and the searches that it ends itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.config import picture_folder
from active_perceiver.agent.goals.goal import GoalObservation
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.agent.visit_memory import ViewFeatures
from active_perceiver.envs.view_task import viewed_state
from active_perceiver.errors import UserError
from active_perceiver.evaluation import stop_evaluation
from active_perceiver.evaluation.agent_evaluation import SEEN, AgentEvaluation
from active_perceiver.evaluation.agent_scenes import agent_scenes, features_of
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.policy_metrics import evaluate_tables
from active_perceiver.evaluation.view_selection import ViewSearches
from active_perceiver.policies.policy import policy_table
from active_perceiver.utils.progress import console


def measure_view_agent(
    agent: ActivePerceiver, searches: Sequence[ViewSearches], config: EvaluateConfig
) -> AgentEvaluation:
    """Measure an agent in the scenes it was trained in.

    A search that the agent ends is right if it ends at the very state whose view it was given; a view that only looks
    the same is a false one.

    Args:
        agent: what to measure.
        searches: one for each of its branches.
        config: how.
    """
    tables = [policy_table(agent.policy, one.observations, one.scene.name) for one in searches]
    asked = [(one.task, [table]) for one, table in zip(searches, tables, strict=True)]
    policy = evaluate_tables(asked, config)
    rng = np.random.default_rng(config.seed)
    results = []
    for one, table in zip(searches, tables, strict=True):
        task, views = one.task, ViewFeatures.of_scene(one.view_features)
        found = one.similarity >= agent.config.found_similarity
        for index, name in enumerate(task.targets):
            column = slice(index, index + 1)  # a view is the one picture of itself
            searched = stop_evaluation.SearchTables(
                scene=one.scene.name,
                target=name,
                probabilities=table[:, column],
                goal_observations=partial(_goal_observation, found[:, index]),
                views=views,
                right=task.goals[:, column],
                transitions=task.transitions,
                steps=task.steps[:, index],
            )
            results.append(stop_evaluation.search_until_found(searched, config.searches, rng))
    return AgentEvaluation(
        policy=replace(policy, protocol={**policy.protocol, "pictures": "the views themselves"}),
        stop_protocol={
            "searches": config.searches,
            "limit": stop_evaluation.LIMIT,
            "found_similarity": agent.config.found_similarity,
        },
        stops={SEEN: stop_evaluation.StopResults(tuple(results))},
    )


def _goal_observation(found: NDArray[np.bool_], state: int, picture: int) -> GoalObservation:
    return GoalObservation(None, found=bool(found[state]), nearly=False)


def agent_view_searches(agent: ActivePerceiver) -> list[ViewSearches]:
    """What an agent was trained to search for in each of its scenes.

    Raises:
        SceneError: if one of them is no longer there.
        UserError: if one has changed since.
    """
    searches = []
    for scene, names in agent_scenes(agent):
        states = tuple(viewed_state(name) for name in names)
        for name, state in zip(names, states, strict=True):
            kept = [path.read_bytes() for path in picture_folder(agent.folder, scene.name, name).glob("*")]
            if state >= len(scene) or kept != [scene.views[state]]:
                raise UserError(
                    f"'{name}' is not the view of scene '{scene.name}' that the agent was trained for; train it again"
                )
        searches.append(ViewSearches(scene, states, features_of(scene, agent.backbone).view_features))
    return searches


def measure_views(agent: ActivePerceiver, config: EvaluateConfig) -> AgentEvaluation:
    """Open the scenes that an agent was trained in, and measure it there; see `measure_view_agent`."""
    searches = agent_view_searches(agent)
    with console.status("measuring"):
        return measure_view_agent(agent, searches, config)
