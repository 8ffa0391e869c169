"""The paper's policy network (section IV-B, figure 3), with a fast way to evaluate it for a whole scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from active_perceiver.envs.observations import Observations
from active_perceiver.errors import SearchError
from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.sections import section
from active_perceiver.vision.location import GRID

TABLE_STATES = 512
"""States of which `log_table` has the hidden layers at once; with more it is no faster."""


class PolicyNetwork(nn.Module):
    """View, target and location mask in; for each scene's branch, log probabilities of actions and a value out.

    View and target features go through a layer of their own each, are fused with the 25 cells of the location
    mask, and then through a branch per scene: one layer, a softmax over actions and a value.

    Args:
        feature_dim: number of backbone features, D.
        branches: names of the actions of each scene.
        hidden: width of every layer, 512 in the paper.
    """

    view_mean: Tensor
    view_scale: Tensor
    target_mean: Tensor
    target_scale: Tensor

    def __init__(self, feature_dim: int, branches: Mapping[str, Sequence[str]], hidden: int = 512) -> None:
        super().__init__()
        if feature_dim < 1 or hidden < 1 or not branches:
            raise SearchError("a policy network needs features, hidden units and at least one branch")
        self.feature_dim = feature_dim
        self.hidden = hidden
        self.branches: dict[str, tuple[str, ...]] = {name: tuple(actions) for name, actions in branches.items()}
        # Backbone features have very different ranges; the statistics are those of the training data.
        for label in ("view", "target"):
            self.register_buffer(f"{label}_mean", torch.zeros(feature_dim))
            self.register_buffer(f"{label}_scale", torch.ones(feature_dim))
        self.view_layer = nn.Linear(feature_dim, hidden)
        self.target_layer = nn.Linear(feature_dim, hidden)
        self.fusion = nn.Linear(2 * hidden + GRID * GRID, hidden)
        self.branch_layers = nn.ModuleList(nn.Linear(hidden, hidden) for _ in self.branches)
        heads = [nn.Linear(hidden, len(actions)) for actions in self.branches.values()]
        self.action_heads = nn.ModuleList(heads)
        self.value_heads = nn.ModuleList(nn.Linear(hidden, 1) for _ in self.branches)
        for head in heads:
            # The search starts as nearly a random walk, so that no action has to be unlearned first.
            nn.init.orthogonal_(head.weight, 0.01)
            nn.init.zeros_(head.bias)

    @classmethod
    def for_tasks(cls, training_tasks: Sequence[TrainingTask], hidden: int = 512) -> PolicyNetwork:
        """A network with a branch for each problem, and with the statistics of their features.

        Raises:
            SearchError: if there are no problems, two of one scene, or they have different features.
        """
        if not training_tasks:
            raise SearchError("there is nothing to learn; give at least one scene")
        scenes = [training_task.task.scene for training_task in training_tasks]
        if len(set(scenes)) != len(scenes):
            raise SearchError(f"each scene has one branch, but a scene was given twice: {scenes}")
        widths = {training_task.observations.view_features.shape[1] for training_task in training_tasks}
        if len(widths) != 1:
            raise SearchError(f"all scenes need features of one backbone, got {sorted(widths)} features")
        network = cls(
            widths.pop(),
            {training_task.task.scene: training_task.task.actions for training_task in training_tasks},
            hidden,
        )
        views = np.concatenate([training_task.observations.view_features for training_task in training_tasks])
        targets = np.concatenate(
            [
                training_task.observations.target_features.reshape(-1, network.feature_dim)
                for training_task in training_tasks
            ]
        )
        for label, features in (("view", views), ("target", targets)):
            mean, scale = _statistics(features)
            getattr(network, f"{label}_mean").copy_(torch.from_numpy(mean))
            getattr(network, f"{label}_scale").copy_(torch.from_numpy(scale))
        return network

    def forward(self, view: Tensor, target: Tensor, mask: Tensor, branch: str) -> tuple[Tensor, Tensor]:
        """Decide for N observations, pair by pair.

        Args:
            view: (N, D) features.
            target: (N, D) features.
            mask: (N, 25).
            branch: name of the scene.

        Returns:
            Log probabilities (N, A) and values (N,).
        """
        both = torch.cat([self._embed("view", view), self._embed("target", target), mask], dim=-1)
        return self._decide(self.fusion(both), branch)

    def table(self, views: Tensor, targets: Tensor, masks: Tensor, branch: str) -> tuple[Tensor, Tensor]:
        """Decide for every pair of n views and T targets.

        The same as `forward` on all pairs, but what depends on the view or the target alone is computed once for
        each of them, not for each pair.

        Args:
            views: (n, D) features.
            targets: (T, D) features.
            masks: (n, T, 25).
            branch: name of the scene.

        Returns:
            Log probabilities (n, T, A) and values (n, T).
        """
        view_part, target_part, mask_part = self.fusion.weight.split([self.hidden, self.hidden, GRID * GRID], dim=1)
        with section("forward"):
            from_view = self._embed("view", views) @ view_part.T
            from_target = self._embed("target", targets) @ target_part.T + self.fusion.bias
            return self._decide(from_view[:, None] + from_target + masks @ mask_part.T, branch)

    def _embed(self, label: str, features: Tensor) -> Tensor:
        normal = (features - getattr(self, f"{label}_mean")) / getattr(self, f"{label}_scale")
        return torch.relu(getattr(self, f"{label}_layer")(normal))

    def _decide(self, fused: Tensor, branch: str) -> tuple[Tensor, Tensor]:
        number = self.branch_number(branch)
        hidden = torch.relu(self.branch_layers[number](torch.relu(fused)))
        return torch.log_softmax(self.action_heads[number](hidden), -1), self.value_heads[number](hidden)[..., 0]

    def branch_number(self, branch: str) -> int:
        """Position of a branch among the branches.

        Raises:
            SearchError: if there is no such branch; the message lists those there are.
        """
        if branch not in self.branches:
            raise SearchError(f"the network has no branch '{branch}'; it has {', '.join(self.branches)}")
        return list(self.branches).index(branch)


def seeded_network(training_tasks: Sequence[TrainingTask], config: LearnerConfig) -> PolicyNetwork:
    """`PolicyNetwork.for_tasks` with weights drawn by the configuration's seed, not from torch's own stream."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        return PolicyNetwork.for_tasks(training_tasks, config.hidden)


def task_table(
    network: PolicyNetwork, training_task: TrainingTask, pictures: int | NDArray[np.integer] = 0
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """What a network decides everywhere in a problem.

    Args:
        network: has a branch for the problem's scene.
        training_task: of S states and T targets.
        pictures: which picture each target is asked for with: one number for all, or (T,).

    Returns:
        Probabilities (S, T, A) and values (S, T), float32.
    """
    log_probabilities, values = log_table(
        network, *picture_tensors(training_task, pictures), training_task.task.scene
    )
    return log_probabilities.exp().numpy(), values.numpy()


@torch.no_grad()
def log_table(
    network: PolicyNetwork, views: Tensor, targets: Tensor, masks: Tensor, branch: str
) -> tuple[Tensor, Tensor]:
    """`PolicyNetwork.table` without gradients, some states after others: hidden layers take far more than the result.

    Args:
        network: see `PolicyNetwork.table` for the rest.
        views: (S, D).
        targets: (T, D).
        masks: (S, T, 25).
        branch: name of the scene.

    Returns:
        Log probabilities (S, T, A) and values (S, T).
    """
    parts = zip(views.split(TABLE_STATES), masks.split(TABLE_STATES), strict=True)
    tables = [network.table(some, targets, their_masks, branch) for some, their_masks in parts]
    log_policy, values = zip(*tables, strict=True)
    return torch.cat(log_policy), torch.cat(values)


def picture_tensors(
    training_task: TrainingTask,
    pictures: int | NDArray[np.integer],
    states: NDArray[np.integer] | None = None,
    observations: Observations | None = None,
) -> tuple[Tensor, Tensor, Tensor]:
    """The views (n, D), and for one picture of each target the features (T, D) and masks (n, T, 25).

    Args:
        training_task: of S states and T targets.
        pictures: which picture each target is asked for with: one number for all, or (T,).
        states: (n,) which states; all if None.
        observations: which of the problem's; those of the scene as it is if None.
    """
    seen = observations or training_task.observations
    index = np.arange(len(training_task.task.targets))
    masks = seen.masks[:, index, pictures] if states is None else seen.masks[states[:, None], index, pictures]
    return (
        torch.from_numpy(seen.view_features if states is None else seen.view_features[states]),
        torch.from_numpy(seen.target_features[index, pictures]),
        torch.from_numpy(masks),
    )


def _statistics(features: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Mean and scale of each feature; one that hardly varies must not be blown up when it varies at run time."""
    spread = features.std(axis=0)
    scale = spread + 0.1 * spread.mean()
    return features.mean(axis=0), np.where(scale > 0, scale, 1.0).astype(np.float32)
