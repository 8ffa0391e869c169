"""A search with all that belongs to it: agent and robot are made from their names, and what is seen is recorded."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.live import StepRecord, search
from active_perceiver.live.config import SessionConfig
from active_perceiver.live.recorder import Recorder, check_folder
from active_perceiver.live.recording import Recording
from active_perceiver.live.recording_header import Floor, RecordingHeader
from active_perceiver.live.robot_factory import Place, robot_at
from active_perceiver.scenes import Action, read_image
from active_perceiver.version import __version__


class Session:
    """One search, ready to run.

    Args:
        agent_folder: of the agent.
        picture: file that shows what is searched.
        config: the robot, limits, and what else can be chosen.
        force: replace a recording that is there.

    Attributes:
        header: what the search is asked to do, and where.
        kept: number of looks that are in the recording so far.

    Raises:
        UserError: if the picture, the agent, the robot, a limit or a folder are not what they should be.
    """

    def __init__(self, agent_folder: Path, picture: Path, config: SessionConfig, *, force: bool = False) -> None:
        self._image = read_image(picture)
        config.check_limits()
        if config.record is not None:
            check_folder(config.record, force)
        self._agent = ActivePerceiver.from_pretrained(
            agent_folder, config.threads, confirm=config.confirm, explore=config.explore
        )
        self._config, self._force = config, force
        self._place = robot_at(config.robot, self._actions_in, config.start, config.seed, config.robot_config)
        if config.scene is None and self._place.name in self._agent.config.branches:
            self._config = replace(config, scene=self._place.name)
        self.header = _header(agent_folder, picture, self._config, self._place, self._actions_in(self._place.name))
        self.kept = 0

    def run(self, on_step: Callable[[int, StepRecord], None] | None = None) -> Recording:
        """Search, and keep each look if a folder for a recording is given.

        Args:
            on_step: called after every look, once it is kept, see `search`.

        Returns:
            What was asked and what was seen and done; its `record` says whether the agent found what it searched for.

        Raises:
            UserError: if the robot cannot go on or a recording cannot be written.
        """
        folder = self._config.record
        with self._place.robot as robot, ExitStack() as stack:
            recorder = None
            if folder is not None:
                recorder = stack.enter_context(Recorder(folder, self.header, self._image, force=self._force))

            def looked(number: int, step_record: StepRecord) -> None:
                if recorder is not None:
                    recorder.keep(step_record)
                    self.kept = recorder.looks
                if on_step is not None:
                    on_step(number, step_record)

            done = search(self._agent, robot, self._image, self._config, looked)
            if recorder is not None:
                recorder.end(done)
        return Recording(self.header, done)

    def _actions_in(self, name: str) -> tuple[Action, ...]:
        """Those of the policy branch that will be used in a scene; `search` refuses a branch that there is not."""
        branches = self._agent.config.branches
        chosen = self._config.scene or name
        return self._agent.config.actions(chosen if chosen in branches else next(iter(branches)))


def _header(
    agent_folder: Path, picture: Path, config: SessionConfig, place: Place, actions: tuple[Action, ...]
) -> RecordingHeader:
    return RecordingHeader(
        picture=picture.name, agent=str(agent_folder), robot=config.robot, place=place.name, start=place.start,
        scene=config.scene, actions=actions, max_steps=config.max_steps, max_minutes=config.max_minutes,
        seed=config.seed, confirm=config.confirm, explore=config.explore, dry_run=config.dry_run,
        started=datetime.now().astimezone().isoformat(timespec="seconds"), software=__version__,
        floor=None if place.scene is None else Floor.of(place.scene),
    )  # fmt: skip
