"""What is to be searched: a scene's transitions and, for each target, its areas, goals and shortest paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import SearchError
from active_perceiver.scenes import Scene
from active_perceiver.scenes.lattice import goal_states, steps_to_goal


@dataclass(frozen=True, eq=False)
class SearchTask:
    """The search for some targets in one scene, as tables.

    Attributes:
        scene: the scene's name.
        actions: (A,) names of the columns of `transitions`.
        targets: (T,) names of what is searched.
        transitions: (S, A) int32, the next state; the state's own index where the move is blocked.
        areas: (S, T) float32, box areas as fractions of the image; 0 where the target is not visible.
        goals: (S, T) bool, where a search ends well.
        steps: (S, T) int, fewest actions to a goal; 0 at goals, -1 where no way leads.
    """

    scene: str
    actions: tuple[str, ...]
    targets: tuple[str, ...]
    transitions: NDArray[np.int32]
    areas: NDArray[np.float32]
    goals: NDArray[np.bool_]
    steps: NDArray[np.int64]

    def __post_init__(self) -> None:
        if not self.targets:
            raise SearchError(f"the search in '{self.scene}' has no targets; name at least one")
        if len(set(self.targets)) != len(self.targets):
            raise SearchError(f"the search in '{self.scene}' names a target twice: {sorted(self.targets)}")
        states = len(self.transitions)
        pairs = (states, len(self.targets))
        shapes = {
            "transitions": (self.transitions, (states, len(self.actions))),
            "areas": (self.areas, pairs),
            "goals": (self.goals, pairs),
            "steps": (self.steps, pairs),
        }
        for label, (array, shape) in shapes.items():
            if array.shape != shape:
                raise SearchError(f"the search in '{self.scene}': {label} has shape {array.shape}, expected {shape}")
        if states == 0 or self.transitions.min() < 0 or self.transitions.max() >= states:
            raise SearchError(f"the search in '{self.scene}': transitions lead outside the {states} states")
        if not np.isfinite(self.areas).all() or self.areas.min() < 0:
            raise SearchError(f"the search in '{self.scene}': areas must be finite and not negative")
        if (self.areas[self.goals] == 0).any():
            raise SearchError(f"the search in '{self.scene}': a target must be visible at its goals")
        for index, target in enumerate(self.targets):
            if not self.goals[:, index].any():
                raise SearchError(
                    f"'{target}' has no goal state in '{self.scene}', it is never visible; leave it out"
                )
            if not (self.steps[:, index] > 0).any():
                raise SearchError(
                    f"no start leads to '{target}' in '{self.scene}': its goals are all there is or cannot be reached"
                )
        if ((self.steps == 0) != self.goals).any():
            raise SearchError(f"the search in '{self.scene}': steps must be 0 at the goals and only there")

    @classmethod
    def from_scene(cls, scene: Scene, targets: Sequence[str] | None = None, rank: int = 5) -> SearchTask:
        """The search for some of a scene's targets.

        Args:
            scene: where to search.
            targets: names; None for all of the scene's.
            rank: goal states are those whose box is at least as large as the `rank`-th largest (5 in the paper).

        Raises:
            SceneError: if the scene has no such target, or none at all.
            SearchError: if a target is never visible or named twice.
        """
        scene.require_targets()
        names = scene.target_names if targets is None else tuple(targets)
        areas = scene.areas[:, [scene.target_index(name) for name in names]].astype(np.float32)
        goals = goal_states(areas, rank)
        steps = [steps_to_goal(scene.transitions, goals[:, index]) for index in range(len(names))]
        return cls(
            scene=scene.name,
            actions=tuple(action.value for action in scene.actions),
            targets=names,
            transitions=scene.transitions,
            areas=areas,
            goals=goals,
            steps=np.stack(steps, axis=1) if steps else np.zeros((len(scene), 0), np.int64),
        )

    def __len__(self) -> int:
        """Number of states."""
        return len(self.transitions)

    def starts(self, target: int) -> NDArray[np.int64]:
        """Indices of the states a search for this target may start in: no goals, and a way leads to one."""
        return np.flatnonzero(self.steps[:, target] > 0)

    @cached_property
    def goal_areas(self) -> NDArray[np.float32]:
        """(T,) the smallest area of each target's goal states."""
        return np.where(self.goals, self.areas, np.inf).min(axis=0).astype(np.float32)

    def target_index(self, name: str) -> int:
        """Index of a target by name.

        Raises:
            SearchError: if the target is not searched here; the message lists those that are.
        """
        if name not in self.targets:
            known = ", ".join(self.targets)
            raise SearchError(f"the search in '{self.scene}' has no target '{name}'; it has {known}")
        return self.targets.index(name)

    @property
    def warnings(self) -> tuple[str, ...]:
        """One sentence per target that cannot be reached from some states."""
        lost = (self.steps < 0).sum(axis=0)
        return tuple(
            f"{self.scene} has {count} states from which no goal of '{target}' can be reached; "
            "they will not be used as starts"
            for target, count in zip(self.targets, lost, strict=True)
            if count
        )
