"""The search loop: look, decide, act, until the agent says found or a limit is reached."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.live.config import SearchConfig
from active_perceiver.scenes.images import decode_image

if TYPE_CHECKING:  # the command line knows of searches, and answers before what an agent needs is loaded
    from active_perceiver.agent.perceiver import ActivePerceiver, Step
    from active_perceiver.robots.robot import Robot

FOUND, MAX_STEPS, MAX_MINUTES = "found", "max steps", "max minutes"
"""Why a search ended by itself. Recordings know of more reasons."""

DEFAULTS = SearchConfig()


@dataclass(frozen=True)
class StepRecord:
    """One moment of a search.

    Attributes:
        frame: what the robot saw, as the robot gave it: (H, W, 3) uint8 RGB, or an encoded image.
        pose: where it stood, if it knows.
        step: what the agent made of it.
        robot_moved: whether the action before this look moved the robot; None at the first look and in a dry run.
        seconds: since the search began, when the agent had decided.
    """

    frame: NDArray[np.uint8] | bytes = field(repr=False)
    pose: tuple[float, float, float, float] | None
    step: Step
    robot_moved: bool | None = None
    seconds: float = 0.0

    @property
    def image(self) -> NDArray[np.uint8]:
        """What the robot saw, (H, W, 3) uint8 RGB; an encoded frame is decoded each time."""
        return decode_image(self.frame, "the robot's image") if isinstance(self.frame, bytes) else self.frame


@dataclass(frozen=True)
class SearchRecord:
    """A search that has ended.

    Attributes:
        picture: (H, W, 3) uint8 RGB, what was searched.
        step_records: every look in order; the last one is where the search ended.
        found: whether the agent says that it found the object, in a dry run at any look.
        seconds: wall time.
        reason: why it ended: `FOUND`, `MAX_STEPS`, `MAX_MINUTES`, or another that a recording gives.
        dry_run: whether it only looked and decided.
    """

    picture: NDArray[np.uint8] = field(repr=False)
    step_records: tuple[StepRecord, ...] = field(repr=False)
    found: bool
    seconds: float
    reason: str
    dry_run: bool = False

    @property
    def actions(self) -> int:
        """Number of actions carried out."""
        return 0 if self.dry_run else len(self.step_records) - 1

    @property
    def ending(self) -> str:
        """How it ended, in a word or two."""
        if self.dry_run:
            return "end of the dry run"
        if self.found:
            return "found"
        return "not found" if self.reason in (MAX_STEPS, MAX_MINUTES) else self.reason.partition(":")[0]

    def robot_moved(self, look: int) -> bool | None:
        """Whether the action that was chosen at a look moved the robot; None if none followed, or nobody knows."""
        return self.step_records[look + 1].robot_moved if look + 1 < len(self.step_records) else None

    def caption(self, look: int) -> str:
        """What follows from a look, in a few words: an action, or how the search ended."""
        step_record = self.step_records[look]
        if self.dry_run:
            return "would say found" if step_record.step.found else f"would {step_record.step.action.value}"
        if look == len(self.step_records) - 1:
            return self.ending
        return step_record.step.action.value + (", blocked" if self.robot_moved(look) is False else "")


def search(
    agent: ActivePerceiver,
    robot: Robot,
    picture: NDArray[np.uint8],
    config: SearchConfig = DEFAULTS,
    on_step: Callable[[int, StepRecord], None] | None = None,
) -> SearchRecord:
    """Search for the object in a picture.

    The robot is stopped when the search ends, also by an exception or Ctrl-C. In a dry run each look is the first of
    a search, so that a robot that stands still is not taken for one that is caught.

    Args:
        agent: decides.
        robot: looks and acts.
        picture: (H, W, 3) uint8 RGB, the object on its own.
        config: the policy branch, limits, seed, and whether to look only.
        on_step: called after every look with the number of looks before it, before the robot moves on.

    Raises:
        UserError: if the robot's actions are not those the policy was trained for, the branch is unknown, or a limit
            makes no sense.
    """
    started = time.monotonic()
    step_records: list[StepRecord] = []
    robot_moved: bool | None = None
    try:
        config.check_limits()
        agent.reset(picture, scene=config.scene, seed=config.seed)
        if tuple(robot.actions) != agent.actions:
            ours, theirs = (", ".join(a.value for a in actions) for actions in (agent.actions, robot.actions))
            raise UserError(f"the policy was trained for the actions {ours}; this robot has {theirs}")
        while True:
            frame = robot.look()
            pose = robot.pose()
            step = agent.act(frame, robot_moved)
            step_records.append(StepRecord(frame, pose, step, robot_moved, time.monotonic() - started))
            if on_step is not None:
                on_step(len(step_records) - 1, step_records[-1])
            seconds = time.monotonic() - started
            if reason := _reason_to_end(config, step_records, seconds):
                found = any(step_record.step.found for step_record in step_records)
                return SearchRecord(picture, tuple(step_records), found, seconds, reason, config.dry_run)
            if config.dry_run:
                time.sleep(config.dry_pause)
                seed = None if config.seed is None else config.seed + len(step_records)
                agent.reset(picture, scene=config.scene, seed=seed)
            else:
                robot_moved = robot.execute(step.action)
    finally:
        robot.stop()


def _reason_to_end(config: SearchConfig, step_records: Sequence[StepRecord], seconds: float) -> str | None:
    """Why a search ends after its last look; None if it goes on."""
    if step_records[-1].step.found and not config.dry_run:
        return FOUND
    if len(step_records) >= config.max_steps + (not config.dry_run):
        return MAX_STEPS
    return MAX_MINUTES if seconds > 60 * config.max_minutes else None
