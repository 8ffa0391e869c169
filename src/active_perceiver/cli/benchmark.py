"""The commands `active-perceiver benchmark ...`: how fast and how good it is on this machine, measured in one run.

As in `cli/main.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from tyro.conf import OmitArgPrefixes, Positional, subcommand

from active_perceiver.benchmarks.config import EnvSpeedConfig, RenderSpeedConfig
from active_perceiver.cli.benchmark_agents import AgentBenchmark
from active_perceiver.cli.benchmark_training import TrainingBenchmark
from active_perceiver.cli.help import help_text
from active_perceiver.cli.outputs import Outputs, print_benchmark


@dataclass
class BenchmarkRender:
    """How long rooms take to make, to light and to photograph, and where the time goes."""

    layouts: Positional[tuple[str, ...]] = ()
    """Kinds of rooms; all if not given."""
    settings: OmitArgPrefixes[RenderSpeedConfig] = field(default_factory=RenderSpeedConfig)
    out: Path | None = None
    """Write the result here, as JSON."""
    force: bool = False
    """Replace an existing file."""

    def run(self) -> int:
        from active_perceiver.benchmarks.render.measure import RenderBenchmark

        outputs = Outputs(out=self.out, force=self.force)
        return print_benchmark(RenderBenchmark(self.layouts, self.settings), outputs)


@dataclass
class BenchmarkEnv(Outputs):
    """Environment steps per second."""

    settings: OmitArgPrefixes[EnvSpeedConfig] = field(default_factory=EnvSpeedConfig)

    def run(self) -> int:
        from active_perceiver.benchmarks.env.measure import EnvBenchmark

        return print_benchmark(EnvBenchmark(self.settings), self)


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
