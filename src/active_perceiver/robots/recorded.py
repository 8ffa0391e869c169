"""A robot in a recorded Scene: it sees the scene's views and moves along its transitions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.robots.robot import StopOnExit, check_action
from active_perceiver.scenes import Action, Scene


class RecordedRobot(StopOnExit):
    """Walks a scene state by state, as in the paper's simulation (section IV-A).

    Attributes:
        scene: where it is.
        state: the state it is in.
    """

    def __init__(self, scene: Scene, start: int | None = None, seed: int | None = None) -> None:
        """Put the robot into a scene.

        Args:
            scene: where to walk.
            start: the first state; a random one if not given.
            seed: seed of that random choice.

        Raises:
            UserError: if the start is not one of the scene's states.
        """
        if start is None:
            start = int(np.random.default_rng(seed).integers(len(scene)))
        if not 0 <= start < len(scene):
            raise UserError(f"scene '{scene.name}' has states 0 to {len(scene) - 1}; there is no state {start}")
        self.scene = scene
        self.state = start

    @property
    def actions(self) -> tuple[Action, ...]:
        """The scene's actions."""
        return self.scene.actions

    def look(self) -> NDArray[np.uint8]:
        """The view of the current state."""
        return self.scene.view(self.state)

    def execute(self, action: Action) -> bool:
        """Move along the transitions; a blocked move leaves the state as it is.

        Returns:
            Whether the state changed.

        Raises:
            UserError: if the scene does not know the action.
        """
        check_action(action, self.actions)
        before = self.state
        self.state = int(self.scene.transitions[before, self.actions.index(action)])
        return self.state != before

    def pose(self) -> tuple[float, float, float, float]:
        """The current state's pose."""
        x, z, heading, tilt = (float(value) for value in self.scene.poses[self.state])
        return x, z, heading, tilt

    def stop(self) -> None:
        """Nothing moves in a recording."""
