"""The `search` command: one search, live, shown and recorded while it goes on."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from datetime import datetime
from pathlib import Path
from types import FrameType

from active_perceiver import __version__
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.live import StepRecord, search
from active_perceiver.live.config import Floor, RecordingHeader
from active_perceiver.live.recorder import Recorder, check_folder
from active_perceiver.live.recording import Recording
from active_perceiver.live.robot_factory import robot_at
from active_perceiver.live.search_loop import check_limits
from active_perceiver.live.terminal_view import watching
from active_perceiver.scenes import Action, read_image
from active_perceiver.utils.progress import console


def search_command(
    agent_folder: Path,
    picture: Path,
    robot: str,
    *,
    robot_config: str | None = None,
    start: int | None = None,
    scene: str | None = None,
    max_steps: int = 200,
    max_minutes: float = 10.0,
    seed: int | None = None,
    threads: int | None = None,
    confirm: bool = False,
    explore: bool = True,
    dry_run: bool = False,
    record: Path | None = None,
    force: bool = False,
) -> Recording:
    """Search, show each step, and keep it if a folder for a recording is given.

    Args:
        agent_folder: of the agent.
        picture: file that shows what is searched.
        robot: kind and name, see `robot_at`, as `robot_config` and `start`.
        robot_config: settings of a ros robot.
        start: state in which the robot begins.
        scene: policy branch; that of the scene or room if not given.
        max_steps: most actions; of a dry run, looks.
        max_minutes: most minutes.
        seed: the start and the agent's draws follow from it.
        threads: of the agent, see `ActivePerceiver.from_pretrained`, as `confirm` and `explore`.
        confirm: whether two views have to agree for found.
        explore: whether to look round the room when the policy leads in circles.
        dry_run: only look and decide.
        record: folder of the recording.
        force: replace a recording that is there.

    Returns:
        What was asked and what was seen and done; its `record` says whether the agent found what it searched for.

    Raises:
        UserError: if the picture, the agent, the robot, a limit or a folder are not what they should be.
    """
    image = read_image(picture)
    check_limits(max_steps, max_minutes)
    if record is not None:
        check_folder(record, force)
    agent = ActivePerceiver.from_pretrained(agent_folder, threads, confirm=confirm, explore=explore)

    def actions_in(name: str) -> tuple[Action, ...]:
        """Those of the policy branch that will be used there; `search` refuses one that there is not."""
        branches = agent.config.branches
        chosen = scene or name
        return agent.config.actions(chosen if chosen in branches else next(iter(branches)))

    place = robot_at(robot, actions_in, start, seed, robot_config)
    if scene is None and place.name in agent.config.branches:
        scene = place.name
    setup = RecordingHeader(
        picture=picture.name, agent=str(agent_folder), robot=robot, place=place.name, start=place.start,
        scene=scene, actions=actions_in(place.name), max_steps=max_steps, max_minutes=max_minutes, seed=seed,
        confirm=confirm, explore=explore, dry_run=dry_run,
        started=datetime.now().astimezone().isoformat(timespec="seconds"), software=__version__,
        floor=None if place.scene is None else Floor.of(place.scene),
    )  # fmt: skip
    with ExitStack() as stack:
        stack.enter_context(stopped_like_interrupted())
        driven = stack.enter_context(place.robot)
        print(_announced(setup))
        recorder = None
        if record is not None:
            recorder = stack.enter_context(Recorder(record, setup, image, force=force))
            stack.enter_context(_saying_where(recorder))
        watch = stack.enter_context(watching(setup))

        def looked(number: int, step_record: StepRecord) -> None:
            if recorder is not None:
                recorder.keep(step_record)
            watch(number, step_record)

        done = search(
            agent, driven, image, scene=scene, max_steps=max_steps, max_minutes=max_minutes, seed=seed,
            dry_run=dry_run, on_step=looked,
        )  # fmt: skip
        if recorder is not None:
            recorder.end(done)
    return Recording(setup, done)


def _announced(setup: RecordingHeader) -> str:
    most = f"at most {setup.max_steps} {'looks, without moving' if setup.dry_run else 'actions'}"
    return f"searching for {setup.picture} in {setup.place}, from {setup.start}, {most}"


@contextmanager
def stopped_like_interrupted() -> Iterator[None]:
    """Take a request to end for Ctrl-C: the robot is stopped on the way out, and the recording says why.

    The end of the terminal is one too, but not under `nohup`.
    """

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    signals = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    heard = [number for number in signals if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, interrupt) for number in heard}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _saying_where(recorder: Recorder) -> Iterator[None]:
    """Say where a search is kept that does not end by itself."""
    try:
        yield
    except BaseException:
        if recorder.looks:
            folder = recorder.folder
            console.print(
                f"what was seen until then is kept in {folder}; `active-perceiver report {folder}` shows it",
                highlight=False, markup=False, soft_wrap=True,
            )  # fmt: skip
        raise
