"""Scene-target navigation (Zhu et al., ICRA 2017) as a search: the target is a view, the goal the state that has it.

There is no object to be seen before it is reached: no boxes, so a view's area is 1 at its own state and 0 elsewhere,
and every location mask is empty.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError
from active_perceiver.scenes import Scene
from active_perceiver.scenes.lattice import steps_to_goal
from active_perceiver.vision.location import GRID

_PREFIX = "view_"


def view_name(state: int) -> str:
    """What the target that is the view of a state is called: "view_12"."""
    return f"{_PREFIX}{state}"


def viewed_state(name: str) -> int:
    """The state of a target that is a view, by its name.

    Raises:
        SearchError: if it is no such name.
    """
    number = name.removeprefix(_PREFIX)
    if number == name or not (number.isascii() and number.isdigit()):
        raise SearchError(f"'{name}' is not the name of a view; those are like '{view_name(12)}'")
    return int(number)


def view_task(scene: Scene, states: Sequence[int]) -> SearchTask:
    """The search for some of a scene's own views.

    Args:
        scene: where to search.
        states: the states whose views are the targets; each is the only goal of its own.

    Raises:
        SearchError: if there are none, one is no state of the scene, is named twice, or cannot be reached.
    """
    for state in states:
        if not 0 <= state < len(scene):
            raise SearchError(f"'{scene.name}' has no state {state}; its states are 0 to {len(scene) - 1}")
        if list(states).count(state) > 1:
            raise SearchError(f"state {state} of '{scene.name}' is given twice; give it once")
    goals = np.zeros((len(scene), len(states)), np.bool_)
    goals[list(states), np.arange(len(states))] = True
    steps = np.zeros(goals.shape, np.int64)
    for index in range(len(states)):
        steps[:, index] = steps_to_goal(scene.transitions, goals[:, index])
    return SearchTask(
        scene=scene.name,
        actions=tuple(action.value for action in scene.actions),
        targets=tuple(view_name(state) for state in states),
        transitions=scene.transitions,
        areas=goals.astype(np.float32),
        goals=goals,
        steps=steps,
    )


def view_observations(view_features: NDArray[np.float32], states: Sequence[int]) -> Observations:
    """What a policy is shown when it searches for views: their features, pooled like any view's, and no location.

    Args:
        view_features: (S, D) float32 features of all views.
        states: (T) the states whose views are the targets.
    """
    return Observations(
        view_features=view_features,
        target_features=view_features[list(states)][:, None],
        masks=np.zeros((len(view_features), len(states), 1, GRID * GRID), np.float32),
    )
