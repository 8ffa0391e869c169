"""Proximal policy optimisation (Schulman et al. 2017) on tables: rewards may depend on the past of an episode.

The policy has no memory, so it is a function of the pair (view, target) alone, and a scene has only S x T such pairs.
One forward pass therefore decides every step of the rollouts, which are table look-ups; and the surrogate's gradient
over all samples is a sum over the pairs, with positive and negative advantages added up apart per pair and action,
since clipping treats the samples of one pair and action alike when their advantages have the same sign.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from active_perceiver.policies.config import PpoConfig, reward_of
from active_perceiver.policies.monitor import Monitor
from active_perceiver.policies.network import PolicyNetwork, picture_tensors, seeded_network
from active_perceiver.policies.rollouts import Rollout, RolloutWorker, estimate_advantages
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.sections import section


def train_ppo(training_tasks: Sequence[TrainingTask], config: PpoConfig, monitor: Monitor) -> PolicyNetwork:
    """Train a policy by PPO; see `Learner.train`."""
    network = seeded_network(training_tasks, config)
    rng = np.random.default_rng(config.seed)
    optimiser = torch.optim.Adam(network.parameters(), lr=config.learning_rate, fused=True)
    share = -(-config.num_envs // len(training_tasks))
    workers = [
        RolloutWorker(training_task.task, share, reward_of(config), config.max_steps, rng)
        for training_task in training_tasks
    ]
    samples = 0
    monitor.start()
    for iteration in range(config.iterations):
        optimiser.param_groups[0]["lr"] = config.learning_rate_at(iteration)
        scenes = _collect(network, training_tasks, workers, config, rng)
        samples += config.num_steps * share * len(training_tasks)
        entropy_weight = config.entropy_weight_at(iteration)
        for _ in range(config.epochs):
            for parts in zip(*(_state_parts(scene, config.minibatches, rng) for scene in scenes), strict=True):
                losses = [
                    scene.loss(network, states, config, entropy_weight)
                    for scene, states in zip(scenes, parts, strict=True)
                ]
                optimiser.zero_grad()
                with section("backward"):
                    torch.stack(losses).mean().backward()
                torch.nn.utils.clip_grad_norm_(network.parameters(), config.max_grad_norm)
                with section("optimiser"):
                    optimiser.step()
        if monitor.finished(network, iteration + 1, samples):
            break
    return network


@dataclass(frozen=True, eq=False)
class PairSums:
    """What a surrogate needs of the samples, summed per pair of a view and a target.

    Attributes:
        counts: (S, T) number of samples.
        returns: (S, T) sum of their returns.
        gains: (S, T, A) sum of the positive advantages of each action's samples.
        losses: (S, T, A) sum of the negative ones.
    """

    counts: Tensor
    returns: Tensor
    gains: Tensor
    losses: Tensor

    @classmethod
    def of(
        cls,
        shape: Sequence[int],
        rollout: Rollout,
        advantages: NDArray[np.floating],
        returns: NDArray[np.floating],
    ) -> PairSums:
        """Sum up a rollout's samples, all arrays (steps, N), for a table of `shape` (S, T, A)."""
        pairs = (rollout.states * shape[1] + rollout.targets).ravel()
        choices = pairs * shape[2] + rollout.actions.ravel()

        def total(index: NDArray[np.int64], values: NDArray[np.floating] | None, size: Sequence[int]) -> Tensor:
            weights = None if values is None else values.ravel()
            sums = np.bincount(index, weights, int(np.prod(size))).reshape(size)
            return torch.from_numpy(sums.astype(np.float32))

        return cls(
            counts=total(pairs, None, shape[:2]),
            returns=total(pairs, returns, shape[:2]),
            gains=total(choices, np.maximum(advantages, 0), shape),
            losses=total(choices, np.minimum(advantages, 0), shape),
        )


@dataclass(frozen=True, eq=False)
class SceneSamples:
    """One iteration's samples in one scene, and the policy that made them.

    Attributes:
        branch: name of the scene.
        views: (S, D).
        targets: (T, D), of the pictures of this iteration.
        masks: (S, T, 25), likewise.
        log_policy: (S, T, A) before the iteration.
        sums: of the samples.
    """

    branch: str
    views: Tensor
    targets: Tensor
    masks: Tensor
    log_policy: Tensor
    sums: PairSums

    def loss(self, network: PolicyNetwork, states: Tensor, config: PpoConfig, entropy_weight: float) -> Tensor:
        """Mean PPO loss of the samples taken in some states: clipped surrogate, values and entropy."""
        counts = self.sums.counts[states]
        log_policy, values = network.table(self.views[states], self.targets, self.masks[states], self.branch)
        ratio = (log_policy - self.log_policy[states]).exp()
        clipped = ratio.clamp(1 - config.clip, 1 + config.clip)
        gains, losses = self.sums.gains[states], self.sums.losses[states]
        surrogate = torch.minimum(ratio * gains, clipped * gains) + torch.minimum(ratio * losses, clipped * losses)
        entropy = -(log_policy.exp() * log_policy).sum(dim=-1)
        # The squared error summed over a pair's returns, without the part that has no gradient.
        squared = counts * values**2 - 2 * values * self.sums.returns[states]
        total = -surrogate.sum() + config.value_coef * squared.sum() - entropy_weight * (counts * entropy).sum()
        return total / counts.sum().clamp(min=1)


def _collect(
    network: PolicyNetwork,
    training_tasks: Sequence[TrainingTask],
    workers: Sequence[RolloutWorker],
    config: PpoConfig,
    rng: np.random.Generator,
) -> list[SceneSamples]:
    """Roll the policy out in every scene; advantages are brought to mean 0 and deviation 1 over all scenes."""
    shown, rollouts, estimates = [], [], []
    for training_task, worker in zip(training_tasks, workers, strict=True):
        # Another picture of each target every time, so that the policy comes to work with all of them.
        pictures = rng.integers(0, training_task.observations.pictures, len(training_task.task.targets))
        tensors = picture_tensors(training_task, pictures)
        with torch.no_grad():
            log_policy, values = network.table(*tensors, training_task.task.scene)
        table = log_policy.exp().numpy()
        with section("rollouts"):
            rollout = worker.run(table, config.num_steps)
        shown.append((training_task.task.scene, *tensors, log_policy))
        rollouts.append(rollout)
        estimates.append(estimate_advantages(rollout, values.numpy(), config.gamma, config.gae_lambda))
    everything = np.concatenate([advantages.ravel() for advantages, _ in estimates])
    mean, deviation = everything.mean(), everything.std() + 1e-8
    return [
        SceneSamples(*scene, PairSums.of(scene[-1].shape, rollout, (advantages - mean) / deviation, returns))
        for scene, rollout, (advantages, returns) in zip(shown, rollouts, estimates, strict=True)
    ]


def _state_parts(scene: SceneSamples, parts: int, rng: np.random.Generator) -> Iterator[Tensor]:
    """The scene's states in random order, cut into parts."""
    for states in np.array_split(rng.permutation(len(scene.views)), parts):
        yield torch.from_numpy(states)
