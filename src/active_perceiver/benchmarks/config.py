"""Settings of benchmarks; the docstring under a field is its help on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

LearnerName = Literal["mirror-descent", "distil", "ppo", "a3c", "sb3-ppo", "sb3-a2c"]


@dataclass(frozen=True)
class RenderSpeedConfig:
    """Which room of each kind is rendered, and how often."""

    seed: int = 1
    """Which room of each kind."""
    views: int = 12
    """Views to take of each room."""


@dataclass(frozen=True)
class EnvSpeedConfig:
    """What is measured, and for how long."""

    scene: str = "kitchen_1"
    """Where to search, a bundled name or a file."""
    seconds: float = 3.0
    """How long to measure each environment."""
    counts: tuple[int, ...] = (1, 16, 64, 256, 1024)
    """Numbers of searches side by side."""


@dataclass(frozen=True)
class ActSpeedConfig:
    """What to measure, and how often."""

    agent: Path | None = None
    """Folder of the agent; if not given, agents with random weights are measured, which are as fast."""
    backbones: tuple[str, ...] = ()
    """Without --agent: backbones to measure, all if not given. Published weights are used if they are in the cache,
    else random ones, which are as fast."""
    threads: tuple[int, ...] = (1, 2)
    """Numbers of CPU threads to measure."""
    repeats: int = 100
    """Actions to measure in each process."""
    starts: int = 3
    """Processes to start for each backbone and number of threads."""
    scene: str = "kitchen_1"
    """Where the pictures come from, a bundled name or a file."""
    frame: tuple[int, int] = (640, 480)
    """Width and height of the camera's pictures in pixels: views of the scene scaled to this, as JPEG."""
    image_size: int = 320
    """Without --agent: side in pixels to which pictures are scaled for the backbone; a multiple of 32."""


@dataclass(frozen=True)
class ExportBenchmarkConfig:
    """What to measure, and how often."""

    calibrate: str | None = None
    """The scene, a bundled name or a file, by whose views the 8-bit numbers are set; the agent's own pictures if not
    given."""
    threads: int = 1
    """CPU threads of the agent."""
    repeats: int = 100
    """Actions to measure in each process."""
    starts: int = 3
    """Processes to start for each agent and environment."""
    frame: tuple[int, int] = (640, 480)
    """Width and height of the camera's pictures in pixels: views of the agent's scene scaled to this, as JPEG."""
    searches: int = 100
    """Searches per target by the agent's own word, from random starts."""
    python: Path | None = None
    """The interpreter of an environment with numpy, onnxruntime, pillow and this package alone; if not given, one is
    made in a temporary folder, for which the packages are installed."""


@dataclass(frozen=True)
class TrainSpeedConfig:
    """Who is measured, on what, and for how long."""

    learners: tuple[LearnerName, ...] = ("mirror-descent", "distil", "ppo", "a3c", "sb3-ppo", "sb3-a2c")
    """Who learns: this project's learners, and PPO and A2C of stable-baselines3 (sb3-...)."""
    seeds: int = 5
    """Trainings of each learner; their seeds are 0, 1, 2 and so on."""
    scene: str = "kitchen_1"
    """Where to search, a bundled name or a file."""
    targets: tuple[str, ...] = ("record",)
    """What is searched for; "record" stands for a bundled scene's four targets of record."""
    boxes: str = "truth"
    """Where the boxes come from that the policies are shown: "truth" for ground truth, so that nothing but the
    learners is compared, or the folder of an agent whose recogniser draws them."""
    seconds: float | None = None
    """Longest a training may take, its measurements included; if not given, each learner has a limit of its own."""
    threads: int | None = None
    """CPU threads of each training; as many as there are cores if not given."""
    backbone: str = "efficientnet_lite0"
    """Without an agent: where the features of views and pictures come from."""
    image_size: int = 320
    """Without an agent: side in pixels to which pictures are scaled for the backbone; a multiple of 32."""


@dataclass(frozen=True)
class RobustnessConfig:
    """What is different from training, and how often to search."""

    conditions: tuple[str, ...] = ()
    """Names of what to measure, such as "noise 25" or "dusk", see docs/benchmarks/robustness.md; all if not given."""
    other_hour: tuple[Path, ...] = ()
    """Scene files of the same room in another light, instead of rendering it at noon and at dusk."""
    moved: tuple[Path, ...] = ()
    """Scene files of the same room with its things elsewhere, instead of rendering two other arrangements."""
    searches: int = 100
    """Searches per target by the agent's own word, from random starts."""
    limit: int = 5000
    """Actions after which a search of the exact evaluation has failed."""
    seed: int = 0
    """Everything random follows from it."""
    work: Path | None = None
    """Folder for rendered rooms and finished measurements; in the user's cache if not given."""


@dataclass(frozen=True)
class PolicyBenchmarkConfig:
    """Which learners train policies, and how often."""

    learners: tuple[Literal["mirror-descent", "distil", "ppo"], ...] = ("mirror-descent", "distil")
    """How policies are learned, each with its own defaults."""
    seeds: int = 5
    """Trainings by each learner in each setup; their seeds are 0, 1, 2 and so on."""
    scenes: tuple[str, ...] = ()
    """Scene files to take in place of the agents' scenes of the same names, if they are no longer where they were
    when the agents were trained."""
    limit: int = 5000
    """Actions after which a search has failed."""
    threads: int = 1
    """CPU threads of each training."""
    iterations: int | None = None
    """Most iterations of a training; the learner's own default if not given."""


@dataclass(frozen=True)
class ScaleConfig:
    """How many scenes of which size, and who learns in them."""

    scenes: tuple[int, ...] = (1, 4, 16, 64)
    """Numbers of scenes."""
    states: tuple[int, ...] = (200, 800, 3200, 20_000)
    """States of each scene; a place has 12, so they are rounded to that."""
    most_states: int = 20_000
    """Scenes and states are combined as long as all scenes together have no more states than this."""
    learners: tuple[Literal["mirror-descent", "distil", "ppo"], ...] = ("distil", "mirror-descent")
    """How policies are learned, each with its own defaults."""
    targets: int = 4
    """Targets in each scene."""
    seconds: float = 120.0
    """Longest training, measurements not counted."""
    iterations: int | None = None
    """Most iterations of a training; the learner's own default if not given."""
    threads: int = 1
    """CPU threads of each training."""
    seed: int = 0
    """Of the scenes and of the trainings."""


@dataclass(frozen=True)
class RecogniserBenchmarkConfig:
    """Which recognisers are trained, where, and how often."""

    scenes: tuple[str, ...] = ("kitchen_1", "conference_room")
    """Where recognisers are trained and judged, bundled names or files; each scene on its own."""
    variants: tuple[str, ...] = ()
    """Names of what to train, such as "default" or "no averaging", see docs/benchmarks/recogniser.md; all if not
    given."""
    seeds: int = 1
    """Trainings of each variant in each scene; their seeds are 0, 1, 2 and so on."""
    steps: int | None = None
    """Updates of every training, to try something quickly; each variant's own number if not given."""
    threads: int | None = None
    """CPU threads of each training; as many as there are cores if not given."""
    backbone: str = "efficientnet_lite0"
    """Where the features of views and pictures come from."""
    image_size: int = 320
    """Side in pixels to which pictures are scaled for the backbone; a multiple of 32."""


@dataclass(frozen=True)
class RobotBenchmarkConfig:
    """Where a simulated robot searches, and how far from what the agent was trained on."""

    room: str = "kitchen_1_hour_dusk"
    """The room of one of the agents' scenes, by name, at another hour."""
    starts: int = 200
    """Searches of the last agent under all changes together."""
    compared: int = 60
    """Searches of everything else: of the other agents, and under fewer changes."""
    centimetres: float = 10.0
    """A search begins up to so far beside a place of the lattice, along x and along z."""
    degrees: float = 8.0
    """And up to so much beside one of the four headings."""
    nudge: float = 0.05
    """Metres by which each target is moved at most."""
    max_steps: int = 200
    """Actions after which a search has failed, as many as `search` allows."""
    workers: int = 2
    """Processes that search; each needs about a gigabyte of memory."""
    seed: int = 0
    """Starts, slip, nudges, pictures and draws of actions follow from it."""
