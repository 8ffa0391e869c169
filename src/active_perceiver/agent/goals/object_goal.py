"""The object in a picture as a goal: the recogniser draws a box, and one that is large enough means found."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.config import AgentConfig
from active_perceiver.agent.found_criterion import FoundCriterion
from active_perceiver.agent.goals.goal import CardWords, Goal, GoalObservation
from active_perceiver.agent.target_matching import RECOGNISER_FILE, TargetGallery
from active_perceiver.recognition.recogniser import Detection, Recogniser
from active_perceiver.vision.backbone import Backbone, pooled_middle


def observe_goal(
    score: float, box: NDArray[np.floating], threshold: float, criterion: FoundCriterion
) -> GoalObservation:
    """What an agent that searches for an object makes of what its recogniser says of an image.

    Args:
        score: presence probability.
        box: (4,) where the object would be.
        threshold: presence probability from which on it counts as seen.
        criterion: when it says found.
    """
    if score < threshold:
        return GoalObservation(None, found=False, nearly=False)
    seen = Detection(score, box)
    met, nearly = (bool(check(seen.score, seen.area)) for check in (criterion.met, criterion.nearly_met))
    return GoalObservation(seen, found=met, nearly=nearly)


@dataclass(frozen=True, eq=False)
class ObjectGoal:
    """The object that one search looks for; see `SearchGoal`.

    Attributes:
        recogniser: draws the boxes.
        embedding: (1, C) float32, by which it knows the object.
        target: (1, D) float32, what the policy is shown of it.
        score_threshold: presence probability from which on it counts as seen.
        criterion: when the search is told that it is found.
    """

    recogniser: Recogniser
    embedding: NDArray[np.float32]
    target: NDArray[np.float32]
    score_threshold: float
    criterion: FoundCriterion

    def observe(self, maps: NDArray[np.float32]) -> GoalObservation:
        """See `SearchGoal.observe`."""
        scores, boxes = self.recogniser.detect(maps, self.embedding)
        return observe_goal(float(scores[0]), boxes[0], self.score_threshold, self.criterion)


class ObjectDetector:
    """Looks for the object in a picture: its recogniser draws a box, and a box that is large enough means found.

    A picture of a known target, however it was taken, is taken for the picture of that target which it is most like:
    with the ones they were trained with, recogniser and policy work best.

    Attributes:
        recogniser: draws the boxes.
        gallery: the targets the agent was trained for.
    """

    files: ClassVar[tuple[str, ...]] = (RECOGNISER_FILE,)

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, threads: int | None) -> None:
        self.recogniser = Recogniser(folder / RECOGNISER_FILE, threads)
        self.gallery = TargetGallery(folder, config, backbone, self.recogniser)
        self._score_threshold = config.score_threshold

    def begin(self, maps: NDArray[np.float32], branch: str) -> ObjectGoal:
        """See `GoalDetector.begin`."""
        embedding = self.recogniser.encode_target(maps)
        match = self.gallery.match(embedding[0], branch)
        if match is None:
            target = pooled_middle(maps)
        else:
            known = self.gallery.pictures(match.target)
            embedding, target = known.embeddings[[match.picture]], known.features[[match.picture]]
        return ObjectGoal(self.recogniser, embedding, target, self._score_threshold, self.gallery.criterion(match))


OBJECT = Goal(
    name="object",
    detector=ObjectDetector,
    has_boxes=True,
    default_reward=None,
    words=CardWords(
        tags="active-perception, object-search, visual-navigation",
        searched="an object",
        arrived="in front of the object",
        picture="mug.jpg",
        right="if its box is on the object (IoU at least 0.5)",
    ),
)
"""The object in a picture, as in the paper."""
