"""What training a policy costs in time and memory, as scenes get more and larger; the scenes are synthetic."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from matplotlib.figure import Figure

from active_perceiver.benchmarks.config import ScaleConfig
from active_perceiver.benchmarks.runner import Benchmark, ResultBody
from active_perceiver.benchmarks.scale.clock import RATIOS
from active_perceiver.benchmarks.scale.report import cost_curves, format_scale
from active_perceiver.benchmarks.scale.synthetic_scenes import FEATURES, PICTURES, VIEWS_PER_PLACE, synthetic_tasks
from active_perceiver.benchmarks.scale.worker import CHECK_LIMIT, measure_training
from active_perceiver.errors import UserError
from active_perceiver.figures.scaling import scaling_figure
from active_perceiver.parallel.executor import Executor
from active_perceiver.parallel.fresh_process import FreshProcessExecutor
from active_perceiver.parallel.run_missing import records_of
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.policies.learners import LEARNERS, learner_named
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet

Cell = tuple[str, int, int]
"""A learner, a number of scenes, and the states that each was asked to have."""


@dataclass(frozen=True)
class ScaleBenchmark(Benchmark):
    """What training costs as scenes get more and larger."""

    name = "scale"
    settings: ScaleConfig
    executor: Executor | None = None

    def prepare(self) -> Mapping[str, Any]:
        """See `Benchmark`."""
        check_settings(self.settings)
        return asdict(self.settings)

    def measure(self, store: RunStore) -> ResultBody:
        """See `measure_scale`."""
        executor = self.executor or FreshProcessExecutor(self.settings.threads)
        with progress_bar("trainings") as report:
            return measure_scale(self.settings, store, executor, report)

    def report(self, body: ResultBody) -> str:
        """See `format_scale`."""
        return format_scale(body)

    def figure(self, body: ResultBody) -> Figure:
        """Time and memory over the number of states."""
        return scaling_figure(*cost_curves(body))


def check_settings(settings: ScaleConfig) -> None:
    """Make sure that settings make sense, before anything is measured.

    Raises:
        UserError: if they do not; the message says why.
    """
    for label in ("scenes", "states", "learners"):
        values: tuple[Any, ...] = getattr(settings, label)
        if not values or len(set(values)) != len(values):
            raise UserError(f"name each of the {label} once, at least one; got {list(values)}")
    for name in settings.learners:
        learner_named(name)
    numbers = (*settings.scenes, settings.targets, settings.threads, settings.most_states)
    if min(numbers) < 1 or (settings.iterations is not None and settings.iterations < 1):
        raise UserError("numbers of scenes, states, targets, threads and iterations must be at least 1")
    if not settings.seconds > 0:
        raise UserError(f"a training needs some seconds, got {settings.seconds}")
    if not cells_of(settings):
        raise UserError(f"no scenes have at most {settings.most_states} states together; allow more --most-states")
    # Whether the targets fit shows in the smallest scenes.
    synthetic_tasks(1, min(settings.states), settings.targets, settings.seed)


def cells_of(settings: ScaleConfig) -> list[Cell]:
    """What is trained: small scenes first, since they are done soon."""
    return [
        (learner, scenes, states)
        for states in settings.states
        for scenes in settings.scenes
        if scenes * states <= settings.most_states
        for learner in settings.learners
    ]


def measure_scale(
    settings: ScaleConfig, store: RunStore, executor: Executor, progress: ProgressCallback = quiet
) -> ResultBody:
    """Train in every combination of scenes and states, one after the other.

    Args:
        settings: how many, how large, who, and for how long.
        store: keeps the runs.
        executor: gives each training a process of its own.
        progress: called with the trainings done and to do.

    Returns:
        "protocol"; "runs": for each training what `worker.measure_training` says.
    """
    cells = {
        f"{learner}, {scenes} x {states}": (learner, scenes, states) for learner, scenes, states in cells_of(settings)
    }
    runs = records_of(executor, store, measure_training, cells, settings, progress)
    protocol = {
        **asdict(settings),
        "views_per_place": VIEWS_PER_PLACE,
        "features": FEATURES,
        "pictures": PICTURES,
        "boxes": "ground truth",
        "ratios": RATIOS,
        "check_limit": CHECK_LIMIT,
        "clock": "training without measurements, after one iteration in another scene that does not count",
        "settings": {name: asdict(LEARNERS[name].config()) for name in settings.learners},
    }
    return {"protocol": protocol, "runs": list(runs.values())}
