"""The commands `active-perceiver benchmark train`, `scale`, `policies` and `recogniser`: what training takes.

As in `cli/main.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from tyro.conf import OmitArgPrefixes, Positional, subcommand

from active_perceiver.benchmarks.config import (
    PolicyBenchmarkConfig,
    RecogniserBenchmarkConfig,
    ScaleConfig,
    TrainSpeedConfig,
)
from active_perceiver.cli.help import help_text
from active_perceiver.cli.outputs import Outputs, print_benchmark


@dataclass
class BenchmarkTrain(Outputs):
    """How long learners take to a policy that always arrives, by short ways."""

    settings: OmitArgPrefixes[TrainSpeedConfig] = field(default_factory=TrainSpeedConfig)
    resume: bool = False
    """Go on after the trainings that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.benchmarks.train.measure import TrainBenchmark

        return print_benchmark(TrainBenchmark(self.settings), self, self.resume)


@dataclass
class BenchmarkScale(Outputs):
    """What training costs in time and memory, as scenes get more and larger."""

    settings: OmitArgPrefixes[ScaleConfig] = field(default_factory=ScaleConfig)
    resume: bool = False
    """Go on after the trainings that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.benchmarks.scale.measure import ScaleBenchmark

        return print_benchmark(ScaleBenchmark(self.settings), self, self.resume)


@dataclass
class BenchmarkPolicies(Outputs):
    """How good trained policies are, and how long that takes, in many rooms and with many seeds."""

    agents: Positional[tuple[Path, ...]]
    """Folders of agents: each one's recogniser, scenes and targets are a setup. Their policies are not used."""
    settings: OmitArgPrefixes[PolicyBenchmarkConfig] = field(default_factory=PolicyBenchmarkConfig)
    resume: bool = False
    """Go on after the trainings that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.benchmarks.policies.measure import PoliciesBenchmark

        return print_benchmark(PoliciesBenchmark(self.agents, self.settings), self, self.resume)


@dataclass
class BenchmarkRecogniser(Outputs):
    """What each ingredient of the recogniser's training is worth, and how good it is on targets it never learned."""

    settings: OmitArgPrefixes[RecogniserBenchmarkConfig] = field(default_factory=RecogniserBenchmarkConfig)
    resume: bool = False
    """Go on after the trainings that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.benchmarks.recogniser.measure import RecogniserBenchmark

        return print_benchmark(RecogniserBenchmark(self.settings), self, self.resume)


TrainingBenchmark = (
    Annotated[
        BenchmarkTrain,
        subcommand(
            "train",
            description=help_text(
                "How long learners take to a policy that always arrives, in at most 1.25 x the fewest steps, and "
                "steps per second: this project's, and stable-baselines3's with the same network and environment.",
                "benchmark train --out train.json --picture train.png",
                "benchmark train --learners mirror-descent sb3-ppo --seeds 1",
            ),
        ),
    ]
    | Annotated[
        BenchmarkScale,
        subcommand(
            "scale",
            description=help_text(
                "What training a policy costs in time and memory, as scenes get more and larger: synthetic scenes of "
                "any size, each training in a process of its own.",
                "benchmark scale --out scale.json --picture scale.png",
                "benchmark scale --scenes 1 4 --states 200 --learners distil ppo --seconds 20",
            ),
        ),
    ]
    | Annotated[
        BenchmarkPolicies,
        subcommand(
            "policies",
            description=help_text(
                "How good policies are that are trained with the default settings, in the rooms of some agents and "
                "by what their recognisers see: success, ratio to the shortest paths, seconds; the worst seed too.",
                "benchmark policies kitchen_agent --out policies.json --picture policies.png",
                "benchmark policies kitchen_agent office_agent --learners mirror-descent ppo --seeds 3",
            ),
        ),
    ]
    | Annotated[
        BenchmarkRecogniser,
        subcommand(
            "recogniser",
            description=help_text(
                "What each ingredient of the recogniser's training is worth, judged on places it has not been "
                "trained in: one is left out after the other. And how good it is on targets it never learned.",
                "benchmark recogniser --out recogniser.json --picture recogniser.png",
                "benchmark recogniser --scenes living_room_1 --variants default 'from scratch' --steps 200",
            ),
        ),
    ]
)
