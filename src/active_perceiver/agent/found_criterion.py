"""When an agent says that it has found what it looks for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

OPEN_SET_SCORE = 0.99
"""Least presence probability for saying found when the picture shows none of the targets an agent was trained for."""


@dataclass(frozen=True)
class FoundCriterion:
    """When an agent says found.

    Attributes:
        score: least presence probability.
        area: least area of its own box, as a fraction of the image.
    """

    score: float
    area: float

    def met(self, score: ArrayLike, area: ArrayLike) -> NDArray[np.bool_]:
        """Whether detections are enough, for scalars or arrays of one shape."""
        return (np.asarray(score) >= self.score) & (np.asarray(area) >= self.area)

    def nearly_met(self, score: ArrayLike, area: ArrayLike) -> NDArray[np.bool_]:
        """Whether detections would be enough if half the area were: what the view before a goal's shows as well."""
        return self.met(score, 2 * np.asarray(area))
