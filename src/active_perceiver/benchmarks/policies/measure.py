"""How good trained policies are and how long that takes: one set of defaults, many rooms, many seeds."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from active_perceiver.agent.goals import GOALS
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import PolicyBenchmarkConfig
from active_perceiver.benchmarks.policies.report import format_policies, spread_rows, summary
from active_perceiver.benchmarks.policies.worker import FINE_RATIO, PolicyTraining, train_and_measure
from active_perceiver.benchmarks.runner import Benchmark, ResultBody
from active_perceiver.errors import UserError
from active_perceiver.evaluation.object_measures import agent_detections, with_query_pictures
from active_perceiver.figures.policies_spread import policies_spread
from active_perceiver.parallel.executor import Executor
from active_perceiver.parallel.fresh_process import FreshProcessExecutor
from active_perceiver.parallel.run_missing import records_of
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.learners import learner_named
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import open_scene
from active_perceiver.training.policy_augmentation import changed_observations
from active_perceiver.training.policy_stage import policy_tasks
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet

ONE_SCENE = (1.02, 15.0)
"""What one scene's policy is to keep in the worst seed: mean steps over the fewest possible, seconds of training."""
MANY_SCENES = (1.03, 90.0)
"""The same for one policy of several scenes."""


@dataclass(frozen=True, eq=False)
class PolicySetup:
    """What policies are trained for.

    Attributes:
        agent: the folder whose recogniser draws the boxes.
        training_tasks: one for each of its scenes, as training makes them.
        unseen: the same searches with the pictures that the scenes hold out; none if they hold none out.
        fingerprint: differs if the recogniser or a scene does.
    """

    agent: Path
    training_tasks: tuple[TrainingTask, ...]
    unseen: tuple[TrainingTask, ...]
    fingerprint: str

    @property
    def name(self) -> str:
        """The scene, or how many there are."""
        return (
            self.training_tasks[0].task.scene
            if len(self.training_tasks) == 1
            else f"{len(self.training_tasks)} scenes"
        )

    def described(self) -> dict[str, Any]:
        """What the result file says about it."""
        ratio, seconds = ONE_SCENE if len(self.training_tasks) == 1 else MANY_SCENES
        tasks = [training_task.task for training_task in self.training_tasks]
        return {
            "setup": self.name,
            "agent": self.agent.name,
            "scenes": [task.scene for task in tasks],
            "states": [len(task) for task in tasks],
            "targets": [f"{task.scene}/{target}" for task in tasks for target in task.targets],
            "pictures": self.training_tasks[0].observations.pictures,
            "unseen_pictures": self.unseen[0].observations.pictures if self.unseen else 0,
            "ratio_limit": ratio,
            "seconds_limit": seconds,
        }


@dataclass
class PoliciesBenchmark(Benchmark):
    """How good trained policies are, and how long that takes.

    Attributes:
        folders: of the agents whose recognisers, scenes and targets are used.
        settings: who learns, and how often.
        executor: gives each training a process of its own.
    """

    name = "policies"
    folders: Sequence[Path]
    settings: PolicyBenchmarkConfig
    executor: Executor | None = None

    def prepare(self) -> Mapping[str, Any]:
        """See `Benchmark`."""
        self.configs = checked_configs(self.settings)
        self.setups = open_setups(self.folders, self.settings.scenes)
        return {
            **asdict(self.settings),
            "setups": {setup.name: setup.fingerprint for setup in self.setups},
            "learners": {name: asdict(config) for name, config in self.configs.items()},
        }

    def measure(self, store: RunStore) -> ResultBody:
        """See `measure_policies`."""
        executor = self.executor or FreshProcessExecutor(self.settings.threads)
        with progress_bar("trainings") as report:
            return measure_policies(self.setups, self.configs, self.settings, store, executor, report)

    def report(self, body: ResultBody) -> str:
        """See `format_policies`."""
        return format_policies(body)

    def figure(self, body: ResultBody) -> Figure:
        """The spread over seeds."""
        return policies_spread(spread_rows(body), FINE_RATIO)


def checked_configs(settings: PolicyBenchmarkConfig) -> dict[str, LearnerConfig]:
    """Each learner's configuration: its defaults, but for what the settings say.

    Raises:
        UserError: if the settings make no sense.
    """
    if not settings.learners or len(set(settings.learners)) != len(settings.learners):
        raise UserError(f"name each learner once, at least one; got {list(settings.learners)}")
    if min(settings.seeds, settings.limit, settings.threads) < 1:
        raise UserError("seeds, limit and threads must be at least 1")
    given = {} if settings.iterations is None else {"iterations": settings.iterations}
    return {name: learner_named(name).config(threads=settings.threads, **given) for name in settings.learners}


def open_setups(folders: Sequence[Path], scenes: Sequence[str] = ()) -> list[PolicySetup]:
    """Let the recogniser of each agent look everywhere in the scenes it was trained in.

    Args:
        folders: of the agents.
        scenes: sources to take in place of the agents' scenes of the same names.

    Raises:
        UserError: if there is no agent, one searches for views, two have the same scenes, or a scene is not there or
            no agent's.
    """
    if not folders:
        raise UserError("name the folder of at least one agent; `active-perceiver train --out FOLDER` makes one")
    sources = {open_scene(source).name: source for source in scenes}
    agents = [ActivePerceiver.from_pretrained(folder) for folder in folders]
    known = {name for agent in agents for name in agent.config.branches}
    if unknown := sources.keys() - known:
        raise UserError(f"no agent was trained in {', '.join(sorted(unknown))}; they know {', '.join(sorted(known))}")
    setups = [_open_setup(agent, sources) for agent in agents]
    names = [setup.name for setup in setups]
    if len(set(names)) != len(names):
        raise UserError(f"each setup needs an agent of its own, but these agents were trained in {', '.join(names)}")
    return setups


def _open_setup(agent: ActivePerceiver, sources: Mapping[str, str]) -> PolicySetup:
    config = agent.config
    if not GOALS[config.task].has_boxes:
        raise UserError(f"{agent.folder} searches for views of its scenes; it has no recogniser to draw boxes")
    detections = agent_detections(agent, sources)
    threshold, training = config.score_threshold, config.training
    shown = (training.view_augmentation, training.viewpoint_jitter_degrees)
    changed = [
        changed_observations(
            seen,
            agent.backbone,
            agent.recogniser,
            threshold,
            training.view_augmentation,
            training.viewpoint_jitter_degrees,
            training.seed,
        )
        for seen in detections
    ]
    training_tasks = policy_tasks(detections, threshold, training.rank, changed)
    held_out = all(seen.held_out_pictures for seen in detections)
    unseen = [
        TrainingTask(
            training_task.task, with_query_pictures(agent, seen).observations(threshold, seen.held_out_pictures)
        )
        for training_task, seen in zip(training_tasks, detections, strict=True)
        if held_out
    ]
    digest = hashlib.sha256((agent.folder / "recogniser.onnx").read_bytes() + repr(shown).encode())
    for seen in detections:
        digest.update(seen.scene.content_hash.encode())
    return PolicySetup(agent.folder, tuple(training_tasks), tuple(unseen), digest.hexdigest()[:16])


def measure_policies(
    setups: Sequence[PolicySetup],
    configs: Mapping[str, LearnerConfig],
    settings: PolicyBenchmarkConfig,
    store: RunStore,
    executor: Executor,
    progress: ProgressCallback = quiet,
) -> ResultBody:
    """Train policies in each setup by each learner with each seed, one after the other.

    Args:
        setups: what for, see `open_setups`.
        configs: of the learners, see `checked_configs`.
        settings: how often.
        store: keeps the runs.
        executor: gives each training a process of its own.
        progress: called with the trainings done and to do.

    Returns:
        "protocol"; "setups": see `PolicySetup.described`; "summary": for each setup and learner see `summary`;
        "runs": for each training "setup" and what `train_and_measure` gives.
    """
    # Seed by seed, so that a disturbance of the machine meets all, and what an interrupted run has is even.
    trainings = {
        f"{setup.name}, {learner}, seed {seed}": PolicyTraining(
            setup.name, setup.training_tasks, setup.unseen, learner, replace(config, seed=seed)
        )
        for seed in range(settings.seeds)
        for setup in setups
        for learner, config in configs.items()
    }
    runs = records_of(executor, store, train_and_measure, trainings, settings.limit, progress)
    described = [setup.described() for setup in setups]
    pairs = [(about, learner) for about in described for learner in configs]
    of_pair = [
        [runs[f"{about['setup']}, {learner}, seed {seed}"] for seed in range(settings.seeds)]
        for about, learner in pairs
    ]
    return {
        "protocol": _protocol(configs, settings),
        "setups": described,
        "summary": [summary(*pair, some) for pair, some in zip(pairs, of_pair, strict=True)],
        "runs": [run for some in of_pair for run in some],
    }


def _protocol(configs: Mapping[str, LearnerConfig], settings: PolicyBenchmarkConfig) -> dict[str, Any]:
    return {
        "boxes": "the recogniser's, in training and in measurement",
        "pictures": "those trained on",
        "evaluation": "exact, all starts from which a goal can be reached",
        "limit": settings.limit,
        "seeds": settings.seeds,
        "threads": settings.threads,
        "clock": "the whole training with its own measurements, in a fresh process, after one iteration that does not"
        " count",
        "fine_ratio": FINE_RATIO,
        "settings": {
            learner: {key: value for key, value in asdict(config).items() if key not in ("seed", "threads")}
            for learner, config in configs.items()
        },
    }
