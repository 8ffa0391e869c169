"""Learning from exact advantages: policy mirror descent, with the network fitted to each step's result.

While it is trained in a scene, the policy's transitions are known, so what an action is worth need not be sampled:
one sparse linear system per target gives the advantages A of the present policy. One step of mirror descent turns
the policy pi into softmax(log pi + eta A), with a step size eta of each state's own; the network is fitted to that by
a few steps of Adam on the cross-entropy.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
import torch
from torch import Tensor

from active_perceiver.policies.advantages import exact_advantages
from active_perceiver.policies.config import MirrorDescentConfig, reward_of
from active_perceiver.policies.fitting import fit_network, state_batches
from active_perceiver.policies.monitor import Monitor
from active_perceiver.policies.network import PolicyNetwork, log_table, picture_tensors
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.sections import section


def train_mirror_descent(
    training_tasks: Sequence[TrainingTask], config: MirrorDescentConfig, monitor: Monitor
) -> PolicyNetwork:
    """Train a policy by mirror descent; see `Learner.train`."""
    return fit_network(training_tasks, config, partial(_improvements, config), monitor)


def _improvements(
    config: MirrorDescentConfig, network: PolicyNetwork, training_task: TrainingTask, rng: np.random.Generator
) -> Iterator[Tensor]:
    """See `fitting.SceneLosses`; the target of the fit is found when the first loss is asked for."""
    task = training_task.task
    drawn = training_task.observations.pictures, len(task.targets)
    log_policy, _ = log_table(network, *picture_tensors(training_task, rng.integers(0, *drawn)), task.scene)
    with section("advantages"):
        advantages = exact_advantages(log_policy.exp().numpy(), task, reward_of(config), config.gamma)
    # Far from a goal all actions are worth nearly the same, discounted; measured by the largest one a step is as long
    # there as near by.
    largest = np.abs(advantages).max(axis=-1, keepdims=True)
    relative = torch.from_numpy(advantages / np.where(largest > 0, largest, 1.0)).float()
    improved = torch.softmax(log_policy + config.step_size * relative, dim=-1)
    # Where a search is over, or hopeless, it does not matter what the policy does.
    counts = torch.from_numpy((task.steps > 0).astype(np.float32))
    for states in state_batches(len(task), config, rng):
        # What is better does not depend on the picture a target is asked for with: other ones for every batch. Were
        # it one for all batches, an odd picture would be met in few iterations, and searches with it stay lost.
        pictures = rng.integers(0, *drawn)
        batch = picture_tensors(training_task, pictures, states.numpy(), training_task.drawn(rng))
        log_fitted, _ = network.table(*batch, task.scene)
        cross_entropy = -(improved[states] * log_fitted).sum(dim=-1)
        yield (counts[states] * cross_entropy).sum() / counts[states].sum().clamp(min=1)
