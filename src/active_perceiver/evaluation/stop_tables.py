"""What an agent would see and do everywhere in its scenes, as tables to search in by its own word."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.exploration import Explorer, ViewMap
from active_perceiver.agent.found_criterion import FoundCriterion
from active_perceiver.agent.goals.goal import GoalObservation
from active_perceiver.agent.goals.object_goal import observe_goal
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.agent.visit_memory import ViewFeatures
from active_perceiver.envs.task import SearchTask
from active_perceiver.evaluation import stop_evaluation
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.detections import DetectionTable
from active_perceiver.policies.policy import policy_table

# In which scenes, and with which of the pictures there, an agent is asked to search.
Asked = Sequence[tuple[DetectionTable, list[int]]]


def evaluate_stops(agent: ActivePerceiver, asked: Asked, settings: EvaluateConfig) -> stop_evaluation.StopResults:
    """Searches that the agent ends itself, from random starts.

    Args:
        agent: what to measure.
        asked: what it sees in its scenes with the pictures it is asked with, see `with_query_pictures`, and which of
            these.
        settings: how.
    """
    rng = np.random.default_rng(settings.seed)
    tables = [one for seen, pictures in asked for one in scene_tables(agent, seen, pictures, settings)]
    results = [stop_evaluation.search_until_found(one, settings.searches, rng) for one in tables]
    return stop_evaluation.StopResults(tuple(results))


def scene_tables(
    agent: ActivePerceiver, seen: DetectionTable, pictures: list[int], settings: EvaluateConfig
) -> list[stop_evaluation.SearchTables]:
    """One for each target."""
    threshold = agent.config.score_threshold
    task = SearchTask.from_scene(seen.scene, seen.names, agent.config.training.rank)
    observations = seen.observations(threshold, pictures)
    probabilities = np.stack(
        [policy_table(agent.policy, observations, seen.scene.name, k) for k in range(len(pictures))], axis=2
    )
    room = agent.room(seen.scene.name) if settings.explore else None
    views = ViewFeatures.of_scene(seen.view_features, room)
    tables = []
    for index, name in enumerate(seen.names):
        # As `ActivePerceiver.search` does: the picture alone tells what is enough.
        embeddings = seen.target_embeddings[index][pictures]
        criteria = [
            agent.gallery.criterion(agent.gallery.match(embedding, seen.scene.name)) for embedding in embeddings
        ]
        scores, boxes = (array[:, index][:, pictures] for array in (seen.scores, seen.boxes))
        tables.append(
            stop_evaluation.SearchTables(
                scene=seen.scene.name,
                target=name,
                probabilities=probabilities[:, index],
                goal_observations=cache(partial(_goal_observation, scores, boxes, threshold, criteria)),
                views=views,
                right=stop_evaluation.is_on_object(boxes, seen.scene.boxes[:, seen.targets[index]]),
                transitions=task.transitions,
                steps=task.steps[:, index],
                confirm=settings.confirm,
                explorer=None if room is None else partial(_explorer, room, threshold, criteria),
            )
        )
    return tables


def _goal_observation(
    scores: NDArray[np.floating],
    boxes: NDArray[np.floating],
    threshold: float,
    criteria: Sequence[FoundCriterion],
    state: int,
    picture: int,
) -> GoalObservation:
    return observe_goal(float(scores[state, picture]), boxes[state, picture], threshold, criteria[picture])


def _explorer(room: ViewMap, threshold: float, criteria: Sequence[FoundCriterion], picture: int) -> Explorer:
    return Explorer(room, criteria[picture].area, threshold)
