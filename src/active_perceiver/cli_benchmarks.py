"""The commands `active-perceiver benchmark ...`: how fast it is on this machine, measured in one run."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import OmitArgPrefixes, Positional, subcommand

from active_perceiver.cli_scenes import help_text
from active_perceiver.experiments.benchmarks.settings import ActSpeedSettings


@dataclass
class BenchmarkRender:
    """How long rooms take to make, to light and to photograph, and where the time goes."""

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


@dataclass
class BenchmarkEnv:
    """Environment steps per second."""

    scene: str = "kitchen_1"
    """Where to search, a bundled name or a file."""
    seconds: float = 3.0
    """How long to measure each environment."""
    counts: tuple[int, ...] = (1, 16, 64, 256, 1024)
    """Numbers of searches side by side."""
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.env_speed import env_speed_command

        env_speed_command(self.scene, self.seconds, self.counts, self.out, self.picture, force=self.force)
        return 0


@dataclass
class BenchmarkAct:
    """How long one action takes, from an encoded picture to the command."""

    settings: OmitArgPrefixes[ActSpeedSettings] = field(default_factory=ActSpeedSettings)
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.act_speed import act_speed_command

        act_speed_command(self.settings, self.out, self.picture, force=self.force)
        return 0


BenchmarkCommand = (
    Annotated[
        BenchmarkRender,
        subcommand(
            "render",
            description=help_text(
                "How long rooms take to make, to light and to photograph, and where the time goes; on one core.",
                "benchmark render",
                "benchmark render kitchen --views 24 --out render.json",
            ),
        ),
    ]
    | Annotated[
        BenchmarkEnv,
        subcommand(
            "env",
            description=help_text(
                "Environment steps per second: one search, many side by side, and the bare stepping that PPO trains "
                "on; random actions, one process.",
                "benchmark env",
                "benchmark env --scene living_room_1 --out env.json --picture env.png",
            ),
        ),
    ]
    | Annotated[
        BenchmarkAct,
        subcommand(
            "act",
            description=help_text(
                "How long one action takes, from an encoded picture to the command, by parts; the cold start and the "
                "memory; torch beside it if it is installed.",
                "benchmark act",
                "benchmark act --agent kitchen_agent --threads 2 --out act.json --picture act.png",
            ),
        ),
    ]
)


@dataclass
class Benchmark:
    """How fast it is on this machine."""

    command: BenchmarkCommand

    def run(self) -> int:
        return self.command.run()


def _count(report: Any, before: int, total: int, done: int, _: int, note: str = "") -> None:
    report(before + done, total, note)


def _time_room(views: int, job: tuple[str, int]) -> dict[str, Any]:
    from active_perceiver.rooms.capturing.capture_settings import DEFAULT_SETTINGS
    from active_perceiver.rooms.engine.timing import measure_rendering
    from active_perceiver.rooms.layouts import make_room

    layout, _ = job
    return measure_rendering(lambda: make_room(*job), views, settings=DEFAULT_SETTINGS.get(layout))
