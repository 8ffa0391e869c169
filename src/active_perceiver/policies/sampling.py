"""Drawing actions from a policy table, and one search as a record of states and actions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError
from active_perceiver.policies.markov_chain import checked_table


class ActionSampler:
    """Draws actions for many searches at once.

    Args:
        table: (S, T, A) probabilities, sum to 1 over actions.
    """

    def __init__(self, table: NDArray[np.floating]) -> None:
        cumulative = np.cumsum(table, axis=-1, dtype=np.float32)
        # The last action takes what rounding leaves, so its own edge is never needed; an action before it that
        # has no probability must not win by rounding either, hence the division.
        self._edges = (cumulative / cumulative[..., -1:])[..., :-1]

    def sample(
        self, states: NDArray[np.integer], targets: NDArray[np.integer], rng: np.random.Generator
    ) -> NDArray[np.int64]:
        """One action for each of N searches: (N,) states and (N,) targets -> (N,)."""
        drawn = rng.random(len(states), dtype=np.float32)
        return (drawn[:, None] >= self._edges[states, targets]).sum(axis=1)


@dataclass(frozen=True, eq=False)
class Episode:
    """One search.

    Attributes:
        target: index of what was looked for.
        states: (n + 1,) where it was, the start first.
        actions: (n,) what it did.
        success: whether the last state is a goal.
    """

    target: int
    states: NDArray[np.int64]
    actions: NDArray[np.int64]
    success: bool

    def __len__(self) -> int:
        """Number of actions."""
        return len(self.actions)


def run_episode(
    table: NDArray[np.floating],
    task: SearchTask,
    target: int,
    start: int,
    rng: np.random.Generator | int = 0,
    limit: int = 5000,
) -> Episode:
    """Search once.

    Args:
        table: (S, T, A) probabilities, see `policy_table`.
        task: the search.
        target: index of the target.
        start: the first state; at a goal the episode has no action.
        rng: generator or seed.
        limit: most actions.

    Raises:
        SearchError: if the table does not fit the task, or there is no such target or state.
    """
    table = checked_table(table, task)
    if not 0 <= target < len(task.targets) or not 0 <= start < len(task):
        raise SearchError(f"no target {target} or no state {start} in the search in '{task.scene}'")
    rng = np.random.default_rng(rng)
    sampler = ActionSampler(table[:, target : target + 1])
    states = [start]
    actions: list[int] = []
    while not task.goals[states[-1], target] and len(actions) < limit:
        action = int(sampler.sample(np.array(states[-1:]), np.zeros(1, np.int64), rng)[0])
        actions.append(action)
        states.append(int(task.transitions[states[-1], action]))
    success = bool(task.goals[states[-1], target])
    return Episode(target, np.array(states, np.int64), np.array(actions, np.int64), success)
