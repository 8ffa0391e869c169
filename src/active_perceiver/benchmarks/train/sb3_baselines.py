"""Stable-baselines3's PPO and A2C with this project's network, environment and measurements, to be compared with.

Nothing of how they learn is changed: the policy hands the observations to a `PolicyNetwork` and what it says back,
and between two rollouts the network is measured as it is with this project's own learners.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3 import A2C, PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.distributions import Distribution
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecEnv
from torch import Tensor

from active_perceiver.benchmarks.train.baselines import Sb3Config, Sb3PpoConfig
from active_perceiver.envs import SearchVectorEnv
from active_perceiver.errors import UserError
from active_perceiver.policies.monitor import Monitor
from active_perceiver.policies.network import PolicyNetwork, seeded_network
from active_perceiver.policies.training_task import TrainingTask

Observation = dict[str, Tensor]


def train_sb3(training_tasks: Sequence[TrainingTask], config: Sb3Config, monitor: Monitor) -> PolicyNetwork:
    """Train a policy for one scene by PPO, or A2C if the configuration is not `Sb3PpoConfig`; see `Learner.train`.

    An iteration is a rollout and the updates by it, a sample a step in one environment.

    Raises:
        UserError: if there is not exactly one problem: all its environments have the same actions and branch.
    """
    if len(training_tasks) != 1:
        raise UserError(f"stable-baselines3 is compared in one scene, got {len(training_tasks)}")
    (training_task,) = training_tasks
    network = seeded_network(training_tasks, config)
    model = make_model(training_task, network, config)
    monitor.start()
    watch = _Watch(monitor, network, config)
    # A rollout more than is used: what ends the training is measured when the next one would begin.
    model.learn((config.iterations + 1) * config.num_steps * config.num_envs, callback=watch)
    return network


def make_model(training_task: TrainingTask, network: PolicyNetwork, config: Sb3Config) -> OnPolicyAlgorithm:
    """Stable-baselines3's PPO or A2C on environments of a problem.

    Args:
        training_task: the search.
        network: is trained.
        config: see `Sb3Config`.
    """
    env = SearchVecEnv(training_task, config.num_envs, config.reward, config.max_steps)
    common: dict[str, Any] = {
        "env": env,
        "policy_kwargs": {"network": network},
        "learning_rate": lambda remaining: config.learning_rate * (0.1 + 0.9 * remaining),
        "n_steps": config.num_steps,
        "gamma": config.gamma,
        "gae_lambda": config.gae_lambda,
        "ent_coef": config.entropy_weight,
        "vf_coef": config.value_coef,
        "max_grad_norm": config.max_grad_norm,
        "seed": config.seed,
        "device": "cpu",
    }
    if isinstance(config, Sb3PpoConfig):
        return PPO(
            NetworkPolicy,
            batch_size=config.batch_size,
            n_epochs=config.epochs,
            clip_range=config.clip,
            **common,
        )
    return A2C(NetworkPolicy, normalize_advantage=True, **common)


class NetworkPolicy(ActorCriticPolicy):
    """A `PolicyNetwork` with one branch, as stable-baselines3 wants to ask it.

    Args:
        network: is held, not copied.
        options: of the base class.
    """

    def __init__(self, *arguments: Any, network: PolicyNetwork, **options: Any) -> None:
        super().__init__(*arguments, **options)
        (self._branch,) = network.branches
        self.network = network
        # As stable-baselines3 initialises what it builds itself: orthogonal, with these gains.
        for layers in network.children():
            gain = 0.01 if layers is network.action_heads else 1.0 if layers is network.value_heads else math.sqrt(2)
            layers.apply(partial(self.init_weights, gain=gain))
        of_optimiser: dict[str, Any] = {"lr": self._learning_rate(1.0), **(self.optimizer_kwargs or {})}
        self.optimizer = self.optimizer_class(self.network.parameters(), **of_optimiser)

    def _build(self, lr_schedule: Any) -> None:
        """Nothing to build: the layers are the network's."""
        self._learning_rate = lr_schedule

    def forward(self, obs: Observation, deterministic: bool = False) -> tuple[Tensor, Tensor, Tensor]:  # type: ignore[override]
        """Actions (N,), values (N, 1) and log probabilities of the actions (N,)."""
        log_policy, values = self._ask(obs)
        distribution = self._distribution(log_policy)
        actions = distribution.get_actions(deterministic=deterministic)
        return actions, values[:, None], distribution.log_prob(actions)

    def evaluate_actions(self, obs: Observation, actions: Tensor) -> tuple[Tensor, Tensor, Tensor | None]:  # type: ignore[override]
        """Values (N, 1), log probabilities of given actions (N,) and entropies (N,)."""
        log_policy, values = self._ask(obs)
        distribution = self._distribution(log_policy)
        return values[:, None], distribution.log_prob(actions), distribution.entropy()

    def get_distribution(self, obs: Observation) -> Distribution:  # type: ignore[override]
        """The distribution of actions."""
        return self._distribution(self._ask(obs)[0])

    def predict_values(self, obs: Observation) -> Tensor:  # type: ignore[override]
        """Values (N, 1)."""
        return self._ask(obs)[1][:, None]

    def _ask(self, obs: Observation) -> tuple[Tensor, Tensor]:
        return self.network(obs["view"], obs["target"], obs["mask"], self._branch)

    def _distribution(self, log_policy: Tensor) -> Distribution:
        return self.action_dist.proba_distribution(action_logits=log_policy)


class SearchVecEnv(VecEnv):
    """A `SearchVectorEnv` by stable-baselines3's interface.

    An episode that ends is followed by the next one in the same step, whose first observation is returned, as
    stable-baselines3 expects; the last observation of the episode is in the infos.

    Args:
        training_task: the search.
        count: searches side by side.
        reward: what is paid, a name in `REWARDS`.
        max_steps: actions after which an episode is cut off.
    """

    def __init__(self, training_task: TrainingTask, count: int, reward: str, max_steps: int) -> None:
        self.env = _SameStepEnv(
            count,
            task=training_task.task,
            observations=training_task.observations,
            reward=reward,
            max_steps=max_steps,
        )
        self._actions = np.zeros(count, np.int64)
        super().__init__(count, self.env.single_observation_space, self.env.single_action_space)

    def reset(self) -> dict[str, NDArray[Any]]:
        """Start an episode in every search; the seed is that of the last call of `seed`."""
        observations, _ = self.env.reset(seed=self._seeds[0])
        self._reset_seeds()
        return observations

    def step_async(self, actions: NDArray[np.int64]) -> None:
        """Note what is to be done."""
        self._actions = actions

    def step_wait(self) -> Any:
        """Do it: observations, rewards, dones and infos."""
        observations, rewards, terminated, truncated, final = self.env.step(self._actions)
        ended = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for row, number in enumerate(np.flatnonzero(ended)):
            infos[number] = {
                "terminal_observation": {name: values[row] for name, values in final.items()},
                "TimeLimit.truncated": bool(truncated[number]),
            }
        return observations, rewards.astype(np.float32), ended, infos

    def close(self) -> None:
        """Nothing is open."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The same attribute of the one environment that holds all searches, for each of them."""
        return [getattr(self.env, attr_name, None)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refused: the searches share what they have."""
        raise NotImplementedError("the searches of SearchVecEnv share their attributes")

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **options: Any) -> list[Any]:
        """Refused, likewise."""
        raise NotImplementedError("the searches of SearchVecEnv have no methods of their own")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Whether the searches are wrapped: never."""
        return [False] * len(list(self._get_indices(indices)))


class _SameStepEnv(SearchVectorEnv):
    """Begins the next episode in the step that ends one; the infos are the last observations of those that ended."""

    def step(self, actions: NDArray[np.int64]) -> Any:
        observations, rewards, terminated, truncated, _ = super().step(actions)
        ended = np.flatnonzero(terminated | truncated)
        if not len(ended):
            return observations, rewards, terminated, truncated, {}
        final = {name: values[ended] for name, values in observations.items()}
        self._begin(ended, {})
        self._ended[:] = False
        return self._observe(), rewards, terminated, truncated, final


class _Watch(BaseCallback):
    """Measures the network before each rollout but the first, and stops the training when it is time to."""

    def __init__(self, monitor: Monitor, network: PolicyNetwork, config: Sb3Config) -> None:
        super().__init__()
        self.monitor = monitor
        self._network = network
        self._config = config
        self._rollouts = 0
        self._finished = False

    def _on_rollout_start(self) -> None:
        done = self._rollouts
        self._rollouts += 1
        if done:
            self._finished = self.monitor.finished(self._network, done, self.num_timesteps)
            self._finished = self._finished or done >= self._config.iterations

    def _on_step(self) -> bool:
        return not self._finished
