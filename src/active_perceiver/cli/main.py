"""The command line: `active-perceiver ...`, also `python -m active_perceiver`. Each command is a thin shell.

A command is a dataclass whose fields are its arguments, their docstrings the help; `run` does the work. What is
heavy to import is imported there, so that `--help` answers at once.
"""

from __future__ import annotations

import logging
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated

import tyro
from rich.markup import escape
from tyro.conf import subcommand

from active_perceiver.cli.benchmark import Benchmark
from active_perceiver.cli.bridge import BridgeCommand
from active_perceiver.cli.demo import DemoCommand
from active_perceiver.cli.evaluate import EvaluateCommand
from active_perceiver.cli.export import ExportCommand
from active_perceiver.cli.info import InfoCommand
from active_perceiver.cli.pretrain import PretrainCommand
from active_perceiver.cli.report import ReportCommand
from active_perceiver.cli.reproduce import ReproduceCommand
from active_perceiver.cli.scenes import Scenes
from active_perceiver.cli.search import SearchCommand
from active_perceiver.cli.train import TrainCommand
from active_perceiver.errors import UserError
from active_perceiver.utils.progress import console

Command = (
    DemoCommand
    | Annotated[
        Scenes,
        subcommand(
            "scenes",
            description="Scenes: list, info, check, import, export, label, capture, render, preview, elsewhere (each "
            "has its own --help).",
        ),
    ]
    | TrainCommand
    | PretrainCommand
    | EvaluateCommand
    | SearchCommand
    | BridgeCommand
    | ReportCommand
    | ExportCommand
    | Annotated[
        Benchmark,
        subcommand(
            "benchmark",
            description="How fast and how good it is: act, env, export, policies, recogniser, render, robot, "
            "robustness, scale, train (each has its own --help).",
        ),
    ]
    | ReproduceCommand
    | InfoCommand
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: without the program's name; those of the process if not given.

    Returns:
        The exit code: 0 well done, 1 a negative answer (not found, not sound), 2 wrong input, 130 interrupted.
    """
    command = tyro.cli(
        Command,
        prog="active-perceiver",
        description="Give a robot a picture of an object; it searches the room and draws a box on it.",
        args=arguments,
        config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    try:
        with warnings.catch_warnings(), notes_printed():
            # Of EXIF that is corrupt, as some phones write it; an image that cannot be read is an error anyway.
            warnings.filterwarnings("ignore", module=r"PIL\b")
            return command.run()
    except user_errors() as error:
        # A message may hold brackets, as in 'active-perceiver[train]'; they are no markup.
        console.print(f"[bold red]error:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        return 2
    except KeyboardInterrupt:
        console.print(
            "interrupted; what was there before is as it was. `demo`, `train`, `scenes render`, `capture` "
            "and `elsewhere` go on with --resume",
            soft_wrap=True,
        )
        return 130


class _NotePrinter(logging.Handler):
    """Prints what the work has to say beside its results, above the progress bars."""

    def emit(self, record: logging.LogRecord) -> None:
        console.print(record.getMessage(), highlight=False, markup=False, soft_wrap=True)


@contextmanager
def notes_printed() -> Iterator[None]:
    """Print what is logged while a command runs: only the command line prints, the work logs."""
    log, printer = logging.getLogger("active_perceiver"), _NotePrinter()
    before = log.level
    log.addHandler(printer)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.setLevel(before)
        log.removeHandler(printer)


def user_errors() -> tuple[type[Exception], ...]:
    """What ends a command with a sentence: our own errors, and those of the rooms where they have been imported."""
    rooms = sys.modules.get("indoor_rooms.errors")
    return (UserError,) if rooms is None else (UserError, rooms.RoomError)


if __name__ == "__main__":
    sys.exit(main())
