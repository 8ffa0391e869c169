"""Fitting the network by Adam to what is known of every state: the loop of the learners that need no rollouts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import cast

import numpy as np
import torch
from torch import Tensor, nn

from active_perceiver.policies.config import FitConfig
from active_perceiver.policies.monitor import Monitor
from active_perceiver.policies.network import PolicyNetwork, seeded_network
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.ema import ema_weights
from active_perceiver.utils.sections import section

# The losses of one iteration's `fit_steps` steps in one scene, each to be minimised before the next is asked for.
SceneLosses = Callable[[PolicyNetwork, TrainingTask, np.random.Generator], Iterator[Tensor]]


def fit_network(
    training_tasks: Sequence[TrainingTask],
    config: FitConfig,
    losses: SceneLosses,
    monitor: Monitor,
) -> PolicyNetwork:
    """Train a policy for one or several scenes; a step of Adam minimises the mean of their losses.

    What is measured and given back is the running mean of the weights, see `FitConfig.averaging`.

    Args:
        training_tasks: one per scene, with features of one backbone.
        config: how many steps, how large, and when to stop.
        losses: gives the losses of an iteration in one scene.
        monitor: watches the training, and says when it is over.

    Raises:
        SearchError: if there are no problems, or they do not go together.
    """
    network = seeded_network(training_tasks, config)
    _scale_weights(network, config.seed)
    rng = np.random.default_rng(config.seed)
    optimiser = torch.optim.Adam(network.parameters(), lr=config.learning_rate, fused=True)
    averaged = ema_weights(network, config.averaging)
    policy = cast(PolicyNetwork, averaged.module)
    monitor.start()
    for iteration in range(config.iterations):
        optimiser.param_groups[0]["lr"] = config.learning_rate_at(iteration)
        scenes = [losses(network, training_task, rng) for training_task in training_tasks]
        for _ in range(config.fit_steps):
            optimiser.zero_grad()
            for scene in scenes:
                # One after the other, so that what a backward pass needs is kept for one scene only.
                loss = next(scene) / len(scenes)
                with section("backward"):
                    loss.backward()
            with section("optimiser"):
                optimiser.step()
                averaged.update_parameters(network)
        if monitor.finished(policy, iteration + 1):
            break
    return policy


def _scale_weights(network: PolicyNetwork, seed: int) -> None:
    """Draw the weights of the hidden layers anew, orthogonal with a gain of sqrt(2), as policies usually begin.

    Torch's own draws are so small that what tells one view from another shrinks with every layer. From these,
    policies get good in fewer steps of Adam.
    """
    generator = torch.Generator().manual_seed(seed)
    for layer in (network.view_layer, network.target_layer, network.fusion, *network.branch_layers):
        nn.init.orthogonal_(layer.weight, math.sqrt(2), generator)
        nn.init.zeros_(layer.bias)


def state_batches(states: int, config: FitConfig, rng: np.random.Generator) -> Iterator[Tensor]:
    """`fit_steps` batches of states, going through all of them in random order again and again."""
    size = min(config.batch_states, states)
    rounds = -(-config.fit_steps * size // states)
    order = np.concatenate([rng.permutation(states) for _ in range(rounds)])
    for step in range(config.fit_steps):
        yield torch.from_numpy(order[step * size : (step + 1) * size])
