"""When an agent says that it has found what it looks for: all the rules, with their constants.

A search ends where `says_found` says so, and nowhere else: `SearchController.step` calls it, for the live search and
for the tables of evaluation. In the order in which they are applied:

1. **One image says so** (`GoalObservation.found`).
   - For an object (`goals/object_goal.py`), a `FoundCriterion` is met: the presence probability is at least `score`
     and the agent's own box covers at least `area` of the image. Nothing below the agent's `score_threshold`, which
     training chooses for its recogniser, counts as seen at all.
     If the picture shows a target that the agent was trained for (its embedding is as similar to one of that
     target's as the agent's `match_threshold`: `agent/target_matching.py`), `score` is `score_threshold` and `area`
     that target's `stop_area_threshold`: of the boxes drawn in its goal states the smallest, yet between
     SMALLEST_SHARE = 0.6 of the smallest true one and all of it; and of that AREA_MARGIN = 0.95.
     For any other picture `score` is at least OPEN_SET_SCORE = 0.99 and `area` the median over the known targets.
   - For a view (`goals/view_goal.py`), its features have at least the agent's `found_similarity` to the picture's,
     which lies FOUND_MARGIN = 0.1 of the way from the most similar other view of the scene to 1
     (`evaluation/view_selection.py`).
2. **That is enough** if the policy leads the search, without `confirm`.
3. **Two views say so** if the agent is told to `confirm`, or the search is exploring: besides 1, the view before the
   robot last moved had nearly met the criterion (`GoalObservation.nearly`): with half the area.
   A search begins to explore, where it knows the room, when it has looked at the present view REVISIT_LIMIT = 4
   times before. It does so for EXPLORATION_BUDGET = 8 actions, twice as many each further time, and beyond that as
   long as what it has seen tells it where to go (`agent/controller.py`).
4. **Nothing better is left** for a search that is exploring (`Explorer.settled` in `agent/exploration/explorer.py`):
   it stands where it saw the target largest, several places agree on where the target is, and, unless the box there
   had `area`, no state that it has not looked at promises more than WORTH_A_LOOK = 0.8 of it. The mean score of
   the COUNTED = 3 largest boxes (`agent/exploration/triangulation.py`) has to be SURE = 0.97 at first, and falls to
   `score_threshold` in PATIENCE = 120 actions of exploring. Neither the area nor a second view is asked for then.

Whether a "found" is true is another matter, which only evaluation knows: `TRUE_IOU` in
`evaluation/stop_evaluation.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

OPEN_SET_SCORE = 0.99
"""Least presence probability for saying found when the picture shows none of the targets an agent was trained for."""

SMALLEST_SHARE = 0.6
"""A target's least area is at least this share of its smallest true one in a goal state, so that one bad detection
does not make the agent stop far away."""

AREA_MARGIN = 0.95
"""A box is enough if it is so much of the smallest expected one: another picture of the same object gives slightly
other boxes, and an agent in front of the object that misses its mark by a hair would search on for ever."""


@dataclass(frozen=True)
class FoundCriterion:
    """When one image is enough to say found.

    Attributes:
        score: least presence probability.
        area: least area of the agent's own box, as a fraction of the image.
    """

    score: float
    area: float

    def met(self, score: ArrayLike, area: ArrayLike) -> NDArray[np.bool_]:
        """Whether detections are enough, for scalars or arrays of one shape."""
        return (np.asarray(score) >= self.score) & (np.asarray(area) >= self.area)

    def nearly_met(self, score: ArrayLike, area: ArrayLike) -> NDArray[np.bool_]:
        """Whether detections would be enough if half the area were: what the view before a goal's shows as well."""
        return self.met(score, 2 * np.asarray(area))


def says_found(found: bool, nearly_before: bool, *, confirm: bool, exploring: bool, settled: bool) -> bool:
    """Decide whether the agent says found: rules 2 to 4 above.

    Args:
        found: whether the present image says so.
        nearly_before: whether the last other view nearly did.
        confirm: whether the agent is told to take two views.
        exploring: whether the search explores the room instead of following its policy.
        settled: whether exploring has come to the best place it knows; of no account unless it explores.
    """
    if exploring and settled:
        return True
    return found and (nearly_before or not (confirm or exploring))


def stop_area_threshold(
    scores: NDArray[np.floating],
    boxes: NDArray[np.floating],
    areas: NDArray[np.floating],
    goals: NDArray[np.bool_],
    threshold: float,
) -> float:
    """How large a target's own box has to be for the agent to say found.

    The policy leads to the goal states, so each of them should be enough: the smallest box seen in any of them
    with any picture, within the limits that rule 1 above names.

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
    smallest = np.clip(own.min() if len(own) else 0.0, SMALLEST_SHARE * smallest_true, smallest_true)
    return AREA_MARGIN * float(smallest)
