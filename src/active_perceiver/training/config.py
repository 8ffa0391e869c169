"""Settings of training; the docstring under a field is its help on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class TrainConfig:
    """What to train, on what, and how."""

    scenes: tuple[str, ...] = ("kitchen_1",)
    """Bundled names or scene files; the policy gets a branch for each."""
    task: Literal["object", "view"] = "object"
    """What is searched for: the object in a picture, or the place from where a picture of the scene was taken, as in
    Zhu et al. (ICRA 2017); "view" trains no recogniser."""
    targets: tuple[str, ...] = ()
    """What the policy is trained to search for; all targets of the scenes if not given. A name may have its scene in
    front (kitchen_1/mug); "record" stands for a bundled scene's four targets of record. The recogniser is always
    trained on all targets. For --task view, numbers of states (12, or kitchen_1/12 if there are several scenes); five
    of each scene, drawn by the seed, if not given."""
    recogniser_scenes: tuple[str, ...] = ()
    """Scenes the recogniser is trained on instead of `scenes`, for example photographs taken elsewhere
    (`scenes elsewhere`); then it has seen no view of `scenes`."""
    recogniser: Literal["matching", "pooled"] = "matching"
    """Kind of recogniser: "matching" compares the picture with every place in the view, "pooled" is the paper's."""
    recogniser_steps: int | None = None
    """Training steps of the recogniser; its own default if not given."""
    view_augmentation: int = 2
    """How many times the policy (mirror-descent, distil) is shown every view as a worse camera or other light would
    show it; each takes as long as computing the features of the scene."""
    viewpoint_jitter_degrees: float = 0.0
    """In these changed views the camera also looks up to so many degrees aside and stands a little nearer or farther,
    as a robot does whose moves are not exact; 0 to 45. Training takes longer with it."""
    learner: Literal["mirror-descent", "distil", "ppo", "a3c"] = "mirror-descent"
    """How the policy is learned: from exact advantages, from the shortest paths themselves (distil, which has no
    reward), by proximal policy optimisation from rollouts, or as in the paper by A3C with a process for each scene
    and target (slow)."""
    reward: Literal["arrival", "gain", "record", "goal", "area"] | None = None
    """What the policy is paid for; "arrival" for mirror-descent and "gain" for ppo, "record" (the paper's) for a3c if
    not given, "goal" for --task view."""
    entropy_weight: float | None = None
    """Weight of the policy's entropy (ppo, a3c); the learner's own default if not given. The paper
    has 0.1 and 0.01."""
    backbone: str = "efficientnet_lite0"
    """Frozen feature extractor: efficientnet_lite0 or resnet50 (downloads its weights once)."""
    image_size: int = 320
    """Side in pixels to which views are scaled for the backbone; a multiple of 32."""
    rank: int = 5
    """Goal states are those whose box is at least as large as the rank-th largest; 5 in the paper."""
    policy_seconds: float | None = None
    """Time limit of the policy's training; none if not given."""
    seed: int = 0
    """Everything random in training follows from it."""
