"""The search loop: look, decide, act, until the agent says found or a limit is reached."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.perceiver import ActivePerceiver, Step
from active_perceiver.robots.robot import Robot


@dataclass(frozen=True)
class Glimpse:
    """One moment of a search.

    Attributes:
        image: (H, W, 3) uint8 RGB, what the robot saw.
        pose: where it stood, if it knows.
        step: what the agent made of it.
    """

    image: NDArray[np.uint8] = field(repr=False)
    pose: tuple[float, float, float, float] | None
    step: Step


@dataclass(frozen=True)
class SearchRecord:
    """A finished search.

    Attributes:
        picture: (H, W, 3) uint8 RGB, what was searched.
        glimpses: every look in order; the last one is where the search ended.
        found: whether the agent says that it found the object; if not, a limit was reached.
        seconds: wall time.
    """

    picture: NDArray[np.uint8] = field(repr=False)
    glimpses: tuple[Glimpse, ...] = field(repr=False)
    found: bool
    seconds: float

    @property
    def actions(self) -> int:
        """Number of actions carried out."""
        return len(self.glimpses) - 1


def search(
    agent: ActivePerceiver,
    robot: Robot,
    picture: NDArray[np.uint8],
    *,
    branch: str | None = None,
    max_steps: int = 200,
    max_seconds: float = float("inf"),
    seed: int | None = None,
    on_glimpse: Callable[[int, Glimpse], None] | None = None,
) -> SearchRecord:
    """Search for the object in a picture.

    The robot is stopped when the search ends, also by an exception or Ctrl-C.

    Args:
        agent: decides.
        robot: looks and acts.
        picture: (H, W, 3) uint8 RGB, the object on its own.
        branch: the scene whose policy branch to use; needed only if the agent has several.
        max_steps: give up after so many actions.
        max_seconds: give up after so much time.
        seed: the agent's draws of actions follow from it.
        on_glimpse: called after every look with the number of actions so far.

    Raises:
        UserError: if the robot's actions are not those the policy was trained for, or the branch is unknown.
    """
    started = time.monotonic()
    glimpses: list[Glimpse] = []
    try:
        agent.reset(picture, scene=branch, seed=seed)
        if tuple(robot.actions) != agent.actions:
            ours, theirs = (", ".join(a.value for a in actions) for actions in (agent.actions, robot.actions))
            raise UserError(f"the policy was trained for the actions {ours}; this robot has {theirs}")
        while True:
            image = robot.look()
            glimpse = Glimpse(image, robot.pose(), agent.act(image))
            glimpses.append(glimpse)
            if on_glimpse is not None:
                on_glimpse(len(glimpses) - 1, glimpse)
            out_of_time = time.monotonic() - started > max_seconds
            if glimpse.step.found or len(glimpses) > max_steps or out_of_time:
                return SearchRecord(picture, tuple(glimpses), glimpse.step.found, time.monotonic() - started)
            robot.do(glimpse.step.action)
    finally:
        robot.stop()
