"""What one sees of a search as it runs: a view that a terminal draws anew, or a line for each look."""

from __future__ import annotations

import time

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from active_perceiver.live import StepRecord
from active_perceiver.live.recording_header import RecordingHeader

LAST_LOOKS = 6
BAR = 28


def step_line(setup: RecordingHeader, number: int, step_record: StepRecord) -> str:
    """One line for a look."""
    detection = step_record.step.detection
    seen = "-" if detection is None else f"{detection.score:.2f}, {100 * detection.area:.1f} % of the view"
    return f"{number:>4}  sees {seen:<26} {_decision(setup, step_record)}"


def _decision(setup: RecordingHeader, step_record: StepRecord) -> str:
    word = "found" if step_record.step.found else step_record.step.action.value
    if setup.dry_run:
        return f"would say {word}" if step_record.step.found else f"would {word}"
    return word


def announcement(setup: RecordingHeader) -> str:
    """What is going to be done, in one line."""
    most = f"at most {setup.max_steps} {'looks, without moving' if setup.dry_run else 'actions'}"
    return f"searching for {setup.picture} in {setup.place}, from {setup.start}, {most}"


class LiveView:
    """The state of a search as a terminal shows it.

    Args:
        setup: what the search is asked to do.
    """

    def __init__(self, setup: RecordingHeader) -> None:
        self._setup = setup
        self._started = time.monotonic()
        self._looks: tuple[tuple[int, StepRecord], ...] = ()

    def looked(self, number: int, step_record: StepRecord) -> None:
        """Note a look and how many there were before."""
        self._looks = (*self._looks, (number, step_record))[-LAST_LOOKS:]

    def rendered(self) -> RenderableType:
        """The view as it is now."""
        setup = self._setup
        title = Text(f"searching for {setup.label} in {setup.place}{' (dry run)' if setup.dry_run else ''}")
        looks = self._looks  # all at once, because another thread draws
        parts: list[RenderableType] = [self._limits(looks)]
        if looks:
            parts += [
                _goal_observation(setup, looks[-1][1]),
                _decisions(setup, looks[-1][1]),
                _last_looks(setup, looks),
            ]
        else:
            parts.append(Text("waiting for the first look", style="dim"))
        return Panel(Group(*parts), title=title, title_align="left", expand=False, width=78)

    def _limits(self, looks: tuple[tuple[int, StepRecord], ...]) -> Table:
        setup = self._setup
        count = 0 if not looks else looks[-1][0] + setup.dry_run
        minutes, most = (time.monotonic() - self._started) / 60, setup.max_minutes
        table = _grid()
        table.add_row(
            "looks" if setup.dry_run else "actions", _bar(count / setup.max_steps, "blue"),
            f"{count} of {setup.max_steps}",
        )  # fmt: skip
        limit = "" if most == float("inf") else f" of {_clock(most)}"
        table.add_row("time", _bar(minutes / most, "blue"), f"{_clock(minutes)}{limit}")
        return table


def _clock(minutes: float) -> str:
    whole = int(60 * minutes)
    return f"{whole // 60}:{whole % 60:02}"


def _bar(share: float, colour: str) -> ProgressBar:
    return ProgressBar(total=1.0, completed=share, width=BAR, complete_style=colour, finished_style=colour)


def _grid() -> Table:
    table = Table.grid(padding=(0, 2))
    table.add_column(width=15)
    table.add_column(width=BAR)
    table.add_column()
    return table


def _goal_observation(setup: RecordingHeader, step_record: StepRecord) -> Table:
    detection = step_record.step.detection
    table = _grid()
    score = 0.0 if detection is None else detection.score
    table.add_row("confidence", _bar(score, "green"), "sees nothing" if detection is None else f"{score:.2f}")
    area = 0.0 if detection is None else detection.area
    table.add_row("area of the box", _bar(area, "green"), "-" if detection is None else f"{100 * area:.1f} %")
    table.add_row("moved", "", _moved(step_record))
    word = Text(_decision(setup, step_record), style="bold green" if step_record.step.found else "bold")
    table.add_row("now", "", word)
    return table


def _moved(step_record: StepRecord) -> Text:
    return {True: Text("yes"), False: Text("no, blocked", style="yellow"), None: Text("-")}[step_record.robot_moved]


def _decisions(setup: RecordingHeader, step_record: StepRecord) -> Table:
    table = _grid()
    for action, share in zip(setup.actions, step_record.step.probabilities.tolist(), strict=True):
        chosen = action == step_record.step.action and not step_record.step.found
        table.add_row(
            Text(action.value, style="bold" if chosen else ""), _bar(share, "magenta"), f"{100 * share:.0f} %"
        )
    return table


def _last_looks(setup: RecordingHeader, looks: tuple[tuple[int, StepRecord], ...]) -> Table:
    table = Table(box=None, padding=(0, 2), header_style="dim")
    for name in ("look", "confidence", "area", "moved", "decided"):
        table.add_column(name, justify="left" if name == "decided" else "right")
    for number, step_record in looks:
        detection = step_record.step.detection
        seen = ("-", "-") if detection is None else (f"{detection.score:.2f}", f"{100 * detection.area:.1f} %")
        table.add_row(str(number), *seen, _moved(step_record), _decision(setup, step_record))
    return table
