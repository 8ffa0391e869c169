"""Which views of a scene are searched for, and how alike the scene's other views are to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.visit_memory import ALIKE
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.envs.view_task import view_observations, view_task
from active_perceiver.errors import UserError
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import Scene
from active_perceiver.utils.linalg import unit_vectors

VIEWS = 5
"""Views per scene that are searched for if none are named, as in Zhu et al. (ICRA 2017): 100 in 20 scenes."""

FOUND_MARGIN = 0.1
"""How far the least similarity for "found" lies between that of the most similar other view (0) and 1: near the
former, so that a picture that was stored with loss is still found."""


@dataclass(frozen=True, eq=False)
class ViewSearches:
    """The search for some of a scene's views.

    Attributes:
        scene: where.
        states: whose views are searched for, T of them.
        view_features: (S, D) float32 pooled features of all views.
    """

    scene: Scene
    states: tuple[int, ...]
    view_features: NDArray[np.float32]

    @cached_property
    def task(self) -> SearchTask:
        """What is searched for."""
        return view_task(self.scene, self.states)

    @cached_property
    def observations(self) -> Observations:
        """What the policy is shown."""
        return view_observations(self.view_features, self.states)

    @property
    def training_task(self) -> TrainingTask:
        """Both, as a learner needs them."""
        return TrainingTask(self.task, self.observations)

    @cached_property
    def similarity(self) -> NDArray[np.float32]:
        """(S, T) cosine similarity of each view to each one that is searched for."""
        units = unit_vectors(self.view_features)
        return units @ units[list(self.states)].T

    def found_similarity(self) -> float:
        """How similar a view must be to the one that is searched for to say found.

        No other view of the scene is so similar to any of them, but those that no agent can tell apart: where
        the similarity exceeds `ALIKE`.
        """
        others = (self.similarity <= ALIKE) & ~self.task.goals
        nearest = float(self.similarity[others].max(initial=0.0))
        return nearest + FOUND_MARGIN * (1.0 - nearest)


def chosen_states(scenes: Sequence[Scene], wanted: Sequence[str], seed: int) -> list[tuple[int, ...]]:
    """The states of each scene whose views are searched for.

    Args:
        scenes: where.
        wanted: numbers of states, each with its scene in front ("kitchen_1/12"), which may be left out if there is
            only one; nothing for `VIEWS` of each scene.
        seed: draws those.

    Raises:
        UserError: if one is not the number of a state, its scene is unknown or not said, or a scene has none.
    """
    if not wanted:
        return _drawn_states(scenes, seed)
    states: dict[str, list[int]] = {scene.name: [] for scene in scenes}
    for text in wanted:
        where, _, number = text.rpartition("/")
        if not where and len(scenes) > 1:
            raise UserError(f"say of which scene {text} is a state: {scenes[0].name}/{text}, for example")
        name = where or scenes[0].name
        if name not in states:
            raise UserError(f"{text}: there is no scene '{name}' here; there are {', '.join(states)}")
        if not (number.isascii() and number.isdigit()):
            raise UserError(f"a target of --task view is the number of a state, such as 12; '{text}' is none")
        states[name].append(int(number))
    for name, chosen in states.items():
        if not chosen:
            raise UserError(f"no view of scene '{name}' is among the targets {', '.join(wanted)}; leave it out")
    return [tuple(states[scene.name]) for scene in scenes]


def _drawn_states(scenes: Sequence[Scene], seed: int) -> list[tuple[int, ...]]:
    rng = np.random.default_rng(seed)
    drawn = []
    for scene in scenes:
        # A state that no move leads to is nowhere to search for.
        here = np.arange(len(scene))[:, None]
        reached = np.unique(scene.transitions[scene.transitions != here])
        chosen = rng.choice(reached, min(VIEWS, len(reached)), replace=False)
        drawn.append(tuple(sorted(chosen.tolist())))
    return drawn
