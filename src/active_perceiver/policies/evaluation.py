"""How well a policy searches: exactly, from its Markov chain, and by episodes as in the paper (section V)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.batched_search import Searches
from active_perceiver.envs.rewards import REWARDS
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError
from active_perceiver.policies.hitting_times import LIMIT, HittingTimes, episode_hitting_times, exact_hitting_times
from active_perceiver.policies.markov_chain import checked_table
from active_perceiver.policies.sampling import ActionSampler


@dataclass(frozen=True)
class SearchResult:
    """How searches for one target went, or for several together (`target` is then "all").

    Attributes:
        scene: where.
        target: what was looked for.
        success: share of the searches that reached a goal within the limit, 0..1.
        mean_steps: actions, mean over the successful searches; NaN if none is.
        median_steps: actions, lower median over the successful searches; NaN if none is.
        shortest_mean: fewest actions possible, mean over the successful searches; NaN if none is.
        ratio: `mean_steps` over `shortest_mean`; 1 is perfect.
        spl: success weighted by path length, 0..1: mean of shortest / taken over all searches, 0 for failures.
    """

    scene: str
    target: str
    success: float
    mean_steps: float
    median_steps: float
    shortest_mean: float
    ratio: float
    spl: float


@dataclass(frozen=True)
class Evaluation:
    """The results for each target and over all.

    Attributes:
        protocol: how it was measured, for the result file.
        overall: over all targets, each with the same weight.
        per_target: one for each target.
    """

    protocol: dict[str, Any]
    overall: SearchResult
    per_target: tuple[SearchResult, ...]

    def as_dict(self) -> dict[str, Any]:
        """The parts `protocol`, `overall` and `per_target` of a result file; NaN, which JSON lacks, becomes None."""
        return {
            "protocol": self.protocol,
            "overall": _json_fields(self.overall),
            "per_target": [_json_fields(result) for result in self.per_target],
        }


def _json_fields(result: SearchResult) -> dict[str, Any]:
    return {key: None if value != value else value for key, value in asdict(result).items()}


def exact_evaluation(table: NDArray[np.floating], task: SearchTask, limit: int = LIMIT) -> Evaluation:
    """Evaluate a policy over all starts exactly.

    Args:
        table: (S, T, A) probabilities, see `policy_table`.
        task: the search.
        limit: actions after which a search has failed.

    Raises:
        SearchError: if the table does not fit the task or the limit is less than 1.
    """
    table = _checked(table, task, limit)
    arrivals = [exact_hitting_times(table[:, target], task, target, limit) for target in range(len(task.targets))]
    protocol = {"kind": "exact", "starts": "all from which a goal can be reached", "limit": limit}
    return _evaluation(task, arrivals, protocol)


def episode_evaluation(
    table: NDArray[np.floating],
    task: SearchTask,
    episodes: int = 10,
    limit: int = LIMIT,
    rng: np.random.Generator | int = 0,
) -> Evaluation:
    """Evaluate a policy as the paper does: some episodes per target from random starts.

    Args:
        table: (S, T, A) probabilities, see `policy_table`.
        task: the search.
        episodes: per target; 10 in the paper.
        limit: actions after which a search has failed.
        rng: generator or seed.

    Raises:
        SearchError: if the table does not fit the task, or a number is less than 1.
    """
    table = _checked(table, task, limit)
    if episodes < 1:
        raise SearchError(f"at least one episode per target is needed, got {episodes}")
    rng = np.random.default_rng(rng)
    count = len(task.targets)
    targets = np.repeat(np.arange(count), episodes)
    searches = Searches(task, len(targets), REWARDS["arrival"], limit)
    starts = searches.random_starts(targets, rng)
    searches.begin(np.arange(len(targets)), starts, targets)
    sampler = ActionSampler(table)
    taken = np.zeros(len(targets), np.int64)  # 0: has not arrived
    for step in range(1, limit + 1):
        arrived = searches.step(sampler.sample(searches.states, targets, rng)).terminated
        taken[arrived & (taken == 0)] = step
        if taken.all():
            break
    shortest = task.steps[starts, targets].reshape(count, episodes)
    arrivals = [
        episode_hitting_times(shortest[target], taken.reshape(count, episodes)[target], limit)
        for target in range(count)
    ]
    return _evaluation(task, arrivals, {"kind": "episodes", "episodes": episodes, "limit": limit})


def mean_evaluation(evaluations: Sequence[Evaluation]) -> Evaluation:
    """Put the evaluations of several scenes together: all targets' results, and their overall with equal weights.

    The overall median is the mean of the scenes' medians.

    Raises:
        SearchError: if there is none, or if the protocols differ.
    """
    if not evaluations or any(other.protocol != evaluations[0].protocol for other in evaluations):
        raise SearchError("only evaluations by the same protocol can be put together, at least one")
    per_target = tuple(result for evaluation in evaluations for result in evaluation.per_target)
    weights = np.array([len(evaluation.per_target) for evaluation in evaluations], float)
    medians = np.array([evaluation.overall.median_steps for evaluation in evaluations])
    scenes = ", ".join(evaluation.overall.scene for evaluation in evaluations)
    median = float((medians * weights).sum() / weights.sum())
    return Evaluation(evaluations[0].protocol, _overall(scenes, per_target, median), per_target)


def _checked(table: NDArray[np.floating], task: SearchTask, limit: int) -> NDArray[np.float64]:
    if limit < 1:
        raise SearchError(f"the limit is at least 1 step, got {limit}")
    return checked_table(table, task)


def _evaluation(task: SearchTask, arrivals: Sequence[HittingTimes], protocol: dict[str, Any]) -> Evaluation:
    per_target = tuple(_result(task.scene, name, some) for name, some in zip(task.targets, arrivals, strict=True))
    median = _median(np.sum([some.histogram for some in arrivals], axis=0))
    return Evaluation(protocol, _overall(task.scene, per_target, median), per_target)


def _result(scene: str, target: str, arrivals: HittingTimes) -> SearchResult:
    total = arrivals.success.sum()
    mean = float(arrivals.steps.sum() / total) if total > 0 else float("nan")
    # Averaged over the same searches as the steps, so that hard starts that fail do not flatter the ratio.
    shortest = float((arrivals.shortest * arrivals.success).sum() / total) if total > 0 else float("nan")
    return SearchResult(
        scene=scene,
        target=target,
        success=float(arrivals.success.mean()),
        mean_steps=mean,
        median_steps=_median(arrivals.histogram),
        shortest_mean=shortest,
        ratio=mean / shortest,
        spl=float((arrivals.shortest * arrivals.inverse_steps).mean()),
    )


def _overall(scene: str, results: Sequence[SearchResult], median: float) -> SearchResult:
    """Means over targets; steps are weighted by success, as if every target had had equally many episodes."""
    success = np.array([result.success for result in results])
    steps = np.array([result.mean_steps for result in results])
    shortest = np.array([result.shortest_mean for result in results])
    found = success > 0
    total = success.sum()
    mean = float((success * steps)[found].sum() / total) if total > 0 else float("nan")
    least = float((success * shortest)[found].sum() / total) if total > 0 else float("nan")
    spl = float(np.mean([result.spl for result in results]))
    return SearchResult(scene, "all", float(success.mean()), mean, median, least, mean / least, spl)


def _median(histogram: NDArray[np.float64]) -> float:
    total = histogram.sum()
    if total <= 0:
        return float("nan")
    # Rounding must not push the half past the step that reaches it.
    return float(np.searchsorted(np.cumsum(histogram), total * (0.5 - 1e-12)))
