"""The commands `active-perceiver benchmark ...`: how fast it is on this machine, measured in one run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from tyro.conf import Positional


@dataclass
class Benchmark:
    """How fast it is on this machine."""

    what: Positional[Literal["render"]]
    """What to measure: "render", how long rooms take to make, to light and to photograph, and where the time goes."""
    layouts: Positional[tuple[str, ...]] = ()
    """Kinds of rooms; all if not given."""
    seed: int = 1
    """Which room of each kind."""
    views: int = 12
    """Views to take of each room."""
    out: Path | None = None
    """Write the result here, as JSON."""
    force: bool = False
    """Replace an existing file."""

    def run(self) -> int:
        from active_perceiver.experiments.result import write_result
        from active_perceiver.files import OutputExistsError
        from active_perceiver.progress import progress_bar
        from active_perceiver.rooms.capturing.workers import run_parallel
        from active_perceiver.rooms.engine.timing import format_timing
        from active_perceiver.rooms.layouts import LAYOUTS

        if self.out is not None and self.out.exists() and not self.force:
            raise OutputExistsError(f"{self.out} exists; give another name, or --force to replace it")
        jobs = [(layout, self.seed) for layout in self.layouts or tuple(LAYOUTS)]
        with progress_bar("rooms") as report:
            # One process after the other, each with one thread and nothing cached.
            measured = [
                run_parallel(_time_room, self.views, [job], 1, partial(_count, report, number, len(jobs)))[0]
                for number, job in enumerate(jobs)
            ]
        print("\n\n".join(format_timing(result) for result in measured))
        if self.out is not None:
            protocol = {"cores": 1, "threads": 1, "views": self.views}
            write_result(self.out, "benchmark render", {"protocol": protocol, "rooms": measured})
            print(f"\nresult: {self.out}")
        return 0


def _count(report: Any, before: int, total: int, done: int, _: int, note: str = "") -> None:
    report(before + done, total, note)


def _time_room(views: int, job: tuple[str, int]) -> dict[str, Any]:
    from active_perceiver.rooms.capturing.capture_settings import DEFAULT_SETTINGS
    from active_perceiver.rooms.engine.timing import measure_rendering
    from active_perceiver.rooms.layouts import make_room

    layout, _ = job
    return measure_rendering(lambda: make_room(*job), views, settings=DEFAULT_SETTINGS.get(layout))
