"""Distillation: the network is fitted to the actions that lie on shortest paths. The practical upper bound.

No reward says what is good; a scene's transitions tell which actions bring a search nearer to its goal, and there are
often several. The loss is -log of the probability that the policy takes any of them, which leaves the choice among
them to the network. Cross-entropy to the uniform distribution over them wants more than a search needs, all of them
alike: to come within 1.02 x the shortest paths it takes a quarter more steps in kitchen_1, and two to five times as
many in toy scenes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from active_perceiver.envs.task import SearchTask
from active_perceiver.policies.config import DistilConfig
from active_perceiver.policies.fitting import fit_network, state_batches
from active_perceiver.policies.monitor import Monitor
from active_perceiver.policies.network import PolicyNetwork, picture_tensors
from active_perceiver.policies.training_task import TrainingTask


def train_distil(training_tasks: Sequence[TrainingTask], config: DistilConfig, monitor: Monitor) -> PolicyNetwork:
    """Train a policy by distillation; see `Learner.train`."""
    return fit_network(training_tasks, config, partial(_batch_losses, config), monitor)


def optimal_actions(task: SearchTask, states: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Which actions are the first of a shortest path to a goal.

    Args:
        task: the search.
        states: (n,) indices.

    Returns:
        (n, T, A); none at goals, and none where no way leads to one.
    """
    steps = task.steps[states]
    nearer = task.steps[task.transitions[states]] == steps[:, None] - 1  # (n, A, T)
    return nearer.transpose(0, 2, 1) & (steps > 0)[..., None]


def distillation_loss(log_policy: Tensor, optimal: Tensor) -> Tensor:
    """Mean of -log of the probability of an optimal action, over the pairs of a state and a target that have one.

    Args:
        log_policy: (n, T, A) log probabilities.
        optimal: (n, T, A) bool.

    Returns:
        (), 0 if no pair has an optimal action.
    """
    searching = optimal.any(dim=-1)
    among_optimal = log_policy[searching].masked_fill(~optimal[searching], -torch.inf)
    return -torch.logsumexp(among_optimal, dim=-1).sum() / searching.sum().clamp(min=1)


def _batch_losses(
    config: DistilConfig, network: PolicyNetwork, training_task: TrainingTask, rng: np.random.Generator
) -> Iterator[Tensor]:
    """See `fitting.SceneLosses`."""
    task = training_task.task
    for batch in state_batches(len(task), config, rng):
        states = batch.numpy()
        # Another picture of each target for every batch, so that the policy comes to work with all of them.
        pictures = rng.integers(0, training_task.observations.pictures, len(task.targets))
        # Only the batch's rows: a scene may have many states.
        log_policy, _ = network.table(
            *picture_tensors(training_task, pictures, states, training_task.drawn(rng)), task.scene
        )
        yield distillation_loss(log_policy, torch.from_numpy(optimal_actions(task, states)))
