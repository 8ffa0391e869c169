"""The targets an agent was trained for, and when it may say that it has found what a picture shows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from active_perceiver.agent_config import AgentConfig, AgentError, KnownTarget, picture_folder
from active_perceiver.policies.restless import unit_vectors
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.scenes import read_image
from active_perceiver.vision.backbone import Backbone

UNKNOWN_SCORE = 0.99
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


class KnownTargets:
    """The targets an agent was trained for, told apart by their pictures: how close it has to get to each.

    Pictures are compared by the recogniser's codes of them, which were learned to tell objects apart.
    """

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, recogniser: Recogniser) -> None:
        self._folder = folder
        self._config = config
        self._backbone = backbone
        self._recogniser = recogniser
        self._codes: dict[KnownTarget, NDArray[np.float32]] = {}

    def codes(self, target: KnownTarget) -> NDArray[np.float32]:
        """(K, D) float32 unit vectors, one a picture; computed when first asked for.

        Raises:
            AgentError: if the agent's folder holds no picture of the target.
        """
        if target not in self._codes:
            pictures = picture_folder(self._folder, target.scene, target.name)
            files = sorted(pictures.glob("*"))
            if not files:
                raise AgentError(f"{pictures} holds no pictures; copy the whole agent")
            maps = self._backbone.maps([read_image(file) for file in files])
            self._codes[target] = unit_vectors(self._recogniser.encode_target(maps))
        return self._codes[target]

    def match(self, code: NDArray[np.float32], scene: str) -> KnownTarget | None:
        """The target of a scene whose pictures are most like the one with this code; None if none is alike.

        Args:
            code: (D,) the recogniser's code of a picture.
            scene: whose targets to compare with.
        """
        ours = unit_vectors(code)
        similarity = {
            target: float((self.codes(target) @ ours).max())
            for target in self._config.targets
            if target.scene == scene
        }
        best = max(similarity, key=lambda target: similarity[target], default=None)
        return best if best is not None and similarity[best] >= self._config.known_similarity else None

    def criterion(self, code: NDArray[np.float32], scene: str) -> FoundCriterion:
        """When to say found for the picture with this code.

        A recogniser knows what it does not know less well than the rest, so for a picture that shows none of the
        known targets it has to be almost certain.

        Args:
            code: (D,) the recogniser's code of a picture.
            scene: the policy branch of the search.
        """
        match = self.match(code, scene)
        if match is None:
            return FoundCriterion(max(self._config.score_threshold, UNKNOWN_SCORE), self._config.found_area)
        return FoundCriterion(self._config.score_threshold, match.found_area)
