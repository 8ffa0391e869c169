"""How many environment steps a second: one search, many side by side, and the bare stepping that PPO trains on."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from gymnasium.vector import SyncVectorEnv
from gymnasium.vector.vector_env import VectorEnv
from matplotlib.figure import Figure

from active_perceiver.benchmarks.config import EnvSpeedConfig
from active_perceiver.benchmarks.env.report import format_env_speed, speed_curves
from active_perceiver.benchmarks.runner import Benchmark, ResultBody
from active_perceiver.envs import REWARDS, Observations, SearchEnv, Searches, SearchTask, SearchVectorEnv
from active_perceiver.errors import UserError
from active_perceiver.figures.speed import speed_figure
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet

FEATURES = 672
"""Backbone features of a view, as many as EfficientNet-Lite0's."""
ROUNDS = 5
"""Times each speed is measured; the spread between them is what else the machine did."""
MAX_STEPS = 5000
# Random actions are drawn before the clock runs; so many are gone through again and again.
_DRAWN = 4096

Step = Callable[[], object]


@dataclass(frozen=True)
class EnvBenchmark(Benchmark):
    """Environment steps per second."""

    name = "env"
    settings: EnvSpeedConfig

    def prepare(self) -> None:
        """See `Benchmark`."""
        seconds, counts = self.settings.seconds, self.settings.counts
        if seconds <= 0 or not counts or min(counts) < 1:
            raise UserError(f"time and numbers of searches must be positive, got {seconds} s and {list(counts)}")

    def measure(self, store: RunStore) -> ResultBody:
        """See `measure_env_speed`."""
        scene = open_scene(self.settings.scene)
        with progress_bar("speeds") as report:
            return measure_env_speed(scene, self.settings.seconds, self.settings.counts, report)

    def report(self, body: ResultBody) -> str:
        """See `format_env_speed`."""
        return format_env_speed(body)

    def figure(self, body: ResultBody) -> Figure:
        """Steps per second over the number of searches."""
        return speed_figure(speed_curves(body))


def measure_env_speed(
    scene: Scene, seconds: float, counts: Sequence[int], progress: ProgressCallback = quiet
) -> dict[str, Any]:
    """Steps per second of all environments in one scene, random actions, on one core.

    An episode that ends is followed by another; beginning it is part of the time and no step. Observations are
    features with ground-truth masks; the features are random numbers, of which only how many there are matters.

    Args:
        scene: where to search, for all of its targets.
        seconds: how long to measure each environment.
        counts: numbers of searches side by side.
        progress: called with the speeds measured and to measure.

    Returns:
        "protocol"; "speeds": a list of {"environment", "searches", "steps": how many were timed, "per_second":
        {"median", "least", "most"} of the rounds}.
    """
    task = SearchTask.from_scene(scene)
    observations = _random_features(scene, task)
    make = partial(SearchEnv, task=task, observations=observations, max_steps=MAX_STEPS)
    jobs: list[tuple[str, int, Step]] = [("SearchEnv", 1, _scalar_step(make(), len(task.actions)))]
    for count in counts:
        sync = SyncVectorEnv([make] * count)
        native = SearchVectorEnv(count, task=task, observations=observations, max_steps=MAX_STEPS)
        jobs += [
            ("SyncVectorEnv", count, _vector_step(sync, len(task.actions))),
            ("SearchVectorEnv", count, _vector_step(native, len(task.actions))),
            ("Searches", count, _table_step(task, count)),
        ]
    speeds = []
    for number, (name, count, step) in enumerate(jobs):
        progress(number, len(jobs), f"{name}, {count}")
        calls, rates = _rates(step, seconds / ROUNDS)
        per_second = {"median": np.median(rates), "least": min(rates), "most": max(rates)}
        speeds.append(
            {
                "environment": name,
                "searches": count,
                "steps": calls * count,
                "per_second": {key: float(rate) * count for key, rate in per_second.items()},
            }
        )
    progress(len(jobs), len(jobs))
    protocol = {
        "scene": scene.name,
        "states": len(task),
        "targets": len(task.targets),
        "features": f"{FEATURES} random numbers",
        "actions": "random",
        "max_steps": MAX_STEPS,
        "seconds": seconds,
        "rounds": ROUNDS,
        "processes": 1,
    }
    return {"protocol": protocol, "speeds": speeds}


def _random_features(scene: Scene, task: SearchTask) -> Observations:
    rng = np.random.default_rng(0)
    pictures = min(target.trained for target in scene.targets)
    views = rng.random((len(task), FEATURES), np.float32)
    return Observations.from_boxes(
        views, rng.random((len(task.targets), pictures, FEATURES), np.float32), scene.boxes
    )


def _rates(step: Step, seconds: float) -> tuple[int, list[float]]:
    """Calls of a step that were timed, and calls per second of each round."""
    step()  # sets up what all need
    total, rates = 0, []
    for _ in range(ROUNDS):
        calls, started = 0, time.perf_counter()
        while (passed := time.perf_counter() - started) < seconds or not calls:
            step()
            calls += 1
        total += calls
        rates.append(calls / passed)
    return total, rates


def _scalar_step(env: SearchEnv, actions: int) -> Step:
    env.reset(seed=0)
    drawn = itertools.cycle(np.random.default_rng(0).integers(actions, size=_DRAWN))

    def step() -> None:
        _, _, terminated, truncated, _ = env.step(next(drawn))
        if terminated or truncated:
            env.reset()

    return step


def _vector_step(env: VectorEnv[Any, Any, Any], actions: int) -> Step:
    """Both kinds of vector environment begin the next episode themselves."""
    env.reset(seed=0)
    return _on_random_actions(env.step, actions, env.num_envs)


def _table_step(task: SearchTask, count: int) -> Step:
    """As PPO's rollouts step; see `RolloutWorker`."""
    rng = np.random.default_rng(0)
    searches = Searches(task, count, REWARDS["gain"], MAX_STEPS)

    def begin(which: Any) -> None:
        targets = rng.integers(len(task.targets), size=len(which))
        searches.begin(which, searches.random_starts(targets, rng), targets)

    def step(actions: Any) -> None:
        outcome = searches.step(actions)
        begin(np.flatnonzero(outcome.terminated | outcome.truncated))

    begin(np.arange(count))
    return _on_random_actions(step, len(task.actions), count)


def _on_random_actions(step: Callable[[Any], object], actions: int, count: int) -> Step:
    rows = np.random.default_rng(0).integers(actions, size=(max(2, _DRAWN // count), count))
    drawn = itertools.cycle(rows)
    return lambda: step(next(drawn))
