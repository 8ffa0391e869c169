"""How good trained policies are and how long that takes: one set of defaults, many rooms, many seeds."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import PolicyBenchmarkConfig
from active_perceiver.benchmarks.outputs import check_outputs, write_outputs
from active_perceiver.benchmarks.policies.report import format_policies, spread_rows, summary
from active_perceiver.benchmarks.policies.worker import FINE_RATIO, train_and_measure
from active_perceiver.errors import UserError
from active_perceiver.evaluation.evaluate import agent_detections, with_query_pictures
from active_perceiver.figures.policies_spread import policies_spread
from active_perceiver.parallel.run_store import check_resume, kept_runs
from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.learners import learner_named
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import open_scene
from active_perceiver.training.common import policy_tasks
from active_perceiver.training.policy_augmentation import changed_observations
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet

ONE_SCENE = (1.02, 15.0)
"""What one scene's policy is to keep in the worst seed: mean steps over the fewest possible, seconds of training."""
MANY_SCENES = (1.03, 90.0)
"""The same for one policy of several scenes."""

Run = dict[str, Any]


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


def policies_command(
    folders: Sequence[Path],
    settings: PolicyBenchmarkConfig,
    out: Path | None = None,
    picture: Path | None = None,
    *,
    force: bool = False,
    resume: bool = False,
) -> dict[str, Any]:
    """Measure, print a table, write the result and the picture if they are asked for.

    With `out`, finished trainings are kept beside it until all are done, and `resume` goes on after them.

    Args:
        folders: of the agents whose recognisers, scenes and targets are used.
        settings: who learns, and how often.
        out: the JSON file.
        picture: the PNG file.
        force: replace existing files.
        resume: go on with an interrupted run.

    Returns:
        The body of the result file, see `measure_policies`.

    Raises:
        OutputExistsError: if a file exists, or trainings are kept, and neither `force` nor `resume` says what to do.
        UserError: if the settings make no sense, or an agent or a scene is not what it should be.
    """
    # An interrupted run has not written its result yet, so `resume` has nothing to say about an existing one.
    check_outputs(force, out, picture)
    configs = checked_configs(settings)
    check_resume(resume, out)
    setups = open_setups(folders, settings.scenes)
    facts = {
        **asdict(settings),
        "setups": {setup.name: setup.fingerprint for setup in setups},
        "learners": {name: asdict(config) for name, config in configs.items()},
    }
    with kept_runs(out, facts, force=force, resume=resume) as (done, keep):
        with progress_bar("trainings") as report:
            body = measure_policies(setups, configs, settings, done, keep, report)
        print(format_policies(body))
        write_outputs(
            "benchmark policies", body, out, picture, lambda: policies_spread(spread_rows(body), FINE_RATIO)
        )
    return body


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
    if config.task != "object":
        raise UserError(f"{agent.folder} searches for views of its scenes; it has no recogniser to draw boxes")
    branches = zip(config.branches, config.training["scenes"], strict=True)
    agent.config = replace(
        config, training={**config.training, "scenes": [sources.get(name, source) for name, source in branches]}
    )
    detections = agent_detections(agent)
    threshold = config.score_threshold
    copies, seed = int(config.training.get("view_augmentation", 0)), int(config.training["seed"])
    degrees = float(config.training.get("viewpoint_jitter_degrees", 0.0))
    changed = [
        changed_observations(seen, agent.backbone, agent.recogniser, threshold, copies, degrees, seed)
        for seen in detections
    ]
    training_tasks = policy_tasks(detections, threshold, int(config.training["rank"]), changed)
    held_out = all(seen.held_out_pictures for seen in detections)
    unseen = [
        TrainingTask(
            training_task.task, with_query_pictures(agent, seen).observations(threshold, seen.held_out_pictures)
        )
        for training_task, seen in zip(training_tasks, detections, strict=True)
        if held_out
    ]
    digest = hashlib.sha256((agent.folder / "recogniser.onnx").read_bytes() + repr((copies, degrees)).encode())
    for seen in detections:
        digest.update(seen.scene.content_hash.encode())
    return PolicySetup(agent.folder, tuple(training_tasks), tuple(unseen), digest.hexdigest()[:16])


def measure_policies(
    setups: Sequence[PolicySetup],
    configs: Mapping[str, LearnerConfig],
    settings: PolicyBenchmarkConfig,
    done: Sequence[Run] = (),
    keep: Callable[[Run], None] = lambda run: None,
    progress: ProgressCallback = quiet,
) -> dict[str, Any]:
    """Train policies in each setup by each learner with each seed, one after the other, each in a fresh process.

    Args:
        setups: what for, see `open_setups`.
        configs: of the learners, see `checked_configs`.
        settings: how often.
        done: runs that are finished already.
        keep: is called with each run that is finished.
        progress: called with the trainings done and to do.

    Returns:
        "protocol"; "setups": see `PolicySetup.described`; "summary": for each setup and learner see `summary`;
        "runs": for each training "setup", "learner", "seed" and what `train_and_measure` gives.

    Raises:
        UserError: if a learner cannot train.
    """
    runs = {(run["setup"], run["learner"], run["seed"]): run for run in done}
    # Seed by seed, so that a disturbance of the machine meets all, and what an interrupted run has is even.
    jobs = [(setup, learner, seed) for seed in range(settings.seeds) for setup in setups for learner in configs]
    for number, (setup, learner, seed) in enumerate(jobs):
        key = (setup.name, learner, seed)
        if key not in runs:
            progress(number, len(jobs), f"{setup.name}, {learner}, seed {seed}")
            config = replace(configs[learner], seed=seed)
            measured = _in_fresh_process(settings.threads, setup, learner, config, settings.limit)
            runs[key] = {"setup": setup.name, "learner": learner, "seed": seed, **measured}
            keep(runs[key])
    progress(len(jobs), len(jobs))
    ordered = [
        runs[setup.name, learner, seed] for setup in setups for learner in configs for seed in range(settings.seeds)
    ]
    described = [setup.described() for setup in setups]
    return {
        "protocol": _protocol(configs, settings),
        "setups": described,
        "summary": [
            summary(about, learner, [run for run in ordered if (run["setup"], run["learner"]) == (name, learner)])
            for about in described
            for name in (about["setup"],)
            for learner in configs
        ],
        "runs": ordered,
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


def _in_fresh_process(
    threads: int, setup: PolicySetup, learner: str, config: LearnerConfig, limit: int
) -> dict[str, Any]:
    """What `train_and_measure` gives, in a process that nothing has been trained in before."""
    with _threads_of_children(threads), ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        try:
            return pool.submit(train_and_measure, setup.training_tasks, setup.unseen, learner, config, limit).result()
        except BrokenProcessPool:
            raise UserError(
                f"the training by {learner} in {setup.name} was killed, perhaps for want of memory; --resume goes on"
            ) from None


@contextmanager
def _threads_of_children(threads: int) -> Iterator[None]:
    """Processes started in this block compute with so many threads, in NumPy too, which is only told at its start."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, str(threads)))
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value
