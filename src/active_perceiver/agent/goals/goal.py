"""What a goal is: a kind of thing that agents search for, and what each part of the software has to know of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.config import AgentConfig, GoalName
from active_perceiver.agent.found_criterion import FoundCriterion
from active_perceiver.recognition.recogniser import Detection
from active_perceiver.vision.backbone import Backbone


@dataclass(frozen=True)
class GoalObservation:
    """What an agent makes of one image, apart from what to do next.

    Attributes:
        detection: where it sees the target, or None if it does not.
        found: this image says that it is in front of the target.
        nearly: this image says that it is nearly there, see `FoundCriterion.nearly_met`.
    """

    detection: Detection | None
    found: bool
    nearly: bool


class SearchGoal(Protocol):
    """What one search looks for."""

    @property
    def target(self) -> NDArray[np.float32]:
        """(1, D) float32, what the policy is shown of it."""

    @property
    def criterion(self) -> FoundCriterion | None:
        """When its box is enough to say found; None if it has no box."""

    def observe(self, maps: NDArray[np.float32]) -> GoalObservation:
        """Look at an image with these (1, C, h, w) maps."""


class GoalDetector(Protocol):
    """What is different between agents that search for different things.

    Attributes:
        files: what it needs of an agent's folder, besides the policy.
    """

    files: ClassVar[tuple[str, ...]]

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, threads: int | None) -> None:
        """Load what it needs; what runs, runs on so many CPU threads, None for one per core."""

    def begin(self, maps: NDArray[np.float32], branch: str) -> SearchGoal:
        """Begin a search in a scene for what a picture with these (1, C, h, w) maps shows."""


@dataclass(frozen=True)
class CardWords:
    """What the card of an agent says differently for each kind of goal.

    Attributes:
        tags: of the Hugging Face Hub.
        searched: what its picture shows.
        arrived: where it says found.
        picture: a name for the picture's file.
        right: when a "found" is true.
    """

    tags: str
    searched: str
    arrived: str
    picture: str
    right: str


@dataclass(frozen=True)
class Goal:
    """A kind of thing that agents search for.

    All that differs between kinds is here, or in a file that is named after the kind:
    `training/object_pipeline.py` and `view_pipeline.py`, `evaluation/object_measures.py` and `view_measures.py`.

    Attributes:
        name: as `--task` and an agent's configuration have it.
        detector: how it is seen, at run time.
        has_boxes: whether it is an object, which a recogniser draws a box on; then a second view can confirm it, and
            an agent keeps what its networks make of its targets' pictures.
        default_reward: what a policy is paid for if nobody says it; None for the learner's own default.
        words: of the agent's card.
    """

    name: GoalName
    detector: type[GoalDetector]
    has_boxes: bool
    default_reward: str | None
    words: CardWords
