"""The command `active-perceiver report`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, subcommand

from active_perceiver.cli.help import help_text

if TYPE_CHECKING:
    from active_perceiver.live.recording import Recording


@dataclass
class Report:
    """A page and a video of a recorded search."""

    recording: Positional[Path]
    """Folder that `search --record` made, also of a search that was interrupted or killed."""
    out: Path | None = None
    """Folder for search.mp4, report.html, path.png, final.png and search.json; the recording's if not given."""
    force: bool = False
    """Replace a report that is there."""

    def run(self) -> int:
        from active_perceiver.live.recording import read_recording
        from active_perceiver.reports.search_report import check_report, verdict

        out = self.out or self.recording
        check_report(out, self.force)
        recording = read_recording(self.recording)
        print(verdict(recording.record))
        print_report(recording, out)
        return 0


def print_report(recording: Recording, out: Path) -> None:
    """Make the report of a search, with a progress bar, and say what was written."""
    from active_perceiver.reports.search_report import write_report
    from active_perceiver.utils.progress import progress_bar

    with progress_bar("video") as report:
        written = write_report(recording, out, report)
    print(f"written into {out}: {', '.join(written)}")


ReportCommand = Annotated[
    Report,
    subcommand(
        "report",
        description=help_text(
            "Make a video and a page of a search that was recorded.", "report run", "report run --out run_report"
        ),
    ),
]
