"""Training a recogniser on annotated scenes (the paper, section IV-A), and judging it on what it has not seen."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import cast

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from active_perceiver.recognition.augmentation import AugmentationConfig, make_augmented
from active_perceiver.recognition.calibration import calibrate_split
from active_perceiver.recognition.export import export_recogniser, recogniser_onnx, save_network
from active_perceiver.recognition.metrics import SMALLEST_AREA, RecognitionMetrics
from active_perceiver.recognition.network import RECOGNISERS, RecogniserNetwork
from active_perceiver.recognition.pairs import IGNORE_INDEX, PRESENT, Annotations, PairSampler, Split
from active_perceiver.recognition.pretrained import pretrained_network
from active_perceiver.recognition.recogniser import Recogniser, RecogniserError
from active_perceiver.scenes.scene import Scene
from active_perceiver.utils.ema import ema_weights
from active_perceiver.utils.progress import ProgressCallback, quiet
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures

# Views whose principal components are taken; their cells are far more than the components.
FIT_VIEWS = 100
PREPARE_BATCH = 32
NO_AUGMENTATION = AugmentationConfig(views=0, pictures=0, crops=0)


@dataclass(frozen=True)
class RecogniserConfig:
    """How a recogniser is trained; `CONFIGS` has the settings that suit each kind."""

    kind: str = "matching"
    """Which network: "matching" (a heat map of the target's centre) or "pooled" (the paper's)."""
    steps: int = 3000
    """Updates of the weights; 0 to judge the start as it is, calibrated and with a threshold of its own."""
    views: int = 24
    """Views in a batch."""
    targets: int = 3
    """Targets asked for in each view of a batch."""
    present: float = 0.7
    """How often the target that a view is drawn for is in it."""
    optimiser: str = "adamw"
    """Either "adamw", with a learning rate that rises and falls (OneCycle), or "sgd", as in the paper."""
    learning_rate: float = 2e-3
    """The highest learning rate."""
    weight_decay: float = 1e-2
    """Pull of the weights towards zero."""
    noise: float = 0.1
    """Standard deviation of the noise on features, as a fraction of their own."""
    averaging: float = 0.99
    """How much of the running mean of the weights, which is what is kept, each update leaves, 0..1; 0 for the weights
    as they are."""
    start: str = "pretrained"
    """What training starts from: "pretrained", weights learned in other rooms if there are any for the backbone, or
    "scratch"."""
    augmentation: AugmentationConfig = field(default_factory=AugmentationConfig)
    """Changed copies of views and pictures to learn from as well."""
    own_pictures: float = 0.6
    """How often a target is asked for with one of its own pictures, and not with a further one."""
    precision: str = "auto"
    """Of most products while training: "bfloat16", twice as fast on a CPU that has it, "float32", or "auto"."""
    held_out_places: float = 0.2
    """Fraction of the places whose views are kept for judging."""
    held_out_targets: tuple[str, ...] = ()
    """Names of targets not to train on, to see what it makes of things it does not know."""
    smallest_area: float = SMALLEST_AREA
    """Smaller visible objects, as a fraction of the image, count neither as there nor as absent."""
    most_false: float = 0.005
    """The threshold is chosen such that at most this fraction of views without the target counts as seen."""
    seed: int = 0
    """All that is drawn follows from it."""
    threads: int | None = None
    """CPU threads; torch's own number if None. Results are the same for the same number."""

    def __post_init__(self) -> None:
        if self.kind not in RECOGNISERS:
            raise RecogniserError(f"there is no recogniser '{self.kind}'; there are {', '.join(RECOGNISERS)}")
        choices = {
            "optimiser": ("adamw", "sgd"),
            "start": ("pretrained", "scratch"),
            "precision": ("auto", "float32", "bfloat16"),
        }
        for name, known in choices.items():
            if getattr(self, name) not in known:
                raise RecogniserError(f"{name} is one of {', '.join(known)}, not '{getattr(self, name)}'")
        if min(self.views, self.targets, 1 if self.threads is None else self.threads) < 1 or self.steps < 0:
            raise RecogniserError("views, targets and threads must be at least 1, steps at least 0")
        if not (0.0 <= self.held_out_places < 1.0 and 0.0 <= self.averaging < 1.0):
            raise RecogniserError("held_out_places and averaging must be at least 0 and less than 1")
        if not (0.0 <= self.present <= 1.0 and 0.0 <= self.own_pictures <= 1.0):
            raise RecogniserError("present and own_pictures must be in 0..1")


CONFIGS: dict[str, RecogniserConfig] = {
    "matching": RecogniserConfig(),
    # SGD as in the paper. In the bundled kitchen 0.03 is near the highest learning rate that does not diverge (0.1
    # does), and much lower ones learn little in so many steps.
    "pooled": RecogniserConfig(
        kind="pooled",
        steps=2000,
        optimiser="sgd",
        learning_rate=0.03,
        weight_decay=1e-4,
        averaging=0.0,
        start="scratch",
        augmentation=NO_AUGMENTATION,
        precision="float32",
    ),
}


@dataclass(frozen=True, eq=False)
class TrainedRecogniser:
    """A trained network and how good it is.

    Attributes:
        network: in evaluation mode, calibrated.
        config: how it was trained.
        threshold: presence probability from which on a detection counts.
        metrics: "seen pictures" and "unseen pictures" on views of places it has not seen, and "unknown targets" if
            any were held out.
        validation_views: for each scene the (S,) bool mask of views that were held out.
        backbone: fingerprint of the backbone whose features it takes.
        seconds: wall time of training.
    """

    network: RecogniserNetwork
    config: RecogniserConfig
    threshold: float
    metrics: Mapping[str, RecognitionMetrics]
    validation_views: tuple[NDArray[np.bool_], ...]
    backbone: str
    seconds: float

    def recogniser(self, threads: int | None = None) -> Recogniser:
        """For running it at once, without a file."""
        return Recogniser(recogniser_onnx(self.network, self.threshold, self.backbone), threads)

    def save(self, folder: Path | str) -> None:
        """Write `recogniser.onnx`, to run it, and `recogniser.safetensors`, to train it on."""
        export_recogniser(self.network, Path(folder) / "recogniser.onnx", self.threshold, self.backbone)
        save_network(self.network, Path(folder) / "recogniser.safetensors")


def train_recogniser(
    scenes: Sequence[Scene],
    features: Sequence[SceneFeatures],
    config: RecogniserConfig | None = None,
    progress: ProgressCallback = quiet,
    held_out: Sequence[NDArray[np.bool_]] | None = None,
    backbone: Backbone | None = None,
) -> TrainedRecogniser:
    """Train on all annotated targets of some scenes; the scenes say which of their pictures are kept for judging.

    Args:
        scenes: with boxes and target pictures.
        features: of the scenes, in the same order, by one backbone.
        config: how; None for the default.
        progress: told of every image of further material, then of every update with a running mean of the loss.
        held_out: for each scene the (S,) bool mask of the views that are kept for judging, all or none of a place;
            None to draw the fraction of the places that `config` says.
        backbone: that made the features; without it there is neither further material nor a pretrained start.

    Raises:
        RecogniserError: if scenes, features and views to hold out do not fit, or no target is visible anywhere.
        SceneError: if a scene has no targets.
    """
    config = config or CONFIGS["matching"]
    _check(scenes, features, held_out, backbone)
    started = time.monotonic()
    with using_threads(config.threads), torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        return _train(scenes, features, config, held_out, backbone, progress, started)


@contextmanager
def using_threads(threads: int | None) -> Iterator[None]:
    """Let torch use so many CPU threads, or as many as before if None, and afterwards as many as before."""
    before = torch.get_num_threads()
    torch.set_num_threads(threads or before)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def _check(
    scenes: Sequence[Scene],
    features: Sequence[SceneFeatures],
    held_out: Sequence[NDArray[np.bool_]] | None,
    backbone: Backbone | None,
) -> None:
    if not scenes or len(scenes) != len(features):
        raise RecogniserError(
            f"training needs scenes and the features of each: got {len(scenes)} and {len(features)}"
        )
    for scene, feature in zip(scenes, features, strict=True):
        scene.require_targets()
        if len(feature.view_maps) != len(scene) or len(feature.target_maps) != len(scene.targets):
            raise RecogniserError(f"the features given for scene '{scene.name}' are of another scene")
    if len({(feature.backbone, feature.view_maps.shape[1:]) for feature in features}) > 1:
        raise RecogniserError("the scenes' features come from different backbones or image sizes; use one for all")
    if backbone is not None and backbone.fingerprint != features[0].backbone:
        raise RecogniserError("the features were made by another backbone than the one given; compute them anew")
    shapes = [(len(scene),) for scene in scenes]
    if held_out is not None and [views.shape for views in held_out] != shapes:
        raise RecogniserError(f"the views to hold out need one mask a scene, of shapes {shapes}")


def _train(
    scenes: Sequence[Scene],
    features: Sequence[SceneFeatures],
    config: RecogniserConfig,
    held_out: Sequence[NDArray[np.bool_]] | None,
    backbone: Backbone | None,
    progress: ProgressCallback,
    started: float,
) -> TrainedRecogniser:
    rng = np.random.default_rng(config.seed)
    data = Annotations.of(scenes, config.smallest_area)
    if held_out is None:
        split = Split.of(data, config.held_out_places, config.held_out_targets, rng)
    else:
        split = Split.holding_out(data, np.concatenate(held_out), config.held_out_targets)
    network = _beginning(features, split, config, backbone, rng)
    views = torch.cat([prepared(network.prepare, feature.view_maps) for feature in features])
    # Targets of scenes with fewer pictures are padded; those rows are never asked for.
    most = max(feature.target_maps.shape[1] for feature in features)
    pictures = torch.cat(
        [
            prepared(network.prepare_target, np.take(maps, np.arange(most) % len(maps), 0))
            for f in features
            for maps in f.target_maps
        ]
    ).unflatten(0, (-1, most))

    # What is held out does not even say how strong the noise is.
    trained_pictures = torch.from_numpy(np.arange(most) < split.seen_pictures[:, None])
    spreads = (views[torch.from_numpy(~split.views)], pictures[trained_pictures])
    noise = tuple(config.noise * float(table.float().std()) for table in spreads)
    del spreads
    if backbone is None or config.augmentation == NO_AUGMENTATION or config.steps == 0:
        sampler = PairSampler(data, split, config.present, rng)
        material = views, pictures
    else:
        # A short training would not see more copies than that.
        most = config.steps * config.views // 8
        wanted = replace(config.augmentation, views=min(config.augmentation.views, most))
        augmented = make_augmented(scenes, backbone, network, data, split, wanted, rng, progress)
        everything = augmented.added_to(data, split)
        sampler = PairSampler(*everything, config.present, rng, augmented.counts, config.own_pictures)
        material = torch.cat([views, augmented.views]), torch.cat([pictures, augmented.pictures], dim=1)
    network = _optimise(network.train(), *material, noise, sampler, config, progress).eval()
    threshold, metrics = calibrate_split(network, views, pictures, data, split, config.most_false)
    ends = np.cumsum([len(scene) for scene in scenes])[:-1]
    return TrainedRecogniser(
        network=network,
        config=config,
        threshold=threshold,
        metrics=metrics,
        validation_views=tuple(np.split(split.views, ends)),
        backbone=features[0].backbone,
        seconds=time.monotonic() - started,
    )


def _beginning(
    features: Sequence[SceneFeatures],
    split: Split,
    config: RecogniserConfig,
    backbone: Backbone | None,
    rng: np.random.Generator,
) -> RecogniserNetwork:
    """The network before it is trained."""
    if config.start == "pretrained" and backbone is not None:
        network = pretrained_network(config.kind, backbone.name, backbone.image_size)
        if network is not None:
            return network
    network = RECOGNISERS[config.kind](features[0].view_maps.shape[1:])
    network.fit(_sample_of_views(features, split, rng))
    return network


def _optimise(
    network: RecogniserNetwork,
    views: Tensor,
    pictures: Tensor,
    noise: tuple[float, ...],
    sampler: PairSampler,
    config: RecogniserConfig,
    progress: ProgressCallback,
) -> RecogniserNetwork:
    """Train a network; what is returned is the running mean of its weights."""
    weights = list(network.parameters())
    averaged = ema_weights(network, config.averaging)
    bfloat16 = _uses_bfloat16(config)
    rate, decay = config.learning_rate, config.weight_decay
    if config.optimiser == "adamw":
        optimiser: torch.optim.Optimizer = torch.optim.AdamW(weights, rate, weight_decay=decay)
        schedule: torch.optim.lr_scheduler.LRScheduler = torch.optim.lr_scheduler.OneCycleLR(
            optimiser, rate, total_steps=config.steps + 1
        )
    else:
        optimiser = torch.optim.SGD(weights, rate, momentum=0.9, weight_decay=decay)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, config.steps)
    mean_loss = float("nan")
    for step in range(1, config.steps + 1):
        batch = sampler.draw(config.views, config.targets)
        shown = views[torch.from_numpy(batch.views)].float()
        asked = pictures[torch.from_numpy(batch.targets), torch.from_numpy(batch.pictures)].float().flatten(0, 1)
        shown += noise[0] * torch.randn_like(shown)
        asked += noise[1] * torch.randn_like(asked)
        with torch.autocast("cpu", torch.bfloat16, enabled=bfloat16):
            embeddings = network.encode_target(asked).unflatten(0, batch.targets.shape)
            judged = network.evaluate_pairs(network.encode_view(shown), embeddings).float()
        states = torch.from_numpy(batch.states).flatten()
        counts = states != IGNORE_INDEX
        present = (states == PRESENT).float()[counts]
        loss = network.loss(judged[counts], present, torch.from_numpy(batch.boxes).flatten(0, 1)[counts])
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(weights, 5.0)
        optimiser.step()
        schedule.step()
        averaged.update_parameters(network)
        mean_loss = loss.item() if step == 1 else 0.98 * mean_loss + 0.02 * loss.item()
        progress(step, config.steps, f"loss {mean_loss:.3f}")
    return cast(RecogniserNetwork, averaged.module)


def _uses_bfloat16(config: RecogniserConfig) -> bool:
    if config.precision == "auto":
        # Processors without it emulate it, which is slower than float32.
        return bool(torch.cpu.get_capabilities().get("avx512_bf16"))
    return config.precision == "bfloat16"


def _sample_of_views(features: Sequence[SceneFeatures], split: Split, rng: np.random.Generator) -> Tensor:
    """Maps of some training views of all scenes, (N, C, h, w) float32."""
    scene_of = np.repeat(np.arange(len(features)), [len(feature.view_maps) for feature in features])
    row_of = np.concatenate([np.arange(len(feature.view_maps)) for feature in features])
    chosen = rng.permutation(np.flatnonzero(~split.views))[:FIT_VIEWS]
    maps = [features[scene].view_maps[row] for scene, row in zip(scene_of[chosen], row_of[chosen], strict=True)]
    return torch.from_numpy(np.stack(maps).astype(np.float32))


@torch.inference_mode()
def prepared(prepare: Callable[[Tensor], Tensor], maps: NDArray[np.float16]) -> Tensor:
    """What a network makes of maps without learning, as float16: (N, C, h, w) -> (N, ...)."""
    parts = [
        prepare(torch.from_numpy(maps[start : start + PREPARE_BATCH].astype(np.float32))).half()
        for start in range(0, len(maps), PREPARE_BATCH)
    ]
    return torch.cat(parts)
