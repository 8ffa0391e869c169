"""The cells of the tables: one training and its measurement each, kept so that an interrupted run goes on."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.parallel.run_store import RunStore
from active_perceiver.policies.evaluation import Evaluation, episode_evaluation, exact_evaluation, mean_evaluation
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.reproduction.config import LearnerName, MethodName, SetupName
from active_perceiver.reproduction.policy_inputs import Boxes, PolicyInputs, short_hash
from active_perceiver.reproduction.setups import CHOICES, METHODS, BudgetConfig
from active_perceiver.utils.files import replacing
from active_perceiver.utils.progress import progress_bar
from active_perceiver.utils.result import write_result
from active_perceiver.utils.stored_names import LEARNER, stored_names

MOMENTS = ("start", "middle", "end")


@dataclass(frozen=True)
class Cell:
    """One training.

    Attributes:
        setup: what is searched for where.
        method: which reward.
        learner: None for the random walk.
        seed: of everything random.
        choice: a name in CHOICES, if something is chosen otherwise.
    """

    setup: SetupName
    method: MethodName
    learner: LearnerName | None
    seed: int
    choice: str = ""

    @property
    def name(self) -> str:
        """For people and files."""
        parts = (self.setup, self.method, self.learner, self.choice, str(self.seed))
        return "-".join(part for part in parts if part)


def cells_of(
    setups: Sequence[SetupName], methods: Sequence[MethodName], learners: Sequence[LearnerName], seeds: int
) -> list[Cell]:
    """All cells of a table; the random walk has no learner."""
    return [
        Cell(setup, method, learner, seed)
        for setup in setups
        for method in methods
        for learner in (learners if METHODS[method].reward else (None,))
        for seed in range(seeds)
    ]


class Cells:
    """The results of cells, from the folder if they are there.

    Args:
        folder: of their files.
        scale: how large everything is.
        goal_observations: what the policies are shown.
    """

    def __init__(self, folder: Path, scale: BudgetConfig, goal_observations: PolicyInputs) -> None:
        # The names of what it holds say what that follows from: nothing stale is taken for a result.
        self._store = RunStore(folder)
        self._scale = scale
        self._sights = goal_observations

    def done(self, cell: Cell) -> bool:
        """Whether its result is there."""
        return self._store.record(self._name(cell)) is not None

    def result(self, cell: Cell) -> dict[str, Any]:
        """The body of its result file; trains and measures if it is not there."""
        record = self._store.record(self._name(cell))
        return self._run(cell) if record is None else record

    def tables(self, cell: Cell) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Its policy at the start, in the middle and at the end of training: moment -> scene -> (S, T, A)."""
        if not self.done(cell) or self._store.load(self._name(cell)) is None:
            self._run(cell)
        arrays = self._store.loaded(self._name(cell))
        return {
            moment: {scene: _normal(arrays[f"{moment}/{scene}"]) for scene in self._searches(cell)}
            for moment in MOMENTS
        }

    def training_tasks(self, cell: Cell) -> list[TrainingTask]:
        """What it searches for, one for each scene."""
        boxes = self._boxes(cell)
        return [self._sights.training_task(scene, targets, boxes) for scene, targets in self._searches(cell).items()]

    def _searches(self, cell: Cell) -> Mapping[str, tuple[str, ...]]:
        return self._scale.setups[cell.setup].searches

    def _boxes(self, cell: Cell) -> Boxes:
        return "ground-truth" if cell.choice and CHOICES[cell.choice].true_boxes else self._sights.boxes

    def _config(self, cell: Cell) -> Any:
        return cell.learner and self._scale.config(cell.learner, cell.setup, cell.method, cell.seed, cell.choice)

    def _name(self, cell: Cell) -> str:
        """Holds a hash of all that the result depends on."""
        config, boxes = self._config(cell), self._boxes(cell)
        facts = {
            "searches": self._searches(cell),
            "sights": {scene: self._sights.fingerprint(scene, boxes) for scene in self._searches(cell)},
            "config": config and stored_names(asdict(config), LEARNER),  # so that results of before count as done
            "protocol": [self._scale.episodes, self._scale.limit],
        }
        return f"{cell.name}-{short_hash(facts)}"

    def _path(self, cell: Cell, suffix: str) -> Path:
        return self._store.path(self._name(cell), suffix)

    def _run(self, cell: Cell) -> dict[str, Any]:
        training_tasks, config = self.training_tasks(cell), self._config(cell)
        started = time.monotonic()
        moments, history = self._train(cell, training_tasks) if cell.learner else (_random_walk(training_tasks), [])
        seconds = time.monotonic() - started
        rng = np.random.default_rng(cell.seed)
        body = {
            "cell": {**asdict(cell), "scenes": self._searches(cell)},
            "boxes": self._boxes(cell),
            "settings": config and asdict(config),
            "sampled": _evaluated(
                episode_evaluation(table, training_task.task, self._scale.episodes, self._scale.limit, rng)
                for table, training_task in zip(moments["end"], training_tasks, strict=True)
            ),
            "exact": _evaluated(
                exact_evaluation(table, training_task.task, self._scale.limit)
                for table, training_task in zip(moments["end"], training_tasks, strict=True)
            ),
            "history": history,
            "seconds": seconds,
        }
        with replacing(self._path(cell, "npz")) as temporary, temporary.open("wb") as file:
            arrays: dict[str, Any] = {
                f"{moment}/{training_task.task.scene}": table.astype(np.float16)
                for moment, tables in moments.items()
                for table, training_task in zip(tables, training_tasks, strict=True)
            }
            np.savez_compressed(file, **arrays)
        written = write_result(self._path(cell, "json"), "reproduce", body)
        self._path(cell, "checkpoint").unlink(missing_ok=True)
        return written

    def _train(
        self, cell: Cell, training_tasks: Sequence[TrainingTask]
    ) -> tuple[dict[str, list[NDArray[np.float32]]], list[dict[str, float]]]:
        from active_perceiver.policies.network import seeded_network, task_table

        assert cell.learner is not None
        config = self._config(cell)
        moments = {
            "start": [
                task_table(seeded_network(training_tasks, config), training_task)[0]
                for training_task in training_tasks
            ]
        }

        def inspect(record: dict[str, float], tables: Sequence[NDArray[np.float32]]) -> None:
            if record["iteration"] * 2 >= config.iterations:
                moments.setdefault("middle", list(tables))

        checkpoint = self._path(cell, "checkpoint")
        checkpoint.parent.mkdir(parents=True, exist_ok=True)
        with progress_bar(cell.name[:30]) as report:
            network, history = LEARNERS[cell.learner].train(training_tasks, config, report, inspect, checkpoint)
        moments["end"] = [task_table(network, training_task)[0] for training_task in training_tasks]
        moments.setdefault("middle", moments["end"])
        return moments, history


def _normal(table: NDArray[np.float16]) -> NDArray[np.float64]:
    """What was rounded to be stored, with sums of 1 again."""
    exact = table.astype(np.float64)
    return exact / exact.sum(axis=-1, keepdims=True)


def _random_walk(training_tasks: Sequence[TrainingTask]) -> dict[str, list[NDArray[np.float32]]]:
    walk = []
    for task in (training_task.task for training_task in training_tasks):
        count = len(task.actions)
        walk.append(np.full((*task.goals.shape, count), 1 / count, np.float32))
    return dict.fromkeys(MOMENTS, walk)


def _evaluated(evaluations: Any) -> dict[str, Any]:
    evaluation: Evaluation = mean_evaluation(list(evaluations))
    return evaluation.as_dict()
