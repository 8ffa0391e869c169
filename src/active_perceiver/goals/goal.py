"""What a goal is to the agent: something to look for in images, and what is seen of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.config import AgentConfig
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
