"""Exact advantages of a policy: no rollouts, one sparse linear system per target."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from active_perceiver.envs.rewards import Reward
from active_perceiver.envs.task import SearchTask
from active_perceiver.policies.markov_chain import markov_chain


def exact_advantages(
    table: NDArray[np.floating], task: SearchTask, reward: Reward, gamma: float
) -> NDArray[np.float64]:
    """How much better each action is than what the policy does on average.

    Under a policy the values of the states that are no goals solve V = r + gamma P V, where r is the expected reward
    of a step and P the chain among these states (an episode ends at a goal). Then Q(s, a) = r(s, a) + gamma V(s'),
    and the advantage is Q - V.

    Args:
        table: (S, T, A) probabilities of actions.
        task: the search.
        reward: must be Markov; it is divided by its largest value, so that advantages are of order 1.
        gamma: discount, less than 1.

    Returns:
        (S, T, A); what is at goals has no meaning.
    """
    advantages = np.empty(table.shape)
    for target in range(len(task.targets)):
        probabilities = table[:, target].astype(np.float64)
        areas, goals = task.areas[task.transitions, target], task.goals[task.transitions, target]
        rewards = reward.function(areas, np.zeros_like(areas), goals, task.goal_areas[target]) / reward.largest(task)
        searching = ~task.goals[:, target]
        chain = markov_chain(task, probabilities, searching)
        expected = (probabilities * rewards).sum(axis=1)[searching]
        values = np.zeros(len(task))
        values[searching] = _solve(chain, gamma, expected)
        action_values = rewards + gamma * values[task.transitions]
        advantages[:, target] = action_values - (probabilities * action_values).sum(axis=1, keepdims=True)
    return advantages


def _solve(chain: sparse.csr_array, gamma: float, expected: NDArray[np.float64]) -> NDArray[np.float64]:
    system = sparse.eye_array(chain.shape[0], format="csc") - gamma * chain.tocsc()
    # A lattice's chain is nearly symmetric in structure, for which this ordering fills in least.
    return splu(system, permc_spec="MMD_AT_PLUS_A").solve(expected)
