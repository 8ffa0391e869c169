"""Policies at run time: what is shown in, probabilities of actions out; no torch."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import SearchError
from active_perceiver.vision.location import GRID
from active_perceiver.vision.sessions import ModelFileError, onnxruntime, open_session

if TYPE_CHECKING:
    from active_perceiver.envs.observations import Observations

KIND = "active-perceiver-policy"


class ActionPolicy(Protocol):
    """Anything that chooses actions: a trained `Policy`, a `RandomPolicy`, or your own."""

    @property
    def branches(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the actions of each branch; a branch is named after the scene it was trained in."""

    def probabilities(
        self,
        view: NDArray[np.float32],
        target: NDArray[np.float32],
        mask: NDArray[np.float32],
        branch: str,
    ) -> NDArray[np.float32]:
        """Probability of each action for N views: (N, D), (N, D), (N, 25) -> (N, A)."""


class RandomPolicy:
    """The random walk of the paper's tables: every action is equally likely, whatever is seen."""

    def __init__(self, branches: Mapping[str, tuple[str, ...]]) -> None:
        self.branches = dict(branches)

    def probabilities(
        self,
        view: NDArray[np.float32],
        target: NDArray[np.float32],
        mask: NDArray[np.float32],
        branch: str,
    ) -> NDArray[np.float32]:
        """Uniform probabilities, (N, A) float32."""
        count = len(self.branches[check_branch(self, branch)])
        return np.full((len(view), count), 1.0 / count, np.float32)


class Policy:
    """A trained policy, run by ONNX Runtime.

    Args:
        model: a `policy.onnx` as `export_policy` writes it: its path, or its bytes.
        threads: CPU threads; a single observation gains nothing from more than one.

    Raises:
        SearchError: if the file is missing or is not a policy.
    """

    def __init__(self, model: Path | str | bytes, threads: int = 1) -> None:
        try:
            self._session = open_session(model if isinstance(model, bytes) else Path(model), threads, "policy")
        except ModelFileError as error:
            raise SearchError(str(error)) from None
        properties = self._session.get_modelmeta().custom_metadata_map
        self.branches: dict[str, tuple[str, ...]] = {
            name: tuple(actions) for name, actions in json.loads(properties["branches"]).items()
        }
        self.feature_dim: int = self._session.get_inputs()[0].shape[1]
        self._outputs = {name: f"probabilities_{number}" for number, name in enumerate(self.branches)}
        self._run_options = onnxruntime.RunOptions()
        # Without it every branch would be computed, not only the one asked for.
        self._run_options.only_execute_path_to_fetches = True

    def probabilities(
        self,
        view: NDArray[np.float32],
        target: NDArray[np.float32],
        mask: NDArray[np.float32],
        branch: str,
    ) -> NDArray[np.float32]:
        """Probability of each action.

        Args:
            view: (N, D) float32 backbone features of views.
            target: (N, D) float32 backbone features of target pictures.
            mask: (N, 25) float32 location masks, see `location_mask`.
            branch: the scene whose branch decides.

        Returns:
            (N, A) float32, rows sum to 1; the columns are `branches[branch]`.

        Raises:
            SearchError: if a shape is wrong or there is no such branch.
        """
        check_branch(self, branch)
        count = len(view)
        for label, array, shape in (
            ("view", view, (count, self.feature_dim)),
            ("target", target, (count, self.feature_dim)),
            ("mask", mask, (count, GRID * GRID)),
        ):
            if array.shape != shape:
                raise SearchError(f"{label} has shape {array.shape}, expected {shape}; was another backbone used?")
        inputs = {
            "view": np.ascontiguousarray(view, np.float32),
            "target": np.ascontiguousarray(target, np.float32),
            "mask": np.ascontiguousarray(mask, np.float32),
        }
        return self._session.run([self._outputs[branch]], inputs, self._run_options)[0]


def check_branch(policy: ActionPolicy, branch: str) -> str:
    """The branch's name, if the policy has it.

    Raises:
        SearchError: if it does not; the message lists those it has.
    """
    if branch not in policy.branches:
        known = ", ".join(policy.branches)
        raise SearchError(f"the policy has no branch for scene '{branch}'; it was trained in {known}")
    return branch


def policy_table(
    policy: ActionPolicy, observations: Observations, branch: str, picture: int = 0
) -> NDArray[np.float32]:
    """The whole policy in one scene: the probability of each action in each state for each target.

    Args:
        policy: any policy.
        observations: of S states and T targets.
        branch: the scene whose branch decides.
        picture: which of a target's pictures it is asked for with.

    Returns:
        (S, T, A) float32, sums to 1 over actions.

    Raises:
        SearchError: if there is no such picture or branch.
    """
    if not 0 <= picture < observations.pictures:
        raise SearchError(f"there is no picture {picture}; each target has {observations.pictures}")
    targets = observations.masks.shape[1]
    columns = [
        policy.probabilities(
            observations.view_features,
            np.broadcast_to(observations.target_features[target, picture], observations.view_features.shape),
            observations.masks[:, target, picture],
            branch,
        )
        for target in range(targets)
    ]
    return np.stack(columns, axis=1)
