"""What a robot is to the search: something that can look and act."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

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

    def do(self, action: Action) -> bool:
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
