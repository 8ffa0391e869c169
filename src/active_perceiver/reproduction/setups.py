"""What is searched for where, by which methods, and how much training each gets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from active_perceiver.policies.config import A3cConfig, LearnerConfig, PpoConfig
from active_perceiver.recognition.train import CONFIGS, RecogniserConfig
from active_perceiver.reproduction.config import LearnerName, MethodName, SetupName
from active_perceiver.scenes.bundled import TARGETS_OF_RECORD


@dataclass(frozen=True)
class ExperimentSetup:
    """One row of the paper's table I.

    Attributes:
        label: for tables.
        searches: scene -> names of the targets searched for there.
        updates: of the shared weights by A3C, the budget of one training.
    """

    label: str
    searches: Mapping[str, tuple[str, ...]]
    updates: int


@dataclass(frozen=True)
class Method:
    """One column of the paper's table I.

    Attributes:
        label: for tables.
        reward: a name in `REWARDS`; None for the random walk, which learns nothing.
        entropy_weight: of the learner. The paper gives it for its own reward; the two other rewards get the low one,
            which is Zhu's.
    """

    label: str
    reward: str | None
    entropy_weight: float = 0.01


METHODS: dict[MethodName, Method] = {
    "random": Method("random walk", None),
    "reward_1": Method("reward 1: 10 at a goal, -0.01 elsewhere", "goal"),
    "reward_2": Method("reward 2: the area at every step", "area"),
    "record_high": Method("record reward, high exploration (0.1)", "record", 0.1),
    "record_low": Method("record reward, low exploration (0.01)", "record", 0.01),
}


@dataclass(frozen=True)
class BudgetConfig:
    """How large everything is.

    Attributes:
        setups: what is searched for.
        image_size: side to which images are scaled for the backbone, pixels.
        folds: of the recogniser's cross-validation.
        recogniser: how it is trained.
        a3c: settings that all trainings by A3C share, but for what setup, method and seed say.
        ppo: the same for PPO.
        episodes: per target, in the paper's protocol.
        limit: actions after which a search has failed.
        seeds: trainings of each kind.
    """

    setups: dict[SetupName, ExperimentSetup]
    image_size: int
    folds: int
    recogniser: RecogniserConfig
    a3c: A3cConfig
    ppo: PpoConfig
    episodes: int
    limit: int
    seeds: int

    def config(
        self, learner: LearnerName, setup: SetupName, method: MethodName, seed: int, choice: str = ""
    ) -> LearnerConfig:
        """Settings of one training. They stop neither early nor by time: everyone gets the same budget."""
        common: dict[str, Any] = {
            "reward": METHODS[method].reward,
            "entropy_weight": METHODS[method].entropy_weight,
            "seed": seed,
            "target_ratio": None,
            "check_limit": self.limit,
        }
        if learner == "ppo":
            return replace(self.ppo, check_every=max(1, self.ppo.iterations // RECORDS), **common)
        changed = dict(CHOICES[choice].changes) if choice else {}
        updates = self.setups[setup].updates * changed.pop("budget", 1)
        config = replace(self.a3c, iterations=updates, check_every=max(1, updates // RECORDS), **common)
        return replace(config, **changed)


@dataclass(frozen=True)
class Choice:
    """Something that the paper leaves open, chosen otherwise.

    Attributes:
        label: for the table.
        changes: fields of `A3cConfig`; "budget" multiplies the updates.
        true_boxes: show the policy the true boxes instead of a recogniser's.
    """

    label: str
    changes: Mapping[str, Any]
    true_boxes: bool = False


# Each is tried on one object, with the record reward and low exploration.
CHOICES: dict[str, Choice] = {
    "unit-1": Choice("an area is paid as a fraction of the image, not per cent", {"area_unit": 1.0}),
    "unit-10": Choice("an area is paid in tenths of the image", {"area_unit": 10.0}),
    "update-20": Choice("an update every 20 actions, not at the end of an episode", {"update_steps": 20}),
    "gamma-0.95": Choice("a discount of 0.95, not 0.99", {"gamma": 0.95}),
    "epsilon-0.001": Choice("RMSProp with an epsilon of 0.001, not 0.1", {"epsilon": 1e-3}),
    "budget-4": Choice("four times as many updates", {"budget": 4}),
    "true-boxes": Choice("true boxes, not a recogniser's", {}, true_boxes=True),
}

# Measurements during a training.
RECORDS = 12

_ROOMS = ("kitchen_1", "kitchen_2", "living_room_1", "living_room_2")

FULL = BudgetConfig(
    setups={
        "one_object": ExperimentSetup("1 object, 1 scene", {"kitchen_1": ("bread",)}, 3000),
        "four_objects": ExperimentSetup("4 objects, 1 scene", {"kitchen_1": TARGETS_OF_RECORD["kitchen_1"]}, 4000),
        "sixteen_objects": ExperimentSetup(
            "16 objects, 4 scenes", {scene: TARGETS_OF_RECORD[scene] for scene in _ROOMS}, 3000
        ),
        "conference_room": ExperimentSetup(
            "conference room", {"conference_room": TARGETS_OF_RECORD["conference_room"]}, 4000
        ),
    },
    image_size=320,
    folds=5,
    recogniser=CONFIGS["pooled"],
    a3c=A3cConfig(),
    ppo=PpoConfig(gamma=0.99),
    episodes=10,
    limit=5000,
    seeds=3,
)

_SMALL = {"conference_room": ("mug", "bag")}

QUICK = BudgetConfig(
    setups={
        "one_object": ExperimentSetup("1 object, 1 scene", {"conference_room": ("mug",)}, 12),
        "four_objects": ExperimentSetup("2 objects, 1 scene", _SMALL, 20),
        "sixteen_objects": ExperimentSetup("4 objects, 2 scenes", {**_SMALL, "living_room_2": ("book", "vase")}, 20),
        "conference_room": ExperimentSetup("conference room", _SMALL, 20),
    },
    image_size=96,
    folds=2,
    recogniser=replace(CONFIGS["pooled"], steps=40),
    a3c=A3cConfig(max_steps=200, hidden=32),
    ppo=PpoConfig(gamma=0.99, iterations=3, num_envs=64, hidden=32),
    episodes=3,
    limit=500,
    seeds=2,
)
