"""One search under way: from an image to an action, with all that the agent remembers of the search."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.controller import SearchController
from active_perceiver.agent.exploration import ViewMap
from active_perceiver.agent.goals.goal import SearchGoal
from active_perceiver.agent.search_policy import Observation
from active_perceiver.agent.visit_memory import ViewFeatures
from active_perceiver.recognition.recogniser import Detection
from active_perceiver.scenes import Action, decode_image
from active_perceiver.utils.sections import section
from active_perceiver.vision.backbone import Backbone, pooled


@dataclass(frozen=True)
class Step:
    """What the agent makes of one image.

    Attributes:
        action: what to do next; meaningless once found.
        detection: where it sees the target, or None if it does not.
        probabilities: (A,) float64, from which the action was drawn, in the order of `ActivePerceiver.actions`: the
            policy's, flattened where the search has been before (see `escape_loop`), or 1 for one action if the
            search is lost and the room explored (see `Explorer`).
        found: its own word that it is in front of the target.
    """

    action: Action
    detection: Detection | None
    probabilities: NDArray[np.float64]
    found: bool


class ActiveSearch:
    """A search for what one picture shows; `ActivePerceiver.search` begins one.

    Args:
        backbone: makes features of images.
        goal: what is searched for.
        controller: decides; it is at its beginning.
        actions: in the order of the policy's outputs.
        room: what the agent remembers of where it searches, if it does.

    Attributes:
        goal: the same.
        actions: the same.
    """

    def __init__(
        self,
        backbone: Backbone,
        goal: SearchGoal,
        controller: SearchController,
        actions: tuple[Action, ...],
        room: ViewMap | None,
    ) -> None:
        self.actions = actions
        self.goal = goal
        self._backbone = backbone
        self._controller = controller
        self._room = room

    def act(self, image: NDArray[np.uint8] | bytes, robot_moved: bool | None = None) -> Step:
        """Look at one image and decide; see `ActivePerceiver.act`."""
        if isinstance(image, bytes):
            with section("decoding"):
                image = decode_image(image, "the robot's image", self._backbone.image_size)
        with section("backbone"):
            maps = self._backbone.maps([image])
        with section("recogniser"):
            goal = self.goal.observe(maps)
        view = ViewFeatures.of(pooled(maps)[0], self._room)
        decision = self._controller.step(Observation(goal, view, robot_moved))
        return Step(self.actions[decision.action], goal.detection, decision.probabilities, decision.found)
