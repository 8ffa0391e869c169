"""The commands `active-perceiver benchmark act`, `export`, `robustness` and `robot`: what an agent does.

As in `cli/main.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import OmitArgPrefixes, Positional, subcommand

from active_perceiver.benchmarks.config import (
    ActSpeedConfig,
    ExportBenchmarkConfig,
    RobotBenchmarkConfig,
    RobustnessConfig,
)
from active_perceiver.cli.help import help_text
from active_perceiver.cli.outputs import Outputs, print_benchmark


@dataclass
class BenchmarkAct(Outputs):
    """How long one action takes, from an encoded picture to the command."""

    settings: OmitArgPrefixes[ActSpeedConfig] = field(default_factory=ActSpeedConfig)

    def run(self) -> int:
        from active_perceiver.benchmarks.act.measure import ActBenchmark

        return print_benchmark(ActBenchmark(self.settings), self)


@dataclass
class BenchmarkExport(Outputs):
    """What an exported agent weighs, how fast it starts and acts, and what 8-bit numbers do to it."""

    agent: Positional[Path]
    """Folder of the agent; it is measured in the scenes it was trained in."""
    settings: OmitArgPrefixes[ExportBenchmarkConfig] = field(default_factory=ExportBenchmarkConfig)

    def run(self) -> int:
        from active_perceiver.benchmarks.exported.measure import ExportBenchmark

        return print_benchmark(ExportBenchmark(self.agent, self.settings), self)


@dataclass
class BenchmarkRobustness(Outputs):
    """What becomes of success when an agent sees something else than it was trained on."""

    agent: Positional[Path]
    """Folder of the agent; it is measured in the scenes and with the pictures it was trained with."""
    settings: OmitArgPrefixes[RobustnessConfig] = field(default_factory=RobustnessConfig)
    resume: bool = False
    """Keep what an interrupted run with the same --work has measured."""

    def run(self) -> int:
        from active_perceiver.benchmarks.robustness.measure import RobustnessBenchmark

        return print_benchmark(RobustnessBenchmark(self.agent, self.settings, _render_again, self.resume), self)


@dataclass
class BenchmarkRobot(Outputs):
    """How often a robot that is never quite on the lattice finds its targets."""

    agents: Positional[tuple[Path, ...]]
    """Folders of agents that were trained in the room; the last one is the one that is measured, the others, whose
    policies were shown less in training, are compared with it."""
    settings: OmitArgPrefixes[RobotBenchmarkConfig] = field(default_factory=RobotBenchmarkConfig)
    resume: bool = False
    """Go on after the rows that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.benchmarks.robot.measure import RobotBenchmark

        return print_benchmark(RobotBenchmark(self.agents, self.settings), self, self.resume)


AgentBenchmark = (
    Annotated[
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
    | Annotated[
        BenchmarkExport,
        subcommand(
            "export",
            description=help_text(
                "What an exported agent weighs, how long it takes to the first action where nothing but numpy, "
                "onnxruntime and pillow is installed (which is done, in a temporary folder), how long one action "
                "takes, and how well it searches; with 32-bit numbers and with 8-bit ones.",
                "benchmark export kitchen_agent",
                "benchmark export kitchen_agent --calibrate kitchen_1 --out export.json --picture export.png",
            ),
        ),
    ]
    | Annotated[
        BenchmarkRobustness,
        subcommand(
            "robustness",
            description=help_text(
                "What becomes of success when an agent sees something else than it was trained on: noise, blur, "
                "other light, moved objects, missing and wrong detections. Rooms are rendered again for some of it "
                "(needs the `rooms` extra).",
                "benchmark robustness kitchen_agent --out robustness.json --picture robustness.png",
                "benchmark robustness kitchen_agent --conditions 'noise 25' dusk --searches 50",
            ),
        ),
    ]
    | Annotated[
        BenchmarkRobot,
        subcommand(
            "robot",
            description=help_text(
                "How often a simulated TurtleBot in a rendered room finds its targets: from anywhere near the "
                "lattice, with wheels that slip, at another hour, with things moved by a hand's breadth; and what of "
                "training and search it takes (needs the `rooms` extra).",
                "benchmark robot kitchen_agent --out robot.json --picture robot.png",
                "benchmark robot plain_agent kitchen_agent --room kitchen_1_hour_noon --starts 40 --compared 20",
            ),
        ),
    ]
)


def _render_again(scene: Any, out: Path, hour: str | None, moved: int | None) -> None:
    from active_perceiver.capture.rendered.render import RoomChange, origin_of, render_scene

    render_scene(*origin_of(scene), out, resume=True, change=RoomChange(hour, moved))
