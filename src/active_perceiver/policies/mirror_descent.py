"""Learning from exact advantages: policy mirror descent, with the network fitted to each step's result.

While it is trained in a scene, the policy's transitions are known, so what an action is worth need not be sampled:
one sparse linear system per target gives the advantages A of the present policy. One step of mirror descent turns
the policy pi into softmax(log pi + eta A); the network is fitted to that by a few steps of Adam on the cross-entropy.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import torch
from torch import Tensor

from active_perceiver.policies.advantages import exact_advantages
from active_perceiver.policies.config import MirrorDescentConfig, reward_of
from active_perceiver.policies.monitor import Inspect, Monitor, Progress, Record
from active_perceiver.policies.network import PolicyNetwork, picture_tensors, seeded_network
from active_perceiver.policies.problem import Problem


def train_mirror_descent(
    problems: Sequence[Problem],
    config: MirrorDescentConfig,
    progress: Progress | None = None,
    inspect: Inspect | None = None,
) -> tuple[PolicyNetwork, list[Record]]:
    """Train a policy for one or several scenes.

    Args:
        problems: one per scene, with features of one backbone.
        config: see `MirrorDescentConfig`.
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
    monitor = Monitor(problems, config, progress, inspect)
    for iteration in range(config.iterations):
        optimiser.param_groups[0]["lr"] = config.learning_rate_at(iteration)
        # Another picture of each target every time, so that the policy comes to work with all of them.
        batches = [_improvements(network, problem, config, rng) for problem in problems]
        for losses in zip(*batches, strict=True):
            optimiser.zero_grad()
            torch.stack(losses).mean().backward()
            optimiser.step()
        if monitor.finished(network, iteration + 1):
            break
    return network, monitor.history


def _improvements(
    network: PolicyNetwork, problem: Problem, config: MirrorDescentConfig, rng: np.random.Generator
) -> Iterator[Tensor]:
    """The losses of one iteration's steps in one scene, each to be minimised before the next is asked for.

    The target of the fit is found when the first is asked for.
    """
    task = problem.task
    pictures = rng.integers(0, problem.observations.pictures, len(task.targets))
    views, targets, masks = picture_tensors(problem, pictures)
    with torch.no_grad():
        log_policy, _ = network.table(views, targets, masks, task.scene)
    advantages = exact_advantages(log_policy.exp().numpy(), task, reward_of(config), config.gamma)
    improved = torch.softmax(log_policy + config.step_size * torch.from_numpy(advantages).float(), dim=-1)
    # Where a search is over, or hopeless, it does not matter what the policy does.
    counts = torch.from_numpy((task.steps > 0).astype(np.float32))
    for states in _state_batches(len(task), config, rng):
        log_fitted, _ = network.table(views[states], targets, masks[states], task.scene)
        cross_entropy = -(improved[states] * log_fitted).sum(dim=-1)
        yield (counts[states] * cross_entropy).sum() / counts[states].sum().clamp(min=1)


def _state_batches(states: int, config: MirrorDescentConfig, rng: np.random.Generator) -> Iterator[Tensor]:
    """`fit_steps` batches of states, going through all of them in random order again and again."""
    size = min(config.batch_states, states)
    rounds = -(-config.fit_steps * size // states)
    order = np.concatenate([rng.permutation(states) for _ in range(rounds)])
    for step in range(config.fit_steps):
        yield torch.from_numpy(order[step * size : (step + 1) * size])
