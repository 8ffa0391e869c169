"""A robot that takes several frames for one look, so that what its camera gets wrong differs and averages out."""

from __future__ import annotations

from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from active_perceiver.errors import UserError
from active_perceiver.robots.robot import Robot
from active_perceiver.scenes import Action


class SteadyRobot:
    """Another robot with a steadier eye.

    Args:
        robot: does everything.
        frames: how many it takes for each look; the look is their mean.

    Raises:
        UserError: if there is less than one.
    """

    def __init__(self, robot: Robot, frames: int) -> None:
        if frames < 1:
            raise UserError(f"a look takes at least 1 frame, got {frames}")
        self.robot = robot
        self.frames = frames

    @property
    def actions(self) -> tuple[Action, ...]:
        """The robot's."""
        return self.robot.actions

    def look(self) -> NDArray[np.uint8]:
        """The mean of the frames, (H, W, 3) uint8 RGB."""
        frames = [self.robot.look() for _ in range(self.frames)]
        return np.rint(np.mean(frames, axis=0)).astype(np.uint8) if self.frames > 1 else frames[0]

    def do(self, action: Action) -> bool:
        """See the robot's."""
        return self.robot.do(action)

    def pose(self) -> tuple[float, float, float, float] | None:
        """See the robot's."""
        return self.robot.pose()

    def stop(self) -> None:
        """See the robot's."""
        self.robot.stop()

    def __enter__(self) -> Self:
        self.robot.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.robot.__exit__(kind, error, trace)
