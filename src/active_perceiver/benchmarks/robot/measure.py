"""`benchmark robot`: how often a robot that is never quite on the lattice finds its targets, and what it takes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from active_perceiver.agent.config import AgentConfig
from active_perceiver.agent.goals import GOALS
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import RobotBenchmarkConfig
from active_perceiver.benchmarks.robot.report import format_robot
from active_perceiver.benchmarks.robot.worker import Conditions, Lab, search_once, targets_in
from active_perceiver.benchmarks.runner import Benchmark, ResultBody, share_bars
from active_perceiver.errors import UserError
from active_perceiver.evaluation.stop_evaluation import TRUE_IOU
from active_perceiver.figures.robustness import robustness_figure
from active_perceiver.parallel.executor import SerialExecutor
from active_perceiver.parallel.process_pool import ProcessExecutor
from active_perceiver.parallel.run_missing import records_of
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.simulation.simulated_robot import scene_of
from active_perceiver.utils.progress import progress_bar


@dataclass(frozen=True)
class Row:
    """One line of the table: an agent, under some conditions.

    Attributes:
        label: what is different.
        agent: its folder.
        conditions: how it searches, and how far from the lattice.
        count: how many searches.
    """

    label: str
    agent: Path
    conditions: Conditions
    count: int


@dataclass
class RobotBenchmark(Benchmark):
    """How often a robot that is never quite on the lattice finds its targets.

    Attributes:
        agents: folders; all but the last one are compared with the last one under all changes.
        settings: where, and how often.
    """

    name = "robot"
    agents: Sequence[Path]
    settings: RobotBenchmarkConfig

    def prepare(self) -> Mapping[str, Any]:
        """See `Benchmark`."""
        self.rows = {row.label: row for row in _rows(self.agents, self.settings)}
        return {**asdict(self.settings), "agents": [_fingerprint(agent) for agent in self.agents]}

    def measure(self, store: RunStore) -> ResultBody:
        """Search, row by row.

        Returns:
            "protocol", and "rows", each with "label", "agent" (how it was trained), "conditions", "searches", the
            shares "true_found", "false_found" and "not_found", "interval" (Wilson's, of the first, 95 %), "actions"
            (the mean of true ones), "metres_off" and "degrees_off" (mean and largest distance from where a robot on
            the lattice would be at the end), "collisions" (the mean) and "per_target".
        """
        targets = targets_in(ActivePerceiver.from_pretrained(self.agents[-1], 1), scene_of(self.settings.room))
        rows = records_of(SerialExecutor(), store, measured_row, self.rows, self.settings)
        protocol = {**asdict(self.settings), "true_iou": TRUE_IOU, "targets": targets}
        return {"protocol": protocol, "rows": list(rows.values())}

    def report(self, body: ResultBody) -> str:
        """See `format_robot`."""
        return format_robot(body)

    def figure(self, body: ResultBody) -> Figure:
        """Shares of searches by row."""
        return robustness_figure(share_bars(body["rows"], "label"))


def measured_row(settings: RobotBenchmarkConfig, row: Row) -> dict[str, Any]:
    """Search as a row says, in several processes; see `RobotBenchmark.measure`."""
    lab = Lab(row.agent, settings.room, row.conditions, settings)
    executor = ProcessExecutor(min(settings.workers, row.count))
    with progress_bar(row.label) as report:
        ends = list(executor.map(search_once, range(row.count), lab, report))
    return {
        **_measured(ends),
        "label": row.label,
        "agent": _training(row.agent),
        "conditions": asdict(row.conditions),
    }


def _rows(agents: Sequence[Path], settings: RobotBenchmarkConfig) -> Iterator[Row]:
    """Everything that is measured, in the order of the table."""
    if not agents:
        raise UserError("name at least one agent")
    if min(settings.starts, settings.compared, settings.max_steps, settings.workers) < 1:
        raise UserError("starts, compared, max_steps and workers must be at least 1")
    scene = scene_of(settings.room)
    for agent in agents:
        config = ActivePerceiver.from_pretrained(agent, 1).config
        if not GOALS[config.task].has_boxes:
            raise UserError(f"{agent} searches for views; this benchmark is of searches for objects: give another")
        if scene not in (known := config.branches):
            raise UserError(f"{agent} was not trained in {scene}, but in {', '.join(known)}; give the room of one")
    last = agents[-1]
    everything = Conditions(settings.centimetres, settings.degrees, odometry_noise=True, nudge=settings.nudge)
    exact = Conditions(0.0, 0.0, odometry_noise=False, nudge=0.0)
    few = settings.compared
    yield Row("on the lattice, as trained", last, replace(exact, own_hour=True, perfect=True), few)
    yield Row("on the lattice, at that hour", last, exact, few)
    yield Row("off the lattice", last, replace(everything, nudge=0.0), few)
    yield Row("things nudged as well: all changes", last, everything, settings.starts)
    for agent in agents[:-1]:
        yield Row(f"all changes, {trained_on(agent)}", agent, everything, few)


def trained_on(agent: Path) -> str:
    """What an agent's policy was shown besides the views as they are."""
    training = AgentConfig.load(agent).training
    if not training.view_augmentation:
        return "trained on the views alone"
    return "trained in other light too" + (", and from near by" if training.viewpoint_jitter_degrees else "")


def _training(agent: Path) -> dict[str, float]:
    training = AgentConfig.load(agent).training
    return {name: float(getattr(training, name)) for name in ("view_augmentation", "viewpoint_jitter_degrees")}


def _fingerprint(agent: Path) -> str:
    digest = hashlib.sha256()
    for name in ("config.json", "policy.onnx", "recogniser.onnx"):
        digest.update((agent / name).read_bytes())
    return digest.hexdigest()[:16]


def _measured(ends: Sequence[dict[str, Any]]) -> dict[str, Any]:
    true = np.array([end["true"] for end in ends])
    found = np.array([end["found"] for end in ends])
    metres, degrees = (np.array([end[name] for end in ends]) for name in ("metres_off", "degrees_off"))
    names = sorted({end["target"] for end in ends})
    return {
        "searches": len(ends),
        "true_found": float(true.mean()),
        "false_found": float((found & ~true).mean()),
        "not_found": float((~found).mean()),
        "interval": wilson(int(true.sum()), len(ends)),
        "actions": float(np.mean([end["actions"] for end in ends if end["true"]])) if true.any() else None,
        "metres_off": [float(metres.mean()), float(metres.max())],
        "degrees_off": [float(degrees.mean()), float(degrees.max())],
        "collisions": float(np.mean([end["collisions"] for end in ends])),
        "per_target": {
            name: float(np.mean([end["true"] for end in ends if end["target"] == name])) for name in names
        },
    }


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Wilson's score interval of a share, 95 %; https://doi.org/10.1080/01621459.1927.10502953.

    Args:
        hits: how many of them.
        count: of how many, at least 1.

    Returns:
        Its ends, in 0..1.
    """
    z = 1.959964
    share, spread = hits / count, z * z / count
    middle = share + spread / 2
    half = z * np.sqrt(share * (1 - share) / count + spread / (4 * count))
    return float((middle - half) / (1 + spread)), float((middle + half) / (1 + spread))
