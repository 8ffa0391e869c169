"""The commands `active-perceiver benchmark ...`: how fast and how good it is on this machine, measured in one run.

As in `cli/main.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import Positional, subcommand

from active_perceiver.cli.benchmark_agents import AgentBenchmark
from active_perceiver.cli.benchmark_training import TrainingBenchmark
from active_perceiver.cli.help import help_text
from active_perceiver.cli.outputs import Outputs


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
        from active_perceiver.benchmarks.outputs import check_outputs
        from active_perceiver.benchmarks.render.measure import format_timing
        from active_perceiver.parallel.process_pool import run_parallel
        from active_perceiver.utils.progress import progress_bar
        from active_perceiver.utils.result import write_result
        from indoor_rooms.layouts import LAYOUTS

        check_outputs(self.force, self.out)
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
class BenchmarkEnv(Outputs):
    """Environment steps per second."""

    scene: str = "kitchen_1"
    """Where to search, a bundled name or a file."""
    seconds: float = 3.0
    """How long to measure each environment."""
    counts: tuple[int, ...] = (1, 16, 64, 256, 1024)
    """Numbers of searches side by side."""

    def run(self) -> int:
        from active_perceiver.benchmarks.env.measure import env_speed_command

        env_speed_command(self.scene, self.seconds, self.counts, self.out, self.picture, force=self.force)
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
    | AgentBenchmark
    | TrainingBenchmark
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
    from active_perceiver.benchmarks.render.measure import measure_rendering
    from active_perceiver.capture.rendered.config import DEFAULT_CONFIGS
    from indoor_rooms.layouts import make_room

    layout, _ = job
    return measure_rendering(lambda: make_room(*job), views, settings=DEFAULT_CONFIGS.get(layout))
