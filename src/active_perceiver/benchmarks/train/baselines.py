"""Who takes part in `benchmark train`, with which settings; importing this imports neither torch nor its rivals."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec

from active_perceiver.errors import UserError
from active_perceiver.policies.config import (
    A3cConfig,
    DistilConfig,
    LearnerConfig,
    MirrorDescentConfig,
    PpoConfig,
    RewardConfig,
)
from active_perceiver.policies.learners import LEARNERS, Learner

RATIO = 1.25
"""Times the shortest paths: the quality that is waited for, with success 1."""
FINE_RATIO = 1.02
"""What this project's learners are trained on to."""


@dataclass(frozen=True, kw_only=True)
class Sb3Config(RewardConfig):
    """What stable-baselines3's learners of both kinds can be told, by this project's names.

    The defaults are A2C's: as stable-baselines3 has them, but for the discount, the reward, the entropy weight and
    the number of searches, which are PPO's, advantages brought to mean 0 and deviation 1, and rollouts of 16 steps,
    which got to `RATIO` sooner than 5. A learning rate of 1.5e-3 with a trace decay of 0.95 took twice as long.
    """

    learning_rate: float = 7e-4
    """Of RMSProp, at the start; it falls linearly to a tenth."""

    iterations: int = 100_000
    """Most iterations: rollouts with the updates by them."""
    num_envs: int = 64
    """Searches that run side by side."""
    num_steps: int = 16
    """Steps of each search per iteration."""
    max_steps: int = 150
    """Actions after which an episode is cut off."""
    gae_lambda: float = 1.0
    """Lambda of generalised advantage estimation, 0..1."""
    value_coef: float = 0.5
    """Weight of the squared error of the values."""
    entropy_weight: float = 0.02
    """Weight of the entropy."""
    max_grad_norm: float = 0.5
    """Longer gradients are cut to this length."""


@dataclass(frozen=True, kw_only=True)
class Sb3PpoConfig(Sb3Config):
    """Settings of stable-baselines3's PPO.

    Chosen by hand in kitchen_1, one change after the other, by the time to `RATIO`. A learning rate of 1e-3 beat
    5e-4; 2 epochs take more steps than 4 but less time; batches of 256 were slower than 512; orthogonal weights,
    stable-baselines3's own, beat torch's; an entropy weight of 0.01 was no better than 0.02. With 8 epochs,
    rollouts of 16 steps, or the reward "arrival" it was behind after as much computing. From there, with two seeds
    each: a trace decay of 0.9, a clip of 0.3, 128 searches of 16 steps, 32 of 64, and 200 iterations, so that the
    learning rate falls sooner, differ less from it than the seeds do; a learning rate of 2e-3, 3 epochs, a discount
    of 0.9 and a value weight of 0.25 are slower.
    """

    learning_rate: float = 1e-3
    """Of Adam, at the start; it falls linearly to a tenth."""
    iterations: int = 400
    """Most iterations: rollouts with the updates by them."""
    num_steps: int = 32
    """Steps of each search per iteration."""
    gae_lambda: float = 0.95
    """Lambda of generalised advantage estimation, 0..1."""
    batch_size: int = 512
    """Samples per step of Adam."""
    epochs: int = 2
    """Passes over an iteration's rollouts."""
    clip: float = 0.2
    """How far the probability ratio may move."""


@dataclass(frozen=True)
class Baseline:
    """A learner and how it is trained here.

    Attributes:
        learner: trains.
        config: its settings; seed, threads and time limit are filled in.
        seconds: longest a training may take, if the user says nothing.
        goes_on: whether it goes on learning in other processes while it is measured, so that this is no pause.
        acts: whether it takes environment steps.
    """

    learner: Learner
    config: LearnerConfig
    seconds: float
    goes_on: bool = False
    acts: bool = True


def _sb3(name: str, config: Sb3Config) -> Baseline:
    function = "active_perceiver.benchmarks.train.sb3_baselines:train_sb3"
    return Baseline(Learner(name, type(config), function, "stable-baselines3"), config, 300.0)


BASELINES: dict[str, Baseline] = {
    "mirror-descent": Baseline(
        LEARNERS["mirror-descent"], MirrorDescentConfig(target_ratio=FINE_RATIO), 60.0, acts=False
    ),
    # Measured three times as often as by default, with as many steps of Adam in all and as much patience.
    "distil": Baseline(
        LEARNERS["distil"],
        DistilConfig(fit_steps=8, iterations=300, patience=45, target_ratio=FINE_RATIO),
        60.0,
        acts=False,
    ),
    "ppo": Baseline(LEARNERS["ppo"], PpoConfig(target_ratio=FINE_RATIO), 120.0),
    "a3c": Baseline(
        LEARNERS["a3c"], A3cConfig(gamma=0.95, epsilon=1e-3, check_every=50, target_ratio=RATIO), 180.0, goes_on=True
    ),
    "sb3-ppo": _sb3("sb3-ppo", Sb3PpoConfig(target_ratio=RATIO)),
    "sb3-a2c": _sb3("sb3-a2c", Sb3Config(target_ratio=RATIO, check_every=8)),
}


def baseline_named(name: str) -> Baseline:
    """A baseline by name.

    Raises:
        UserError: if there is none, or what it needs is not installed; the message says what to do.
    """
    if name not in BASELINES:
        raise UserError(f"there is no learner '{name}'; choose one of {', '.join(BASELINES)}")
    baseline = BASELINES[name]
    if isinstance(baseline.config, Sb3Config) and find_spec("stable_baselines3") is None:
        raise UserError(
            f"{name} needs stable-baselines3: pip install 'active-perceiver[dev]', or leave it out with --learners"
        )
    return baseline
