"""The place from where a picture was taken as a goal: a view that is as good as the picture means found."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.config import AgentConfig
from active_perceiver.agent.goals.goal import CardWords, Goal, GoalObservation
from active_perceiver.utils.linalg import unit_vectors
from active_perceiver.vision.backbone import Backbone, pooled


@dataclass(frozen=True, eq=False)
class ViewGoal:
    """The view that one search looks for; see `SearchGoal`.

    Attributes:
        target: (1, D) float32, its features.
        found_similarity: least cosine similarity of features that means found.
        criterion: none, for nothing is ever detected.
    """

    target: NDArray[np.float32]
    found_similarity: float
    criterion: None = None

    def observe(self, maps: NDArray[np.float32]) -> GoalObservation:
        """See `SearchGoal.observe`."""
        similarity = float(unit_vectors(pooled(maps)[0]) @ unit_vectors(self.target[0]))
        return GoalObservation(None, found=similarity >= self.found_similarity, nearly=False)


class ViewDetector:
    """Looks for the place from where a picture was taken: a view that is as good as the picture means found."""

    files: ClassVar[tuple[str, ...]] = ()

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, threads: int | None) -> None:
        self._found_similarity = config.found_similarity

    def begin(self, maps: NDArray[np.float32], branch: str) -> ViewGoal:
        """See `GoalDetector.begin`."""
        return ViewGoal(pooled(maps), self._found_similarity)  # pooled as views are, for the picture is one


VIEW = Goal(
    name="view",
    detector=ViewDetector,
    has_boxes=False,
    default_reward="goal",
    words=CardWords(
        tags="active-perception, visual-navigation",
        searched="one of the views it was trained for, which are in `targets`",
        arrived="where that picture was taken",
        picture="view.png",
        right="at the very state whose view it was given",
    ),
)
"""The place from where a picture was taken, as in Zhu et al. (ICRA 2017)."""
