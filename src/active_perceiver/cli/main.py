"""The command line: `active-perceiver ...`, also `python -m active_perceiver`. Each command is a thin shell.

A command is a dataclass whose fields are its arguments, their docstrings the help; `run` does the work. What is
heavy to import is imported there, so that `--help` answers at once.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro
from rich.markup import escape
from tyro.conf import Positional, subcommand

from active_perceiver.cli.benchmark import Benchmark
from active_perceiver.cli.bridge import BridgeCommand
from active_perceiver.cli.help import help_text
from active_perceiver.cli.scenes import Scenes
from active_perceiver.errors import UserError
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.reproduction.config import Experiment, ReproduceConfig
from active_perceiver.training.config import TrainConfig
from active_perceiver.utils.progress import console

if TYPE_CHECKING:
    from active_perceiver.live.recording import Recording


@dataclass
class Demo:
    """The main job on a bundled room."""

    out: Path = Path("demo")
    """Folder for the agent, the report, the videos and result.json."""
    seed: int = 0
    """Training and searches follow from it."""
    force: bool = False
    """Replace what an earlier demo left in the folder."""
    resume: bool = False
    """Go on where an interrupted demo stopped."""

    def run(self) -> int:
        from active_perceiver.cli.demo import SETTINGS, run_demo

        run_demo(self.out, replace(SETTINGS, seed=self.seed), force=self.force, resume=self.resume)
        return 0


@dataclass
class Train:
    """Train an agent."""

    out: Path
    """Folder of the new agent."""
    settings: tyro.conf.OmitArgPrefixes[TrainConfig] = field(default_factory=TrainConfig)
    force: bool = False
    """Replace an agent that is there."""
    resume: bool = False
    """Go on where an interrupted training stopped."""

    def run(self) -> int:
        from active_perceiver.evaluation.evaluate import format_measures
        from active_perceiver.training.train import train

        result = train(self.settings, self.out, force=self.force, resume=self.resume)
        print(format_measures(result.to_json()))
        print(f"agent: {self.out}   measured: {self.out / 'result.json'}")
        return 0


@dataclass
class Evaluate:
    """Measure an agent."""

    agent: Positional[Path]
    """Folder of the agent."""
    settings: tyro.conf.OmitArgPrefixes[EvaluateConfig] = field(default_factory=EvaluateConfig)
    out: Path | None = None
    """Write the result here as well, as JSON."""
    force: bool = False
    """Replace an existing file."""

    def run(self) -> int:
        from active_perceiver.agent.perceiver import ActivePerceiver
        from active_perceiver.evaluation.evaluate import evaluate, format_measures
        from active_perceiver.utils.files import OutputExistsError
        from active_perceiver.utils.result import write_result

        if self.out is not None and self.out.exists() and not self.force:
            raise OutputExistsError(f"{self.out} exists; give another --out, or --force to replace it")
        config = self.settings
        agent = ActivePerceiver.from_pretrained(self.agent, confirm=config.confirm, explore=config.explore)
        body = evaluate(agent, config).to_json()
        print(format_measures(body))
        if self.out is not None:
            write_result(self.out, "evaluate", body)
        return 0


@dataclass
class Search:
    """Search for the object in a picture."""

    agent: Positional[Path]
    """Folder of the agent."""
    picture: Path
    """Picture of the object on its own, or of the view if the agent searches for views; any image file."""
    robot: str
    """Where to search: scene:NAME for a bundled scene, scene:FILE for a scene file; thor:FloorPlan1 for a room of
    AI2-THOR, thor:FILE for one captured with other than the usual settings; room:NAME for a simulated TurtleBot in a
    rendered room; ros:ws://HOST:PORT for a robot behind rosbridge."""
    robot_config: str | None = None
    """What a ros robot is like: turtlebot2, turtlebot3, turtlebot4, or a YAML file."""
    start: int | None = None
    """State to start in; a random one if not given."""
    scene: str | None = None
    """Policy branch, the name of a scene the agent was trained in; needed if it has several."""
    max_steps: int = 200
    """Give up after so many actions."""
    max_minutes: float = 10.0
    """Give up after so many minutes."""
    seed: int | None = None
    """The start and the agent's draws follow from it."""
    threads: int | None = None
    """CPU threads of the agent; one per core if not given."""
    confirm: bool = False
    """Take two views in a row, from different poses, to say found: fewer false ones, a step or so more."""
    explore: bool = True
    """Whether to look round the room when the policy leads in circles, because the target is not where it was; with
    --no-explore the policy is followed all the same."""
    dry_run: bool = False
    """Only look, and show what would be done: nothing moves. It looks --max-steps times, or until Ctrl-C."""
    record: Path | None = None
    """Keep everything that is seen and decided in this folder as the search goes on; `report` makes a page of it."""
    out: Path | None = None
    """Write search.mp4, report.html, path.png, final.png and search.json into this folder."""
    force: bool = False
    """Replace a recording and a report that are in these folders."""

    def run(self) -> int:
        from active_perceiver.live.recorder import check_folder
        from active_perceiver.live.session import search_command
        from active_perceiver.reports.search_report import check_report, verdict

        if self.record is not None:
            check_folder(self.record, self.force)
        if self.out is not None:
            check_report(self.out, self.force)
        recording = search_command(
            self.agent, self.picture, self.robot, robot_config=self.robot_config, start=self.start,
            scene=self.scene, max_steps=self.max_steps, max_minutes=self.max_minutes, seed=self.seed,
            threads=self.threads, confirm=self.confirm, explore=self.explore, dry_run=self.dry_run,
            record=self.record, force=self.force,
        )  # fmt: skip
        print(verdict(recording.record))
        if self.record is not None:
            print(
                f"recorded in {self.record}; `active-perceiver report {self.record}` makes a video and a page of it"
            )
        if self.out is not None:
            _write_report(recording, self.out)
        return 0 if recording.record.found or self.dry_run else 1


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
        _write_report(recording, out)
        return 0


def _write_report(recording: Recording, out: Path) -> None:
    from active_perceiver.reports.search_report import write_report
    from active_perceiver.utils.progress import progress_bar

    with progress_bar("video") as report:
        written = write_report(recording, out, report)
    print(f"written into {out}: {', '.join(written)}")


@dataclass
class Export:
    """An agent as one folder for a robot."""

    agent: Positional[Path]
    """Folder of the agent."""
    out: Positional[Path]
    """The new folder."""
    int8: bool = False
    """Make the backbone compute with 8-bit numbers: smaller and, on most processors, faster; a little less exact."""
    calibrate: str | None = None
    """With --int8: the scene, a bundled name or a file, by whose views the ranges of these numbers are set; the
    agent's own pictures if not given."""
    force: bool = False
    """Replace an agent that is there."""

    def run(self) -> int:
        from active_perceiver.deploy.export import export_agent

        print(export_agent(self.agent, self.out, int8=self.int8, calibrate=self.calibrate, force=self.force))
        return 0


@dataclass
class Pretrain:
    """Weights for recognisers to start from."""

    scenes: tuple[str, ...]
    """Bundled names or scene files; none of the rooms that recognisers will be trained in."""
    out: Path
    """The safetensors file."""
    steps: int = 4000
    """Training steps."""
    seed: int = 0
    """Everything random follows from it."""
    force: bool = False
    """Replace an existing file."""

    def run(self) -> int:
        from active_perceiver.training.pretrain import pretrain

        seconds = pretrain(self.scenes, self.out, steps=self.steps, seed=self.seed, force=self.force)
        print(f"weights: {self.out} ({seconds:.0f} s)")
        return 0


@dataclass
class Reproduce:
    """The paper's tables and figures."""

    what: Positional[Experiment]
    """Which: a table, a figure, or all."""
    out: Path = Path("reproduction")
    """Folder for tables, figures and the results of single trainings; what is there is not run again."""
    settings: tyro.conf.OmitArgPrefixes[ReproduceConfig] = field(default_factory=ReproduceConfig)

    def run(self) -> int:
        from active_perceiver.reproduction.reproduce import reproduce

        return 0 if reproduce(self.what, self.settings, self.out) else 1


@dataclass
class Info:
    """Versions and machine, for a bug report."""

    def run(self) -> int:
        from active_perceiver import __version__
        from active_perceiver.scenes import bundled_names
        from active_perceiver.utils.result import machine
        from active_perceiver.vision.backbone import cache_folder

        facts = {"version": __version__, **machine(), "cache": str(cache_folder()), "scenes": bundled_names()}
        print(json.dumps(facts, indent=2))
        return 0


Command = (
    Annotated[
        Demo,
        subcommand(
            "demo",
            description=help_text(
                "Train on the bundled kitchen, measure, search for four objects from pictures, write a report.",
                "demo",
                "demo --out my_demo --seed 3",
            ),
        ),
    ]
    | Annotated[
        Scenes,
        subcommand(
            "scenes",
            description="Scenes: list, info, check, import, export, label, capture, render, preview, elsewhere (each "
            "has its own --help).",
        ),
    ]
    | Annotated[
        Train,
        subcommand(
            "train",
            description=help_text(
                "Train a recogniser and a policy, or, with --task view, a policy alone; the result is a folder that "
                "runs without torch.",
                "train --out kitchen_agent",
                "train --scenes kitchen_1 --targets mug plate --out agent --learner ppo --reward gain",
                "train --task view --scenes kitchen_1 --targets 12 345 700 --out zhu_agent",
            ),
        ),
    ]
    | Annotated[
        Pretrain,
        subcommand(
            "pretrain",
            description=help_text(
                "Train the weights that recognisers of other rooms start from.",
                "pretrain --scenes rooms/kitchen_101.h5 rooms/living_room_101.h5 --out weights.safetensors",
            ),
        ),
    ]
    | Annotated[
        Evaluate,
        subcommand(
            "evaluate",
            description=help_text(
                "Measure an agent: success, steps, ratio to the shortest path, SPL, and its own word.",
                "evaluate kitchen_agent",
                "evaluate kitchen_agent --protocol paper --out paper.json",
            ),
        ),
    ]
    | Annotated[
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
    | BridgeCommand
    | Annotated[
        Report,
        subcommand(
            "report",
            description=help_text(
                "Make a video and a page of a search that was recorded.", "report run", "report run --out run_report"
            ),
        ),
    ]
    | Annotated[
        Export,
        subcommand(
            "export",
            description=help_text(
                "One folder with all that an agent needs to run; with it a robot needs numpy, onnxruntime and pillow "
                "only.",
                "export kitchen_agent kitchen_robot",
                "export kitchen_agent kitchen_robot_8 --int8 --calibrate kitchen_1",
            ),
        ),
    ]
    | Annotated[
        Benchmark,
        subcommand(
            "benchmark",
            description="How fast and how good it is: act, env, export, policies, recogniser, render, robot, "
            "robustness, scale, train (each has its own --help).",
        ),
    ]
    | Annotated[
        Reproduce,
        subcommand(
            "reproduce",
            description=help_text(
                "Reproduce the paper's tables and figures; interrupted, the same command goes on.",
                "reproduce all --quick",
                "reproduce table1 --setups one_object --learners ppo",
                "reproduce table1 --minutes 110 --out reproduction",
            ),
        ),
    ]
    | Annotated[Info, subcommand("info", description=help_text("Versions and machine, for a bug report.", "info"))]
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: without the program's name; those of the process if not given.

    Returns:
        The exit code: 0 well done, 1 a negative answer (not found, not sound), 2 wrong input, 130 interrupted.
    """
    command = tyro.cli(
        Command,
        prog="active-perceiver",
        description="Give a robot a picture of an object; it searches the room and draws a box on it.",
        args=arguments,
        config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    try:
        with warnings.catch_warnings():
            # Of EXIF that is corrupt, as some phones write it; an image that cannot be read is an error anyway.
            warnings.filterwarnings("ignore", module=r"PIL\b")
            return command.run()
    except user_errors() as error:
        # A message may hold brackets, as in 'active-perceiver[train]'; they are no markup.
        console.print(f"[bold red]error:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        return 2
    except KeyboardInterrupt:
        console.print(
            "interrupted; what was there before is as it was. `demo`, `train`, `scenes render`, `capture` "
            "and `elsewhere` go on with --resume",
            soft_wrap=True,
        )
        return 130


def user_errors() -> tuple[type[Exception], ...]:
    """What ends a command with a sentence: our own errors, and those of the rooms where they have been imported."""
    rooms = sys.modules.get("indoor_rooms.errors")
    return (UserError,) if rooms is None else (UserError, rooms.RoomError)


if __name__ == "__main__":
    sys.exit(main())
