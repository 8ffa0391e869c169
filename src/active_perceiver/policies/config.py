"""Settings of the learners: plain dataclasses, so that a command line can show them without importing torch."""

from __future__ import annotations

from dataclasses import dataclass

from active_perceiver.envs.rewards import REWARDS, Reward, reward_named
from active_perceiver.errors import SearchError


@dataclass(frozen=True, kw_only=True)
class LearnerConfig:
    """What every learner can be told."""

    learning_rate: float = 1e-3
    """Of Adam, at the start; it falls linearly to a tenth."""
    iterations: int = 100
    """Most iterations: rounds of finding out what is better and fitting the network to it."""
    hidden: int = 512
    """Width of the network's layers."""
    seed: int = 0
    """Of everything random; the same seed gives the same policy, if no time limit ends the training."""
    target_ratio: float | None = 1.01
    """Stop once every search arrives and takes no more than so many times the fewest steps, with every picture."""
    patience: int | None = None
    """Stop once so many measurements in a row have not made the ratio 0.2 % better; None to go on."""
    seconds: float | None = None
    """Stop after so many seconds."""
    threads: int = 1
    """CPU threads of torch. The batches are small: a second thread helps little, and costs much on a busy machine."""
    check_every: int = 1
    """Iterations between two measurements for the history."""
    check_limit: int = 1000
    """Steps after which a search has failed, in those measurements."""

    def __post_init__(self) -> None:
        for label in ("iterations", "hidden", "threads", "check_every", "check_limit", *self.counts()):
            if getattr(self, label) < 1:
                raise SearchError(f"{label} must be at least 1, got {getattr(self, label)}")
        if self.patience is not None and self.patience < 1:
            raise SearchError(f"patience must be at least 1 or None, got {self.patience}")
        if not self.learning_rate > 0:
            raise SearchError(f"the learning rate must be positive, got {self.learning_rate}")

    def counts(self) -> tuple[str, ...]:
        """Names of further fields that must be at least 1."""
        return ()

    def learning_rate_at(self, iteration: int) -> float:
        """The learning rate of an iteration, counted from 0."""
        return self.learning_rate * (1 - 0.9 * iteration / self.iterations)


@dataclass(frozen=True, kw_only=True)
class RewardConfig(LearnerConfig):
    """What a learner that is paid can be told."""

    reward: str = "gain"
    """What is paid for: a name in `REWARDS`."""
    gamma: float = 0.95
    """Discount of rewards per step, 0..1; the paper has 0.99, less makes for shorter paths."""

    def __post_init__(self) -> None:
        super().__post_init__()
        reward_named(self.reward)
        if not 0 <= self.gamma < 1:
            raise SearchError(f"gamma must be at least 0 and less than 1, got {self.gamma}")


@dataclass(frozen=True, kw_only=True)
class FitConfig(LearnerConfig):
    """What a learner that fits the network to a table can be told; see `fitting`."""

    fit_steps: int = 24
    """Steps of Adam per iteration."""
    batch_states: int = 96
    """States per step of Adam, in every scene, with all targets each."""
    averaging: float = 0.0
    """How much of the running mean of the weights, which is the policy, each step of Adam keeps, 0..1; 0 for the
    weights as they are."""
    patience: int | None = 15
    """Stop once so many measurements in a row have not made the ratio 0.2 % better; None to go on."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0 <= self.averaging < 1:
            raise SearchError(f"averaging must be at least 0 and less than 1, got {self.averaging}")

    def counts(self) -> tuple[str, ...]:
        """See `LearnerConfig.counts`."""
        return ("fit_steps", "batch_states")


@dataclass(frozen=True, kw_only=True)
class MirrorDescentConfig(FitConfig, RewardConfig):
    """Settings of `mirror-descent`."""

    reward: str = "arrival"
    """What is paid for: a name in `REWARDS`; exact advantages need a reward that depends on the step alone."""
    learning_rate: float = 2e-3
    """Of Adam, at the start; it falls linearly to a tenth."""
    averaging: float = 0.95
    """How much of the running mean of the weights, which is the policy, each step of Adam keeps, 0..1."""
    step_size: float = 3.0
    """How far the policy moves at each iteration: it is fitted to softmax(log policy + step size x advantage), in
    each state over the largest advantage there."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not reward_named(self.reward).markov:
            possible = ", ".join(name for name, reward in REWARDS.items() if reward.markov)
            raise SearchError(
                f"the reward '{self.reward}' depends on what was seen earlier, so its advantages cannot be computed "
                f"exactly: use the learner ppo with it, or one of the rewards {possible}"
            )
        if not self.step_size > 0:
            raise SearchError(f"the step size must be positive, got {self.step_size}")


@dataclass(frozen=True, kw_only=True)
class DistilConfig(FitConfig):
    """Settings of `distil`, which is shown the shortest paths and so needs no reward."""

    learning_rate: float = 2e-3
    """Of Adam, at the start; it falls linearly to a tenth."""
    iterations: int = 100
    """Most iterations: rounds of `fit_steps` steps of Adam."""
    averaging: float = 0.95
    """How much of the running mean of the weights, which is the policy, each step of Adam keeps, 0..1. The learning
    rate is high: without it single states go wrong again and again, and searches loop there."""


@dataclass(frozen=True, kw_only=True)
class PpoConfig(RewardConfig):
    """Settings of `ppo`."""

    iterations: int = 80
    """Most iterations: rounds of rollouts and fitting the network to them."""
    num_envs: int = 1024
    """Searches that run side by side, over all scenes."""
    num_steps: int = 32
    """Steps of each search per iteration."""
    max_steps: int = 150
    """Actions after which an episode is cut off; the paper has 5000."""
    gae_lambda: float = 0.95
    """Lambda of generalised advantage estimation, 0..1."""
    epochs: int = 4
    """Passes over an iteration's rollouts."""
    minibatches: int = 4
    """Parts a pass is cut into, by state."""
    clip: float = 0.2
    """How far the probability ratio may move."""
    value_coef: float = 0.5
    """Weight of the squared error of the values."""
    entropy_weight: float = 0.05
    """Weight of the entropy at the start; it falls linearly to 0 at 80 % of the iterations."""
    max_grad_norm: float = 0.5
    """Longer gradients are cut to this length."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0 <= self.gae_lambda <= 1:
            raise SearchError(f"gae_lambda must be in 0..1, got {self.gae_lambda}")

    def counts(self) -> tuple[str, ...]:
        """See `LearnerConfig.counts`."""
        return ("num_envs", "num_steps", "max_steps", "epochs", "minibatches")

    def entropy_weight_at(self, iteration: int) -> float:
        """The entropy weight of an iteration, counted from 0."""
        return self.entropy_weight * max(0.0, 1 - 1.25 * iteration / self.iterations)


@dataclass(frozen=True, kw_only=True)
class A3cConfig(RewardConfig):
    """Settings of `a3c`, as in Zhu et al. (ICRA 2017) and the paper unless said otherwise."""

    reward: str = "record"
    """What is paid for: a name in `REWARDS`; the paper's is "record"."""
    gamma: float = 0.99
    """Discount of rewards per step, 0..1."""
    learning_rate: float = 7e-4
    """Of RMSProp, at the start; it falls linearly to a tenth."""
    iterations: int = 10_000
    """Updates of the shared weights, by all workers together."""
    max_steps: int = 5000
    """Actions after which an episode is cut off."""
    update_steps: int | None = None
    """Actions between two updates; None to update at the end of each episode, as the paper does."""
    area_unit: float = 100.0
    """What the whole image is worth to a reward that pays areas ("record", "area"): 100 pays per cent. The paper does
    not say in which unit it pays; the entropy weights suit this one."""
    entropy_weight: float = 0.01
    """Weight of the entropy: 0.1 is the paper's "high exploration", 0.01 its "low exploration"."""
    value_coef: float = 0.5
    """Weight of the squared error of the values."""
    max_grad_norm: float = 40.0
    """Longer gradients are cut to this length."""
    decay: float = 0.99
    """Of the mean of squared gradients (RMSProp), which all workers share."""
    epsilon: float = 0.1
    """Added to the mean of squared gradients."""
    serial: bool = False
    """Let the workers take turns in this process: slower, but the same seed then gives the same policy."""
    check_every: int = 100
    """Iterations between two measurements for the history."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.update_steps is not None and self.update_steps < 1:
            raise SearchError(f"update_steps must be at least 1 or None, got {self.update_steps}")
        for label in ("area_unit", "max_grad_norm", "epsilon"):
            if not getattr(self, label) > 0:
                raise SearchError(f"{label} must be positive, got {getattr(self, label)}")
        if not 0 <= self.decay < 1:
            raise SearchError(f"the decay must be at least 0 and less than 1, got {self.decay}")

    def counts(self) -> tuple[str, ...]:
        """See `LearnerConfig.counts`."""
        return ("max_steps",)

    @property
    def reward_scale(self) -> float:
        """What the reward is multiplied by."""
        return self.area_unit if reward_named(self.reward).pays_area else 1.0


def reward_of(config: RewardConfig) -> Reward:
    """The reward a configuration names."""
    return reward_named(config.reward)
