"""A policy's figures by the protocol that is asked for, averaged over the pictures that a search may begin with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.task import SearchTask
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.policies.evaluation import (
    Evaluation,
    SearchResult,
    episode_evaluation,
    exact_evaluation,
    mean_evaluation,
)


def evaluate_tables(
    searches: Iterable[tuple[SearchTask, Sequence[NDArray[np.floating]]]], settings: EvaluateConfig
) -> Evaluation:
    """The evaluation of a policy in some scenes, each with every picture in turn.

    Args:
        searches: for each scene what is searched, and the (S, T, A) policy tables, one for each picture.
        settings: how to measure.
    """
    by_scene = []
    rng = np.random.default_rng(settings.seed)
    for task, tables in searches:
        if settings.protocol == "exact":
            evaluations = [exact_evaluation(table, task, settings.limit) for table in tables]
        else:
            evaluations = [
                episode_evaluation(table, task, settings.episodes, settings.limit, rng) for table in tables
            ]
        by_scene.append(mean_over_pictures(evaluations))
    return mean_evaluation(by_scene)


def mean_over_pictures(evaluations: Sequence[Evaluation]) -> Evaluation:
    """The evaluation of searches that each begin with one of several pictures, all equally likely."""
    first = evaluations[0]
    per_target = tuple(
        _mean_result([evaluation.per_target[index] for evaluation in evaluations])
        for index in range(len(first.per_target))
    )
    return replace(
        first,
        overall=_mean_result([evaluation.overall for evaluation in evaluations]),
        per_target=per_target,
    )


def _mean_result(results: Sequence[SearchResult]) -> SearchResult:
    success = np.array([result.success for result in results])

    def over_successes(name: str) -> float:
        values = np.array([getattr(result, name) for result in results])
        return float((values * success)[success > 0].sum() / success.sum()) if success.any() else float("nan")

    mean, shortest = over_successes("mean_steps"), over_successes("shortest_mean")
    return replace(
        results[0],
        success=float(success.mean()),
        mean_steps=mean,
        median_steps=over_successes("median_steps"),
        shortest_mean=shortest,
        ratio=mean / shortest,
        spl=float(np.mean([result.spl for result in results])),
    )
