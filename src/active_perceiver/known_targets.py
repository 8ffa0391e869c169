"""What an agent looks for: the object or the view in a picture, and when it may say that it has found it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from active_perceiver.agent_config import AgentConfig, AgentError, KnownTarget, SearchKind, picture_folder
from active_perceiver.policies.restless import unit_vectors
from active_perceiver.recognition.recogniser import Detection, Recogniser
from active_perceiver.scenes import read_image
from active_perceiver.vision.backbone import Backbone, pooled, pooled_middle

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


@dataclass(frozen=True)
class Sight:
    """What an agent makes of one image, apart from what to do next.

    Attributes:
        detection: where it sees the target, or None if it does not.
        found: its own word that it is in front of the target.
    """

    detection: Detection | None
    found: bool


class Seeker(Protocol):
    """What is different between agents that search for different things.

    Attributes:
        files: what it needs of an agent's folder, besides the policy.
    """

    files: ClassVar[tuple[str, ...]]

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone) -> None:
        """Load what it needs."""

    def begin(self, maps: NDArray[np.float32], branch: str) -> NDArray[np.float32]:
        """Begin a search in a scene with a picture's (1, C, h, w) maps; (1, D) target features for the policy."""

    def look(self, maps: NDArray[np.float32]) -> Sight:
        """Look at an image with these (1, C, h, w) maps."""


class ObjectSeeker:
    """Looks for the object in a picture: its recogniser draws a box, and a box that is large enough means found.

    Attributes:
        recogniser: draws the boxes.
        known: the targets the agent was trained for.
        criterion: when it says found in the current search.
    """

    files: ClassVar[tuple[str, ...]] = ("recogniser.onnx",)
    criterion: FoundCriterion

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone) -> None:
        self.recogniser = Recogniser(folder / "recogniser.onnx")
        self.known = KnownTargets(folder, config, backbone, self.recogniser)
        self._score_threshold = config.score_threshold

    def begin(self, maps: NDArray[np.float32], branch: str) -> NDArray[np.float32]:
        """See `Seeker.begin`."""
        self._code = self.recogniser.encode_target(maps)
        self.criterion = self.known.criterion(self._code[0], branch)
        return pooled_middle(maps)

    def look(self, maps: NDArray[np.float32]) -> Sight:
        """See `Seeker.look`."""
        scores, boxes = self.recogniser.detect(maps, self._code)
        if scores[0] < self._score_threshold:
            return Sight(None, False)
        detection = Detection(float(scores[0]), boxes[0])
        return Sight(detection, bool(self.criterion.met(detection.score, detection.area)))


class ViewSeeker:
    """Looks for the place from where a picture was taken: a view that is as good as the picture means found."""

    files: ClassVar[tuple[str, ...]] = ()

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone) -> None:
        self._found_similarity = config.found_similarity

    def begin(self, maps: NDArray[np.float32], branch: str) -> NDArray[np.float32]:
        """See `Seeker.begin`."""
        target = pooled(maps)  # as views are, for the picture is one
        self._target = unit_vectors(target[0])
        return target

    def look(self, maps: NDArray[np.float32]) -> Sight:
        """See `Seeker.look`; nothing is ever detected."""
        similarity = float(unit_vectors(pooled(maps)[0]) @ self._target)
        return Sight(None, similarity >= self._found_similarity)


SEEKERS: dict[SearchKind, type[Seeker]] = {"object": ObjectSeeker, "view": ViewSeeker}
