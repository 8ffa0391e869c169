"""Fitting the network by Adam to what is known of every state: the loop of the learners that need no rollouts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import cast

import numpy as np
import torch
from torch import Tensor
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from active_perceiver.policies.config import FitConfig
from active_perceiver.policies.monitor import Inspect, Monitor, Progress, Record
from active_perceiver.policies.network import PolicyNetwork, seeded_network
from active_perceiver.policies.problem import Problem

# The losses of one iteration's `fit_steps` steps in one scene, each to be minimised before the next is asked for.
SceneLosses = Callable[[PolicyNetwork, Problem, np.random.Generator], Iterator[Tensor]]


def fit_network(
    problems: Sequence[Problem],
    config: FitConfig,
    losses: SceneLosses,
    progress: Progress | None = None,
    inspect: Inspect | None = None,
) -> tuple[PolicyNetwork, list[Record]]:
    """Train a policy for one or several scenes; a step of Adam minimises the mean of their losses.

    What is measured and given back is the running mean of the weights, see `FitConfig.averaging`.

    Args:
        problems: one per scene, with features of one backbone.
        config: how many steps, how large, and when to stop.
        losses: gives the losses of an iteration in one scene.
        progress: is called with every record of the history.
        inspect: is shown every record with the policy tables it measures.

    Returns:
        The network and the history, see `Monitor`.

    Raises:
        SearchError: if there are no problems, or they do not go together.
    """
    network = seeded_network(problems, config)
    rng = np.random.default_rng(config.seed)
    optimiser = torch.optim.Adam(network.parameters(), lr=config.learning_rate, fused=True)
    averaged = AveragedModel(network, multi_avg_fn=get_ema_multi_avg_fn(config.averaging))
    policy = cast(PolicyNetwork, averaged.module)
    monitor = Monitor(problems, config, progress, inspect)
    for iteration in range(config.iterations):
        optimiser.param_groups[0]["lr"] = config.learning_rate_at(iteration)
        for step in zip(*(losses(network, problem, rng) for problem in problems), strict=True):
            optimiser.zero_grad()
            torch.stack(step).mean().backward()
            optimiser.step()
            averaged.update_parameters(network)
        if monitor.finished(policy, iteration + 1):
            break
    return policy, monitor.history


def state_batches(states: int, config: FitConfig, rng: np.random.Generator) -> Iterator[Tensor]:
    """`fit_steps` batches of states, going through all of them in random order again and again."""
    size = min(config.batch_states, states)
    rounds = -(-config.fit_steps * size // states)
    order = np.concatenate([rng.permutation(states) for _ in range(rounds)])
    for step in range(config.fit_steps):
        yield torch.from_numpy(order[step * size : (step + 1) * size])
