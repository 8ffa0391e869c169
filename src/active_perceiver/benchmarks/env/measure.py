"""How many environment steps a second: one search, many side by side, and the bare stepping that PPO trains on."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.vector import SyncVectorEnv
from gymnasium.vector.vector_env import VectorEnv

from active_perceiver.benchmarks.outputs import check_outputs, write_outputs
from active_perceiver.envs import REWARDS, Observations, SearchEnv, Searches, SearchTask, SearchVectorEnv
from active_perceiver.errors import UserError
from active_perceiver.figures.speed import speed_figure
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet

COUNTS = (1, 16, 64, 256, 1024)
FEATURES = 672
"""Backbone features of a view, as many as EfficientNet-Lite0's."""
ROUNDS = 5
"""Times each speed is measured; the spread between them is what else the machine did."""
MAX_STEPS = 5000
# Random actions are drawn before the clock runs; so many are gone through again and again.
_DRAWN = 4096

Step = Callable[[], object]


def env_speed_command(
    scene: str,
    seconds: float,
    counts: Sequence[int] = COUNTS,
    out: Path | None = None,
    picture: Path | None = None,
    *,
    force: bool = False,
) -> dict[str, Any]:
    """Measure, print a table, write the result and the picture if they are asked for.

    Returns:
        The body of the result file, see `measure_env_speed`.

    Raises:
        OutputExistsError: if a file exists and `force` is false.
        SceneError: if there is no such scene.
        UserError: if `seconds` or `counts` make no sense.
    """
    check_outputs(force, out, picture)
    opened = open_scene(scene)
    with progress_bar("speeds") as report:
        body = measure_env_speed(opened, seconds, counts, report)
    print(format_env_speed(body))
    write_outputs("benchmark env", body, out, picture, lambda: speed_figure(_curves(body)))
    return body


def measure_env_speed(
    scene: Scene, seconds: float, counts: Sequence[int] = COUNTS, progress: ProgressCallback = quiet
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

    Raises:
        UserError: if `seconds` is not positive or a count is less than 1.
    """
    if seconds <= 0 or not counts or min(counts) < 1:
        raise UserError(f"time and numbers of searches must be positive, got {seconds} s and {list(counts)}")
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


def format_env_speed(body: dict[str, Any]) -> str:
    """A table of what `measure_env_speed` found."""
    protocol = body["protocol"]
    lines = [
        f"{protocol['scene']}: {protocol['states']} states, {protocol['targets']} targets, observations of"
        f" {protocol['features']}; steps per second, all searches together",
        f"{'environment':18}{'searches':>9}{'median':>13}{'least':>13}{'most':>13}",
    ]
    for speed in body["speeds"]:
        rate = speed["per_second"]
        lines.append(
            f"{speed['environment']:18}{speed['searches']:9}"
            + "".join(f"{rate[key]:13,.0f}" for key in ("median", "least", "most")).replace(",", " ")
        )
    lines += [
        "SearchEnv: Gymnasium, one search. SyncVectorEnv: Gymnasium's, of as many SearchEnv. SearchVectorEnv: this",
        "project's, with observations. Searches: the stepping below it, without observations, on which PPO trains.",
    ]
    return "\n".join(lines)


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


def _curves(body: dict[str, Any]) -> dict[str, list[tuple[int, float, float, float]]]:
    """By environment: searches; least, median and most steps per second."""
    curves: dict[str, list[tuple[int, float, float, float]]] = {}
    for speed in body["speeds"]:
        rate = speed["per_second"]
        point = (speed["searches"], rate["least"], rate["median"], rate["most"])
        curves.setdefault(speed["environment"], []).append(point)
    return curves
