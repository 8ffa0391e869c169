"""Searches that end by the agent's own word: it stops where its own box is large enough, and may be wrong.

No ground truth is used until the search has ended; then it says whether "found" was true. When found is said:
`agent/found_criterion.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.controller import SearchController
from active_perceiver.agent.exploration import Explorer
from active_perceiver.agent.goals.goal import GoalObservation
from active_perceiver.agent.search_policy import Observation
from active_perceiver.agent.visit_memory import ViewFeatures
from active_perceiver.recognition.metrics import box_iou

LIMIT = 500
"""Actions after which a search by the agent's own word gives up."""

TRUE_IOU = 0.5
"""A "found" is true if the drawn box overlaps the object's true box at least so much."""


@dataclass(frozen=True)
class StopEvaluation:
    """How searches that the agent ended itself went.

    Attributes:
        scene: where.
        target: what was looked for.
        searches: how many.
        true_found: share that ended with "found" where that is right: the drawn box on the object (IoU at least
            0.5), or at the very state whose view was looked for.
        false_found: share that ended with "found" elsewhere.
        not_found: share that reached the limit.
        at_goal: share that ended with "found" in one of the target's goal states.
        mean_steps: actions of the searches with a true "found"; NaN if there is none.
        shortest_mean: fewest actions to a goal state from the same starts.
    """

    scene: str
    target: str
    searches: int
    true_found: float
    false_found: float
    not_found: float
    at_goal: float
    mean_steps: float
    shortest_mean: float


@dataclass(frozen=True)
class StopResults:
    """Those of several targets.

    Attributes:
        per_target: one for each target.
    """

    per_target: tuple[StopEvaluation, ...]

    @property
    def overall(self) -> dict[str, float]:
        """Means over targets."""
        names = ("true_found", "false_found", "not_found", "at_goal", "mean_steps", "shortest_mean")
        return {name: float(np.mean([getattr(result, name) for result in self.per_target])) for name in names}

    def to_json(self) -> dict[str, Any]:
        """The parts `overall` and `per_target` of a result file."""
        return {"overall": self.overall, "per_target": [asdict(result) for result in self.per_target]}


@dataclass(frozen=True, eq=False)
class SearchTables:
    """All that an agent would see and do while it searches for one target, with each of its K pictures.

    Attributes:
        scene: where, its name.
        target: what for, its name.
        probabilities: (S, K, A) of the actions, the policy's.
        goal_observations: what it sees in a state, asked with a picture; by their numbers.
        views: S of them, what it knows the states' views by.
        right: (S, K) where "found" is true.
        transitions: (S, A).
        steps: (S,) fewest actions to a goal; searches start where this is positive.
        confirm: whether it takes two views to say found.
        explorer: what looks round the room in a search with a picture, by its number; None if it does not.
    """

    scene: str
    target: str
    probabilities: NDArray[np.floating]
    goal_observations: Callable[[int, int], GoalObservation]
    views: Sequence[ViewFeatures]
    right: NDArray[np.bool_]
    transitions: NDArray[np.integer]
    steps: NDArray[np.integer]
    confirm: bool = False
    explorer: Callable[[int], Explorer] | None = None


@dataclass(frozen=True)
class TableSearch:
    """A search in tables.

    Attributes:
        states: where it looked, one after the other.
        actions: what it did, by index, one fewer.
        found: whether it says found in the last state.
    """

    states: tuple[int, ...]
    actions: tuple[int, ...]
    found: bool


def is_on_object(detected: NDArray[np.floating], true_boxes: NDArray[np.floating]) -> NDArray[np.bool_]:
    """(S, K) where the drawn box is on the object, from (S, K, 4) drawn and (S, 4) true boxes, NaN if not visible."""
    return np.nan_to_num(box_iou(detected, true_boxes[:, None]), nan=0.0) >= TRUE_IOU


def search_until_found(tables: SearchTables, searches: int, rng: np.random.Generator) -> StopEvaluation:
    """Search from random starts, each with one of the target's pictures at random, until found or the limit.

    Args:
        tables: what is searched for, and all there is to see.
        searches: how many.
        rng: draws starts, pictures and actions.
    """
    starts = rng.choice(np.flatnonzero(tables.steps > 0), searches)
    pictures = rng.integers(tables.right.shape[1], size=searches)
    ends = [search_once(tables, int(s), int(p), rng) for s, p in zip(starts, pictures, strict=True)]
    states = np.array([end.states[-1] for end in ends])
    taken = np.array([len(end.actions) for end in ends])
    found = np.array([end.found for end in ends])
    true = found & tables.right[states, pictures]
    return StopEvaluation(
        scene=tables.scene,
        target=tables.target,
        searches=searches,
        true_found=float(true.mean()),
        false_found=float((found & ~true).mean()),
        not_found=float((~found).mean()),
        at_goal=float((found & (tables.steps[states] == 0)).mean()),
        mean_steps=float(taken[true].mean()) if true.any() else float("nan"),
        shortest_mean=float(tables.steps[starts].mean()),
    )


def search_once(
    tables: SearchTables, start: int, picture: int, seed: int | np.random.Generator | None = None
) -> TableSearch:
    """Search as a live agent does with a `RecordedRobot`, only that what it sees has been computed before.

    Args:
        tables: what is searched for, and all there is to see.
        start: the state to begin in.
        picture: the number of the picture it is asked with.
        seed: the draws of actions follow from it.
    """
    state = start
    robot_moved: bool | None = None
    controller = SearchController(
        lambda _: tables.probabilities[state, picture],
        confirm=tables.confirm,
        explorer=None if tables.explorer is None else tables.explorer(picture),
        seed=seed,
    )
    states, actions = [state], list[int]()
    while True:
        decision = controller.step(
            Observation(tables.goal_observations(state, picture), tables.views[state], robot_moved)
        )
        if decision.found or len(actions) == LIMIT:
            return TableSearch(tuple(states), tuple(actions), decision.found)
        before, state = state, int(tables.transitions[state, decision.action])
        robot_moved = state != before
        states.append(state)
        actions.append(decision.action)
