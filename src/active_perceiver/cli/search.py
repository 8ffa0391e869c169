"""The command `active-perceiver search`: shows a search as it goes on, and how it ended."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import OmitArgPrefixes, Positional, subcommand

from active_perceiver.cli.help import help_text
from active_perceiver.cli.interrupts import stopped_like_interrupted
from active_perceiver.cli.report import print_report
from active_perceiver.live.config import SessionConfig
from active_perceiver.utils.progress import console

if TYPE_CHECKING:
    from rich.console import Console

    from active_perceiver.live import StepRecord
    from active_perceiver.live.recording import Recording
    from active_perceiver.live.recording_header import RecordingHeader
    from active_perceiver.live.session import Session


@dataclass
class Search:
    """Search for the object in a picture."""

    agent: Positional[Path]
    """Folder of the agent."""
    picture: Path
    """Picture of the object on its own, or of the view if the agent searches for views; any image file."""
    settings: OmitArgPrefixes[SessionConfig]
    out: Path | None = None
    """Write search.mp4, report.html, path.png, final.png and search.json into this folder."""
    force: bool = False
    """Replace a recording and a report that are in these folders."""

    def run(self) -> int:
        from active_perceiver.live.recorder import check_folder
        from active_perceiver.live.session import Session
        from active_perceiver.live.terminal_view import announcement
        from active_perceiver.reports.search_report import check_report, verdict

        if self.settings.record is not None:
            check_folder(self.settings.record, self.force)
        if self.out is not None:
            check_report(self.out, self.force)
        session = Session(self.agent, self.picture, self.settings, force=self.force)
        print(announcement(session.header))
        recording = self._watched(session)
        print(verdict(recording.record))
        folder = self.settings.record
        if folder is not None:
            print(f"recorded in {folder}; `active-perceiver report {folder}` makes a video and a page of it")
        if self.out is not None:
            print_report(recording, self.out)
        return 0 if recording.record.found or self.settings.dry_run else 1

    def _watched(self, session: Session) -> Recording:
        """Run a search and show it; of one that does not end by itself, say where it is kept."""
        try:
            with stopped_like_interrupted(), watching(session.header) as watch:
                return session.run(watch)
        except BaseException:
            if session.kept:
                folder = self.settings.record
                console.print(
                    f"what was seen until then is kept in {folder}; `active-perceiver report {folder}` shows it",
                    highlight=False, markup=False, soft_wrap=True,
                )  # fmt: skip
            raise


@contextmanager
def watching(header: RecordingHeader, terminal: Console | None = None) -> Iterator[Callable[[int, StepRecord], None]]:
    """Show a search on standard output while the block runs, in a way that suits it.

    Args:
        header: what the search is asked to do.
        terminal: another output, for tests.

    Yields:
        What to call after every look, see `search`.
    """
    from rich.console import Console
    from rich.live import Live

    from active_perceiver.live.terminal_view import LiveView, step_line

    # Not rich's own answer: an environment variable that asks for colours makes no terminal of a file.
    if terminal is None and sys.stdout.isatty():
        terminal = Console()
    if terminal is None or terminal.is_dumb_terminal:
        yield lambda number, step_record: print(step_line(header, number, step_record), flush=True)
        return
    view = LiveView(header)
    # Drawn by a thread of its own, and once more at the end, so that the search does not wait for it.
    with Live(get_renderable=view.rendered, console=terminal, refresh_per_second=8):
        yield view.looked


SearchCommand = Annotated[
    Search,
    subcommand(
        "search",
        description=help_text(
            "Search for what a picture shows; exit code 1 if it was not found.",
            "search kitchen_agent --picture mug.jpg --robot scene:kitchen_1",
            "search kitchen_agent --picture mug.jpg --robot scene:kitchen_1 --out run --seed 7",
            "search kitchen_agent --picture mug.jpg --robot room:kitchen_1_hour_dusk --record run",
            "search agent --picture mug.jpg --robot ros:ws://HOST:9090 --robot-config robot.yaml --dry-run",
            "search agent --picture mug.jpg --robot ros:ws://HOST:9090 --robot-config robot.yaml --record run",
        ),
    ),
]
