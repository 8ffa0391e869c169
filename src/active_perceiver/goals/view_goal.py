"""The place from where a picture was taken as a goal: a view that is as good as the picture means found."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.config import AgentConfig
from active_perceiver.goals.goal import GoalObservation
from active_perceiver.utils.linalg import unit_vectors
from active_perceiver.vision.backbone import Backbone, pooled


class ViewDetector:
    """Looks for the place from where a picture was taken: a view that is as good as the picture means found."""

    files: ClassVar[tuple[str, ...]] = ()

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, threads: int | None) -> None:
        self._found_similarity = config.found_similarity

    def begin(self, maps: NDArray[np.float32], branch: str) -> NDArray[np.float32]:
        """See `GoalDetector.begin`."""
        target = pooled(maps)  # as views are, for the picture is one
        self._target = unit_vectors(target[0])
        return target

    def observe(self, maps: NDArray[np.float32]) -> GoalObservation:
        """See `GoalDetector.observe`; nothing is ever detected."""
        similarity = float(unit_vectors(pooled(maps)[0]) @ self._target)
        return GoalObservation(None, found=similarity >= self._found_similarity, nearly=False)
