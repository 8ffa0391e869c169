"""The commands `active-perceiver benchmark ...`: how fast it is on this machine, measured in one run."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import OmitArgPrefixes, Positional, subcommand

from active_perceiver.cli_scenes import help_text
from active_perceiver.experiments.benchmarks.settings import (
    ActSpeedSettings,
    ExportSettings,
    PolicySettings,
    RecogniserBenchmarkSettings,
    RobotBenchmarkSettings,
    RobustnessSettings,
    ScaleSettings,
    TrainSpeedSettings,
)


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


@dataclass
class BenchmarkExport:
    """What an exported agent weighs, how fast it starts and acts, and what 8-bit numbers do to it."""

    agent: Positional[Path]
    """Folder of the agent; it is measured in the scenes it was trained in."""
    settings: OmitArgPrefixes[ExportSettings] = field(default_factory=ExportSettings)
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.exported import exported_command

        exported_command(self.agent, self.settings, self.out, self.picture, force=self.force)
        return 0


@dataclass
class BenchmarkRobustness:
    """What becomes of success when an agent sees something else than it was trained on."""

    agent: Positional[Path]
    """Folder of the agent; it is measured in the scenes and with the pictures it was trained with."""
    settings: OmitArgPrefixes[RobustnessSettings] = field(default_factory=RobustnessSettings)
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""
    resume: bool = False
    """Keep what an interrupted run with the same --work has measured."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.robustness import robustness_command

        robustness_command(
            self.agent, self.settings, _render_again, self.out, self.picture, force=self.force, resume=self.resume
        )
        return 0


@dataclass
class BenchmarkRobot:
    """How often a robot that is never quite on the lattice finds its targets."""

    agents: Positional[tuple[Path, ...]]
    """Folders of agents that were trained in the room; the last one is the one that is measured, the others, whose
    policies were shown less in training, are compared with it."""
    settings: OmitArgPrefixes[RobotBenchmarkSettings] = field(default_factory=RobotBenchmarkSettings)
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""
    resume: bool = False
    """Go on after the rows that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.robot import robot_command

        robot_command(self.agents, self.settings, self.out, self.picture, force=self.force, resume=self.resume)
        return 0


@dataclass
class BenchmarkTrain:
    """How long learners take to a policy that always arrives, by short ways."""

    settings: OmitArgPrefixes[TrainSpeedSettings] = field(default_factory=TrainSpeedSettings)
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""
    resume: bool = False
    """Go on after the trainings that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.train_speed import train_speed_command

        train_speed_command(self.settings, self.out, self.picture, force=self.force, resume=self.resume)
        return 0


@dataclass
class BenchmarkPolicies:
    """How good trained policies are, and how long that takes, in many rooms and with many seeds."""

    agents: Positional[tuple[Path, ...]]
    """Folders of agents: each one's recogniser, scenes and targets are a setup. Their policies are not used."""
    settings: OmitArgPrefixes[PolicySettings] = field(default_factory=PolicySettings)
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""
    resume: bool = False
    """Go on after the trainings that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.policies import policies_command

        policies_command(self.agents, self.settings, self.out, self.picture, force=self.force, resume=self.resume)
        return 0


@dataclass
class BenchmarkScale:
    """What training costs in time and memory, as scenes get more and larger."""

    settings: OmitArgPrefixes[ScaleSettings] = field(default_factory=ScaleSettings)
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""
    resume: bool = False
    """Go on after the trainings that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.scale import scale_command

        scale_command(self.settings, self.out, self.picture, force=self.force, resume=self.resume)
        return 0


@dataclass
class BenchmarkRecogniser:
    """What each ingredient of the recogniser's training is worth, and how good it is on targets it never learned."""

    settings: OmitArgPrefixes[RecogniserBenchmarkSettings] = field(default_factory=RecogniserBenchmarkSettings)
    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""
    resume: bool = False
    """Go on after the trainings that an interrupted run has finished."""

    def run(self) -> int:
        from active_perceiver.experiments.benchmarks.recogniser import recogniser_command

        recogniser_command(self.settings, self.out, self.picture, force=self.force, resume=self.resume)
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


def _render_again(scene: Any, out: Path, hour: str | None, moved: int | None) -> None:
    from active_perceiver.rooms.capturing.rendering import origin_of, render_scene

    render_scene(*origin_of(scene), out, resume=True, hour=hour, moved=moved)
