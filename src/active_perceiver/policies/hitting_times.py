"""When the searches of a policy arrive: the distribution of the number of actions to a goal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.task import SearchTask
from active_perceiver.policies.markov_chain import markov_chain

LIMIT = 5000
"""Steps after which a search has failed (the paper, section V)."""

# A chain is followed no further than to where so little probability is under way that no figure can change.
NEGLIGIBLE = 1e-9
# Steps of a chain that are summed up together.
BLOCK = 64


@dataclass(frozen=True, eq=False)
class HittingTimes:
    """When searches arrive, for each of n starts or of n episodes.

    Attributes:
        shortest: (n,) fewest actions possible.
        success: (n,) probability of arriving within the limit.
        steps: (n,) sum over arrival times of probability times actions.
        inverse_steps: (n,) sum over arrival times of probability / actions.
        histogram: (limit + 1,) probability of arriving with exactly so many actions, mean over the n.
    """

    shortest: NDArray[np.int64]
    success: NDArray[np.float64]
    steps: NDArray[np.float64]
    inverse_steps: NDArray[np.float64]
    histogram: NDArray[np.float64]


def exact_hitting_times(
    probabilities: NDArray[np.floating], task: SearchTask, target: int, limit: int = LIMIT
) -> HittingTimes:
    """The distribution of the number of actions to a goal from every start, without sampling.

    The probability to arrive after exactly k actions obeys a_k = Q a_(k-1), where Q is the chain among the starts
    and a_1 the probability of stepping into a goal; what steps to where no goal can be reached is lost.

    Args:
        probabilities: (S, A) of the actions, for this target.
        task: the search.
        target: index of the target.
        limit: most actions.
    """
    among = task.steps[:, target] > 0
    chain = markov_chain(task, probabilities, among)
    into_goal = task.goals[task.transitions[among], target]
    arriving = (probabilities[among].astype(np.float64) * into_goal).sum(axis=1)
    pair = np.column_stack([arriving, chain @ np.ones(len(arriving))])  # arriving now, still under way
    success, steps, inverse_steps = np.zeros((3, len(arriving)))
    histogram = np.zeros(limit + 1)
    block = np.empty((BLOCK, len(arriving)))
    for first in range(1, limit + 1, BLOCK):
        counts = np.arange(first, min(first + BLOCK, limit + 1))
        arrived = block[: len(counts)]
        for row in arrived:
            row[:] = pair[:, 0]
            pair = chain @ pair
        success += arrived.sum(axis=0)
        steps += counts @ arrived
        inverse_steps += (1 / counts) @ arrived
        histogram[counts] = arrived.mean(axis=1)
        if pair[:, 1].max() < NEGLIGIBLE:
            break
    return HittingTimes(task.steps[among, target], success, steps, inverse_steps, histogram)


def episode_hitting_times(shortest: NDArray[np.int64], taken: NDArray[np.int64], limit: int) -> HittingTimes:
    """The same of n episodes.

    Args:
        shortest: (n,) fewest actions from their starts.
        taken: (n,) actions that they took; 0 for those that did not arrive.
        limit: most actions.
    """
    success = (taken > 0).astype(np.float64)
    histogram = np.bincount(taken, minlength=limit + 1) / len(taken)
    histogram[0] = 0.0
    return HittingTimes(shortest, success, taken.astype(np.float64), success / np.maximum(taken, 1), histogram)
