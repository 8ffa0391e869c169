"""What a robot is to the search: something that can look and act."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.scenes import Action

if TYPE_CHECKING:
    from typing_extensions import Self


@runtime_checkable
class Robot(Protocol):
    """Anything that can look and act. Used as a context manager: leaving it, for whatever reason, stops the robot."""

    @property
    def actions(self) -> tuple[Action, ...]:
        """The actions it can do, in the order of the policy's outputs."""
        ...

    def look(self) -> NDArray[np.uint8]:
        """The camera's current image, (H, W, 3) uint8 RGB."""
        ...

    def execute(self, action: Action) -> bool:
        """Carry out one action and return when it is done.

        Returns:
            Whether the robot moved. An action that is blocked leaves it where it was.
        """
        ...

    def pose(self) -> tuple[float, float, float, float] | None:
        """x, z in metres, heading and tilt in degrees, for figures only; None where the robot does not know."""
        ...

    def stop(self) -> None:
        """Stop all motion at once. Safe to call at any time and more than once."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class StopOnExit:
    """A robot's `with` block: leaving it, for whatever reason, closes the robot, which at the least stops it."""

    def stop(self) -> None:
        """See `Robot.stop`."""
        raise NotImplementedError

    def close(self) -> None:
        """End what the robot needs only while it is used; nothing but its motion, if not said otherwise."""
        self.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def check_action(action: Action, actions: Sequence[Action], kind: type[UserError] = UserError) -> None:
    """Refuse what a robot may not do.

    Args:
        action: what it is to do.
        actions: what it may do.
        kind: of the error.

    Raises:
        UserError: of this kind, if the action is not one of the robot's.
    """
    if action not in actions:
        raise kind(f"this robot has no action {action.value}; it has {', '.join(known.value for known in actions)}")


@runtime_checkable
class NavigatingRobot(Robot, Protocol):
    """A robot that also finds its way to any point of the floor, by its odometry, as far as that can be trusted."""

    @property
    def tilts(self) -> tuple[float, ...]:
        """Degrees, rising, up positive: those that the camera can have."""
        ...

    def go_to(self, x: float, z: float, heading: float, tilt: float) -> bool:
        """Drive straight to a point, turn to a heading, and tilt the camera.

        Args:
            x: metres to the right of where it began, as it looked there.
            z: metres ahead of there.
            heading: degrees clockwise from the one at which it began.
            tilt: degrees, up positive; the nearest of `tilts` is taken.

        Returns:
            Whether it got there. If the way is blocked it is where it was, or as near to there as it can be.
        """
        ...
