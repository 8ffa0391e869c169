"""Searches that end by the agent's own word: it stops where its own box is large enough, and may be wrong.

No ground truth is used until the search has ended; then it says whether "found" was true.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.controller import SearchController
from active_perceiver.agent.loop_escape import ALIKE
from active_perceiver.goals.goal import GoalObservation
from active_perceiver.recognition.metrics import box_iou
from active_perceiver.utils.linalg import unit_vectors

LIMIT = 500
"""Actions after which a search by the agent's own word gives up."""

TRUE_IOU = 0.5
"""A "found" is true if the drawn box overlaps the object's true box at least so much."""

MARGIN = 0.95
"""A box is enough if it is so much of the smallest expected one: another picture of the same object gives slightly
other boxes, and an agent in front of the object that misses its mark by a hair would search on for ever."""


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


@dataclass(frozen=True, eq=False)
class SearchTables:
    """All that an agent would see and do while it searches for one target, with each of its K pictures.

    Attributes:
        scene: where, its name.
        target: what for, its name.
        probabilities: (S, K, A) of the actions, the policy's.
        goal_observations: what it sees in a state, asked with a picture; by their numbers.
        right: (S, K) where "found" is true.
        transitions: (S, A).
        steps: (S,) fewest actions to a goal; searches start where this is positive.
        alike: (S, S) which views the agent takes for the same, see `alike_views`.
        controller: the beginning of a search with a picture, by its number.
        likeness: (S, R) how alike each view is to the R states of the room that the agent remembers; None if it does
            not look round there.
    """

    scene: str
    target: str
    probabilities: NDArray[np.floating]
    goal_observations: Callable[[int, int], GoalObservation]
    right: NDArray[np.bool_]
    transitions: NDArray[np.integer]
    steps: NDArray[np.integer]
    alike: NDArray[np.bool_]
    controller: Callable[[int], SearchController] = field(default=lambda picture: SearchController())
    likeness: NDArray[np.floating] | None = None


def stop_area_threshold(
    scores: NDArray[np.floating],
    boxes: NDArray[np.floating],
    areas: NDArray[np.floating],
    goals: NDArray[np.bool_],
    threshold: float,
) -> float:
    """How large a target's own box has to be for the agent to say found.

    The policy leads to the goal states, so each of them should be enough: the smallest box seen in any of them
    with any picture, but never less than 0.6 of the smallest true one, so that one bad detection does not make the
    agent stop far away; less a `MARGIN`.

    Args:
        scores: (S, K) presence probabilities for the target's pictures.
        boxes: (S, K, 4) detections.
        areas: (S,) true areas.
        goals: (S,) bool, the target's goal states.
        threshold: least score that counts as seen.
    """
    smallest_true = float(areas[goals].min())
    seen = scores[goals] >= threshold
    own = (boxes[goals][..., 2] * boxes[goals][..., 3])[seen]
    smallest = np.clip(own.min() if len(own) else 0.0, 0.6 * smallest_true, smallest_true)
    return MARGIN * float(smallest)


def alike_views(view_features: NDArray[np.floating]) -> NDArray[np.bool_]:
    """(S, S) which views an agent takes for the same one, from their (S, D) pooled features."""
    units = unit_vectors(view_features.astype(np.float32))
    return units @ units.T > ALIKE


def is_on_object(detected: NDArray[np.floating], true_boxes: NDArray[np.floating]) -> NDArray[np.bool_]:
    """(S, K) where the drawn box is on the object, from (S, K, 4) drawn and (S, 4) true boxes, NaN if not visible."""
    return np.nan_to_num(box_iou(detected, true_boxes[:, None]), nan=0.0) >= TRUE_IOU


def search_until_found(asked: SearchTables, searches: int, rng: np.random.Generator) -> StopEvaluation:
    """Search from random starts, each with one of the target's pictures at random, until found or the limit.

    Everything the agent would see is a table, so this is what `ActivePerceiver.act` does, only faster.

    Args:
        asked: what is searched for, and all there is to see.
        searches: how many.
        rng: draws starts, pictures and actions.
    """
    starts = rng.choice(np.flatnonzero(asked.steps > 0), searches)
    pictures = rng.integers(asked.right.shape[1], size=searches)
    ends = [search_once(asked, int(s), int(p), rng) for s, p in zip(starts, pictures, strict=True)]
    states, taken, ended = (np.array(column) for column in zip(*ends, strict=True))
    true = ended & asked.right[states, pictures]
    return StopEvaluation(
        scene=asked.scene,
        target=asked.target,
        searches=searches,
        true_found=float(true.mean()),
        false_found=float((ended & ~true).mean()),
        not_found=float((~ended).mean()),
        at_goal=float((ended & (asked.steps[states] == 0)).mean()),
        mean_steps=float(taken[true].mean()) if true.any() else float("nan"),
        shortest_mean=float(asked.steps[starts].mean()),
    )


def search_once(asked: SearchTables, state: int, picture: int, rng: np.random.Generator) -> tuple[int, int, bool]:
    """The state where a search ends, the actions it takes, and whether the agent says found there."""
    controller, looks, before = asked.controller(picture), np.zeros(len(asked.transitions), np.int64), -1
    for taken in range(LIMIT + 1):
        probabilities, found = controller.step(
            asked.goal_observations(state, picture),
            asked.probabilities[state, picture],
            earlier=int(looks[state]),
            view_changed=before >= 0 and not asked.alike[before, state],
            likeness=None if asked.likeness is None else asked.likeness[state],
        )
        if found:
            return state, taken, True
        looks += asked.alike[state]
        limits = np.cumsum(probabilities)
        action = int(np.searchsorted(limits, rng.random() * limits[-1], side="right"))
        controller.notify_action(action)
        before, state = state, int(asked.transitions[state, action])
    return before, LIMIT, False


def overall(results: Sequence[StopEvaluation]) -> dict[str, float]:
    """Means over targets."""
    names = ("true_found", "false_found", "not_found", "at_goal", "mean_steps", "shortest_mean")
    return {name: float(np.mean([getattr(result, name) for result in results])) for name in names}
