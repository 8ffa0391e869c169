"""The cells of the tables: one training and its measurement each, kept so that an interrupted run goes on."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.experiments.reproduction.settings import LearnerName, MethodName, SetupName
from active_perceiver.experiments.reproduction.setups import CHOICES, METHODS, Scale
from active_perceiver.experiments.reproduction.sights import Boxes, Sights, short_hash
from active_perceiver.experiments.result import write_result
from active_perceiver.files import replacing
from active_perceiver.policies.evaluation import Evaluation, episode_evaluation, exact_evaluation, mean_evaluation
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.problem import Problem
from active_perceiver.progress import progress_bar

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
        sights: what the policies are shown.
    """

    def __init__(self, folder: Path, scale: Scale, sights: Sights) -> None:
        self._folder = folder
        self._scale = scale
        self._sights = sights

    def done(self, cell: Cell) -> bool:
        """Whether its result is there."""
        return self._path(cell, "json").is_file()

    def result(self, cell: Cell) -> dict[str, Any]:
        """The body of its result file; trains and measures if it is not there."""
        if not self.done(cell):
            self._run(cell)
        return json.loads(self._path(cell, "json").read_text())

    def tables(self, cell: Cell) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Its policy at the start, in the middle and at the end of training: moment -> scene -> (S, T, A)."""
        path = self._path(cell, "npz")
        if not (self.done(cell) and path.is_file()):
            self._run(cell)
        with np.load(path, allow_pickle=False) as file:
            return {
                moment: {scene: _normal(file[f"{moment}/{scene}"]) for scene in self._searches(cell)}
                for moment in MOMENTS
            }

    def problems(self, cell: Cell) -> list[Problem]:
        """What it searches for, one for each scene."""
        boxes = self._boxes(cell)
        return [self._sights.problem(scene, targets, boxes) for scene, targets in self._searches(cell).items()]

    def _searches(self, cell: Cell) -> Mapping[str, tuple[str, ...]]:
        return self._scale.setups[cell.setup].searches

    def _boxes(self, cell: Cell) -> Boxes:
        return "ground-truth" if cell.choice and CHOICES[cell.choice].true_boxes else self._sights.boxes

    def _config(self, cell: Cell) -> Any:
        return cell.learner and self._scale.config(cell.learner, cell.setup, cell.method, cell.seed, cell.choice)

    def _path(self, cell: Cell, suffix: str) -> Path:
        """The name holds a hash of all that the result depends on, so that no stale one is taken for it."""
        config, boxes = self._config(cell), self._boxes(cell)
        facts = {
            "searches": self._searches(cell),
            "sights": {scene: self._sights.fingerprint(scene, boxes) for scene in self._searches(cell)},
            "config": config and asdict(config),
            "protocol": [self._scale.episodes, self._scale.limit],
        }
        return self._folder / f"{cell.name}-{short_hash(facts)}.{suffix}"

    def _run(self, cell: Cell) -> None:
        problems, config = self.problems(cell), self._config(cell)
        started = time.monotonic()
        moments, history = self._train(cell, problems) if cell.learner else (_random_walk(problems), [])
        seconds = time.monotonic() - started
        rng = np.random.default_rng(cell.seed)
        body = {
            "cell": {**asdict(cell), "scenes": self._searches(cell)},
            "boxes": self._boxes(cell),
            "settings": config and asdict(config),
            "sampled": _evaluated(
                episode_evaluation(table, problem.task, self._scale.episodes, self._scale.limit, rng)
                for table, problem in zip(moments["end"], problems, strict=True)
            ),
            "exact": _evaluated(
                exact_evaluation(table, problem.task, self._scale.limit)
                for table, problem in zip(moments["end"], problems, strict=True)
            ),
            "history": history,
            "seconds": seconds,
        }
        with replacing(self._path(cell, "npz")) as temporary, temporary.open("wb") as file:
            arrays: dict[str, Any] = {
                f"{moment}/{problem.task.scene}": table.astype(np.float16)
                for moment, tables in moments.items()
                for table, problem in zip(tables, problems, strict=True)
            }
            np.savez_compressed(file, **arrays)
        write_result(self._path(cell, "json"), "reproduce", body)
        self._path(cell, "checkpoint").unlink(missing_ok=True)

    def _train(
        self, cell: Cell, problems: Sequence[Problem]
    ) -> tuple[dict[str, list[NDArray[np.float32]]], list[dict[str, float]]]:
        from active_perceiver.policies.network import problem_table, seeded_network

        assert cell.learner is not None
        config = self._config(cell)
        moments = {"start": [problem_table(seeded_network(problems, config), problem)[0] for problem in problems]}

        def inspect(record: dict[str, float], tables: Sequence[NDArray[np.float32]]) -> None:
            if record["iteration"] * 2 >= config.iterations:
                moments.setdefault("middle", list(tables))

        checkpoint = self._path(cell, "checkpoint")
        checkpoint.parent.mkdir(parents=True, exist_ok=True)
        with progress_bar(cell.name[:30]) as report:

            def progress(record: dict[str, float]) -> None:
                note = f"success {record['success']:.2f}, {record['mean_steps']:.0f} steps"
                report(int(record["iteration"]), config.iterations, note)

            network, history = LEARNERS[cell.learner].train(problems, config, progress, inspect, checkpoint)
        moments["end"] = [problem_table(network, problem)[0] for problem in problems]
        moments.setdefault("middle", moments["end"])
        return moments, history


def _normal(table: NDArray[np.float16]) -> NDArray[np.float64]:
    """What was rounded to be stored, with sums of 1 again."""
    exact = table.astype(np.float64)
    return exact / exact.sum(axis=-1, keepdims=True)


def _random_walk(problems: Sequence[Problem]) -> dict[str, list[NDArray[np.float32]]]:
    walk = []
    for task in (problem.task for problem in problems):
        count = len(task.actions)
        walk.append(np.full((*task.goals.shape, count), 1 / count, np.float32))
    return dict.fromkeys(MOMENTS, walk)


def _evaluated(evaluations: Any) -> dict[str, Any]:
    evaluation: Evaluation = mean_evaluation(list(evaluations))
    return evaluation.as_dict()
