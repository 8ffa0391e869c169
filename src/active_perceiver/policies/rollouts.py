"""Rollouts by table look-ups, and what their steps were worth; no torch."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.batched_search import Searches
from active_perceiver.envs.rewards import Reward
from active_perceiver.envs.task import SearchTask
from active_perceiver.policies.sampling import ActionSampler


class Rollout(NamedTuple):
    """Steps of N searches that ran side by side, all (steps, N).

    Attributes:
        states: before the action.
        targets: what was looked for.
        actions: what was done.
        rewards: what was paid.
        next_states: the state after the action, before any new episode began.
        terminated: a goal was reached.
        done: the episode ended there, at a goal or for want of steps.
    """

    states: NDArray[np.int64]
    targets: NDArray[np.int64]
    actions: NDArray[np.int64]
    rewards: NDArray[np.float64]
    next_states: NDArray[np.int64]
    terminated: NDArray[np.bool_]
    done: NDArray[np.bool_]


class RolloutWorker:
    """Searches that go on from one rollout to the next; an episode that ends is followed by one from a random start.

    Args:
        task: the search; each of its targets is looked for by as many searches.
        count: number of searches, N.
        reward: what is paid; divided by its largest value, so that returns are of order 1.
        max_steps: actions after which an episode is cut off.
        rng: draws starts and actions.
    """

    def __init__(
        self, task: SearchTask, count: int, reward: Reward, max_steps: int, rng: np.random.Generator
    ) -> None:
        self._searches = Searches(task, count, reward, max_steps)
        self._unit = reward.largest(task)
        self._rng = rng
        targets = np.arange(count) % len(task.targets)
        self._searches.begin(np.arange(count), self._searches.random_starts(targets, rng), targets)

    def run(self, table: NDArray[np.floating], steps: int) -> Rollout:
        """Take some steps in every search.

        Args:
            table: (S, T, A) probabilities of actions.
            steps: how many.
        """
        searches, sampler = self._searches, ActionSampler(table)
        rows = []
        for _ in range(steps):
            states = searches.states
            actions = sampler.sample(states, searches.targets, self._rng)
            outcome = searches.step(actions)
            done = outcome.terminated | outcome.truncated
            reward = outcome.rewards / self._unit
            rows.append((states, searches.targets, actions, reward, searches.states.copy(), outcome.terminated, done))
            which = np.flatnonzero(done)
            targets = searches.targets[which]
            searches.begin(which, searches.random_starts(targets, self._rng), targets)
        return Rollout(*(np.stack(column) for column in zip(*rows, strict=True)))


def estimate_advantages(
    rollout: Rollout, values: NDArray[np.floating], gamma: float, gae_lambda: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Generalised advantage estimation (Schulman et al. 2016).

    At a goal nothing follows. An episode that was merely cut off, or that goes on after the rollout, is credited with
    the value of the state it was in.

    Args:
        rollout: of N searches.
        values: (S, T) of the policy that made it.
        gamma: discount.
        gae_lambda: lambda.

    Returns:
        Advantages and returns (targets for the values), both (steps, N).
    """
    before = values[rollout.states, rollout.targets].astype(np.float64)
    after = np.where(rollout.terminated, 0.0, values[rollout.next_states, rollout.targets])
    td_error = rollout.rewards + gamma * after - before
    advantages = np.empty_like(td_error)
    trace = np.zeros(td_error.shape[1])
    for step in reversed(range(len(td_error))):
        trace = td_error[step] + gamma * gae_lambda * np.where(rollout.done[step], 0.0, trace)
        advantages[step] = trace
    return advantages, advantages + before
