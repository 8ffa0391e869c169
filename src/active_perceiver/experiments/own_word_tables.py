"""What an agent would see and do everywhere in its scenes, as tables to search in by its own word."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.course import Course
from active_perceiver.experiments import own_word
from active_perceiver.experiments.settings import EvaluateSettings
from active_perceiver.experiments.sightings import Sightings
from active_perceiver.exploring import Explorer, RoomMap
from active_perceiver.known_targets import FoundCriterion, Sight, sight_of
from active_perceiver.perceiver import ActivePerceiver
from active_perceiver.policies.policy import policy_table
from active_perceiver.policies.restless import unit_vectors
from active_perceiver.search.task import SearchTask

# In which scenes, and with which of the pictures there, an agent is asked to search.
Asked = Sequence[tuple[Sightings, list[int]]]


def measure_own_word(agent: ActivePerceiver, asked: Asked, settings: EvaluateSettings) -> dict[str, Any]:
    """Searches that the agent ends itself, from random starts.

    Args:
        agent: what to measure.
        asked: what it sees in its scenes with the pictures it is asked with, see `as_asked`, and which of these.
        settings: how.

    Returns:
        "overall": means, see `own_word.overall`; "per_target": for each target the fields of an `OwnWord`.
    """
    rng = np.random.default_rng(settings.seed)
    tables = [one for seen, pictures in asked for one in scene_tables(agent, seen, pictures, settings)]
    results = [own_word.search_until_found(one, settings.searches, rng) for one in tables]
    return {"overall": own_word.overall(results), "per_target": [asdict(result) for result in results]}


def scene_tables(
    agent: ActivePerceiver, seen: Sightings, pictures: list[int], settings: EvaluateSettings
) -> list[own_word.SearchTables]:
    """One for each target."""
    threshold = agent.config.score_threshold
    task = SearchTask.from_scene(seen.scene, seen.names, int(agent.config.training["rank"]))
    observations = seen.observations(threshold, pictures)
    probabilities = np.stack(
        [policy_table(agent.policy, observations, seen.scene.name, k) for k in range(len(pictures))], axis=2
    )
    alike = own_word.alike_views(seen.view_features)
    room = agent.room(seen.scene.name) if settings.explore else None
    likeness = None if room is None else unit_vectors(seen.view_features) @ room.looks.T
    tables = []
    for index, name in enumerate(seen.names):
        # As `ActivePerceiver.reset` does: the picture alone tells what is enough.
        codes = seen.target_codes[index][pictures]
        criteria = [agent.known.criterion(agent.known.match(code, seen.scene.name)) for code in codes]
        scores, boxes = (array[:, index][:, pictures] for array in (seen.scores, seen.boxes))
        tables.append(
            own_word.SearchTables(
                scene=seen.scene.name,
                target=name,
                probabilities=probabilities[:, index],
                sights=partial(_sight, scores, boxes, threshold, criteria),
                right=own_word.is_on_object(boxes, seen.scene.boxes[:, seen.targets[index]]),
                transitions=task.transitions,
                steps=task.steps[:, index],
                alike=alike,
                course=partial(_course, settings.confirm, room, threshold, criteria),
                likeness=likeness,
            )
        )
    return tables


def _sight(
    scores: NDArray[np.floating],
    boxes: NDArray[np.floating],
    threshold: float,
    criteria: Sequence[FoundCriterion],
    state: int,
    picture: int,
) -> Sight:
    return sight_of(float(scores[state, picture]), boxes[state, picture], threshold, criteria[picture])


def _course(
    confirm: bool, room: RoomMap | None, threshold: float, criteria: Sequence[FoundCriterion], picture: int
) -> Course:
    return Course(confirm, None if room is None else Explorer(room, criteria[picture].area, threshold))
