"""One worker of A3C: episodes of one search with its own copy of the weights, and the gradient of what it lived."""

from __future__ import annotations

import copy
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from active_perceiver.policies.config import A3cConfig, reward_of
from active_perceiver.policies.network import PolicyNetwork
from active_perceiver.policies.training_task import TrainingTask


@dataclass(frozen=True, eq=False)
class SharedWeights:
    """What all workers read and write, without waiting for one another (Hogwild, as in Mnih et al. 2016).

    Attributes:
        network: the shared network.
        squares: for each of its parameters the running mean of squared gradients.
    """

    network: PolicyNetwork
    squares: list[Tensor]

    @classmethod
    def of(cls, network: PolicyNetwork) -> SharedWeights:
        """Weights that no update has changed yet."""
        return cls(network, [torch.zeros_like(parameter.data) for parameter in network.parameters()])

    def share(self) -> None:
        """Move them to memory that other processes can write."""
        self.network.share_memory()
        for square in self.squares:
            square.share_memory_()

    def copy_to(self, own: PolicyNetwork) -> None:
        """Bring a worker's own network up to date."""
        with torch.no_grad():
            for mine, shared in zip(own.parameters(), self.network.parameters(), strict=True):
                mine.copy_(shared)

    def update(self, gradients: PolicyNetwork, learning_rate: float, config: A3cConfig) -> None:
        """RMSProp with shared statistics, as in Zhu's code: epsilon is added below the root.

        Args:
            gradients: a worker's own network after `backward`; branches it has no gradients for stay as they are.
            learning_rate: of this update.
            config: has decay and epsilon.
        """
        with torch.no_grad():
            for mine, shared, square in zip(
                gradients.parameters(), self.network.parameters(), self.squares, strict=True
            ):
                if mine.grad is not None:
                    square.mul_(config.decay).addcmul_(mine.grad, mine.grad, value=1 - config.decay)
                    shared.addcdiv_(mine.grad, (square + config.epsilon).sqrt_(), value=-learning_rate)


@dataclass(frozen=True, eq=False)
class Segment:
    """The steps between two updates, n of them.

    Attributes:
        states: (n,) before each action.
        actions: (n,) what was done.
        rewards: (n,) what was paid.
        last: the state after the last action.
        arrived: whether that is a goal.
    """

    states: NDArray[np.int64]
    actions: NDArray[np.int64]
    rewards: NDArray[np.float64]
    last: int
    arrived: bool

    def returns(self, last_value: float, gamma: float) -> NDArray[np.float64]:
        """(n,) discounted sums of the rewards to come; beyond the segment stands the value of its last state."""
        future = 0.0 if self.arrived else last_value
        returns = []
        for reward in reversed(self.rewards.tolist()):
            future = reward + gamma * future
            returns.append(future)
        return np.array(returns[::-1])


class EpisodeWorker:
    """Searches for one target in one scene, again and again.

    Args:
        training_task: the scene.
        target: index of the target.
        network: is copied.
        config: of the learner.
        number: of this worker; its draws follow from the seed, this number and the number of the episode.
        episodes: how many it has lived before.
    """

    def __init__(
        self,
        training_task: TrainingTask,
        target: int,
        network: PolicyNetwork,
        config: A3cConfig,
        number: int,
        episodes: int = 0,
    ) -> None:
        task, seen = training_task.task, training_task.observations
        self.number = number
        self.episodes = episodes
        self._network = copy.deepcopy(network)
        self._config = config
        self._task = task
        self._target = target
        self._starts = task.starts(target)
        # One step is a few look-ups in plain lists, which are faster than arrays one element at a time.
        self._transitions: list[list[int]] = task.transitions.tolist()
        self._goals: list[bool] = task.goals[:, target].tolist()
        self._views = torch.from_numpy(seen.view_features)
        self._pictures = torch.from_numpy(seen.target_features[target])
        self._masks = torch.from_numpy(seen.masks[:, target])

    def episode(self, shared: SharedWeights, next_update: Callable[[], int | None]) -> int:
        """Live one episode; the shared weights are updated at its end, or every few steps.

        Args:
            shared: the weights of all workers.
            next_update: gives the number of the update that is due, from 0, or None if there shall be no more.

        Returns:
            Number of steps.
        """
        config = self._config
        rng = np.random.default_rng([config.seed, self.number, self.episodes])
        self.episodes += 1
        picture = int(rng.integers(len(self._pictures)))
        state = int(rng.choice(self._starts))
        best_area = float(self._task.areas[state, self._target])
        steps = 0
        while not self._goals[state] and steps < config.max_steps:
            shared.copy_to(self._network)
            most = min(config.update_steps or config.max_steps, config.max_steps - steps)
            segment = self.roll_out(state, best_area, picture, most, rng)
            loss = self.loss(segment, picture)
            update = next_update()
            if update is None:
                break
            self._network.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(self._network.parameters(), config.max_grad_norm)
            shared.update(self._network, config.learning_rate_at(update), config)
            steps += len(segment.states)
            state = segment.last
            areas = self._task.areas[self._task.transitions[segment.states, segment.actions], self._target]
            best_area = max(best_area, float(areas.max()))
        return steps

    def roll_out(self, state: int, best_area: float, picture: int, most: int, rng: np.random.Generator) -> Segment:
        """Act with the own copy of the weights until a goal is reached or `most` steps are taken.

        Args:
            state: where to begin, not at a goal.
            best_area: largest area seen in the episode so far.
            picture: which of the target's pictures is shown.
            most: steps, at least 1.
            rng: draws the actions.
        """
        draws = rng.random(most).tolist()
        edges = self._edges(picture, every=most >= len(self._task))
        states, actions = [], []
        for draw in draws:
            action = bisect_right(edges(state), draw)
            states.append(state)
            actions.append(action)
            state = self._transitions[state][action]
            if self._goals[state]:
                break
        visited, done = np.array(states), np.array(actions)
        after = self._task.transitions[visited, done]
        areas, goals = self._task.areas[after, self._target], self._task.goals[after, self._target]
        best_areas = np.maximum.accumulate(np.concatenate([[best_area], areas[:-1]])).astype(areas.dtype)
        rewards = reward_of(self._config).function(areas, best_areas, goals, self._task.goal_areas[self._target])
        return Segment(
            visited, done, self._config.reward_scale * np.asarray(rewards, np.float64), state, bool(goals[-1])
        )

    def _edges(self, picture: int, every: bool) -> Callable[[int], list[float]]:
        """Where in 0..1 a draw means the next action, for any state.

        Args:
            picture: which is shown.
            every: decide for all states at once, which pays if many will be visited.
        """
        known: dict[int, list[float]] = dict(enumerate(self._decide(slice(None), picture))) if every else {}

        def edges(state: int) -> list[float]:
            if state not in known:
                known[state] = self._decide(slice(state, state + 1), picture)[0]
            return known[state]

        return edges

    def _decide(self, states: slice, picture: int) -> list[list[float]]:
        with torch.no_grad():
            log_policy, _ = self.outputs(states, picture)
        # The last action takes what rounding leaves.
        return log_policy.double().exp().cumsum(-1)[:, :-1].tolist()

    def outputs(self, states: slice | NDArray[np.int64], picture: int) -> tuple[Tensor, Tensor]:
        """Log probabilities (n, A) and values (n,) of the own network."""
        log_policy, values = self._network.table(
            self._views[states],
            self._pictures[picture : picture + 1],
            self._masks[states, picture][:, None],
            self._task.scene,
        )
        return log_policy[:, 0], values[:, 0]

    def loss(self, segment: Segment, picture: int) -> Tensor:
        """The loss of Mnih et al. (2016), summed over the steps of a segment.

        The policy has no memory, so the steps in one state share one row of the network's outputs; the sum over steps
        is one over the distinct states, of which an episode of thousands of steps visits some hundred.
        """
        config = self._config
        rows, index = np.unique(segment.states, return_inverse=True)
        log_policy, values = self.outputs(rows, picture)
        with torch.no_grad():
            last_value = 0.0 if segment.arrived else float(self.outputs(np.array([segment.last]), picture)[1])
        returns = segment.returns(last_value, config.gamma)
        advantages = returns - values.detach().numpy().astype(np.float64)[index]
        actions = len(self._task.actions)

        def total(numbers: NDArray[np.int64], weights: NDArray[np.float64] | None, size: int) -> Tensor:
            return torch.from_numpy(np.bincount(numbers, weights, size).astype(np.float32))

        counts, returned = total(index, None, len(rows)), total(index, returns, len(rows))
        gained = total(index * actions + segment.actions, advantages, len(rows) * actions).view(-1, actions)
        entropy = -(log_policy.exp() * log_policy).sum(dim=-1)
        # The squared error summed over a state's returns, without the part that has no gradient.
        squared = counts * values**2 - 2 * values * returned
        return (
            -(gained * log_policy).sum() - config.entropy_weight * (counts * entropy).sum()
        ) + config.value_coef * squared.sum()
