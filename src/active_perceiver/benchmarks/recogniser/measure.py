"""What each ingredient of the recogniser's training is worth, and how good it is on targets it never learned."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from typing import Any

import torch
from matplotlib.figure import Figure

from active_perceiver.benchmarks.config import RecogniserBenchmarkConfig
from active_perceiver.benchmarks.recogniser.report import GOALS, ablation_rows, format_recogniser_ablation, summary
from active_perceiver.benchmarks.recogniser.variants import EVERY, Variant, chosen_variants
from active_perceiver.benchmarks.runner import Benchmark, ResultBody, Run
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.figures.ablation import ablation_figure
from active_perceiver.parallel.executor import Executor, SerialExecutor, tell
from active_perceiver.parallel.run_missing import records_of
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.recognition.pretrained import pretrained_path
from active_perceiver.recognition.train import CONFIGS, RecogniserConfig, train_recogniser
from active_perceiver.scenes import Scene
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.inputs import open_backbone, open_scenes
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures

LOG = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Rooms:
    """What recognisers are trained on.

    Attributes:
        scenes: each is trained in on its own.
        features: of each.
        backbone: that made them.
    """

    scenes: tuple[Scene, ...]
    features: tuple[SceneFeatures, ...]
    backbone: Backbone

    def start(self) -> str | None:
        """Fingerprint of the weights that trainings start from; None if there are none for this backbone."""
        path = pretrained_path(CONFIGS["matching"].kind, self.backbone.name, self.backbone.image_size)
        return hashlib.sha256(path.read_bytes()).hexdigest()[:16] if path.is_file() else None


@dataclass
class RecogniserBenchmark(Benchmark):
    """What each ingredient of the recogniser's training is worth."""

    name = "recogniser"
    settings: RecogniserBenchmarkConfig
    executor: Executor = field(default_factory=SerialExecutor)

    def prepare(self) -> Mapping[str, Any]:
        """See `Benchmark`; the features, which take minutes, are computed when it is clear that runs are missing."""
        settings = self.settings
        self.variants = chosen_variants(settings)
        scenes = open_scenes(settings.scenes)
        for scene in scenes:
            scene.require_targets()
        backbone = open_backbone(TrainConfig(backbone=settings.backbone, image_size=settings.image_size))
        self.rooms = Rooms(scenes, (), backbone)
        return {
            **asdict(settings),
            "backbone": backbone.fingerprint,
            "start": self.rooms.start(),
            "contents": {scene.name: scene.content_hash for scene in scenes},
            "configs": {
                name: asdict(variant.config(scenes[0], settings, 0)) for name, variant in self.variants.items()
            },
        }

    def measure(self, store: RunStore) -> ResultBody:
        """See `measure_recogniser_ablation`."""
        scenes, backbone = self.rooms.scenes, self.rooms.backbone
        if self.rooms.start() is None:
            LOG.info(
                "note: there are no weights to start from for %s at %d pixels; all variants start from random ones",
                backbone.name,
                backbone.image_size,
            )
        rooms = replace(self.rooms, features=tuple(features_of(scene, backbone) for scene in scenes))
        with progress_bar("trainings") as report:
            return measure_recogniser_ablation(rooms, self.variants, self.settings, store, self.executor, report)

    def report(self, body: ResultBody) -> str:
        """See `format_recogniser_ablation`."""
        return format_recogniser_ablation(body)

    def figure(self, body: ResultBody) -> Figure:
        """Average precision by variant."""
        return ablation_figure(ablation_rows(body))


def measure_recogniser_ablation(
    rooms: Rooms,
    variants: Mapping[str, Variant],
    settings: RecogniserBenchmarkConfig,
    store: RunStore,
    executor: Executor,
    progress: ProgressCallback = quiet,
) -> ResultBody:
    """Train every variant in every scene with every seed, one after the other.

    Args:
        rooms: where.
        variants: what, by name.
        settings: how often.
        store: keeps the runs.
        executor: trains.
        progress: called with the trainings done and to do.

    Returns:
        "protocol"; "scenes": "scene", "states", "targets" and "held_out_targets" of each; "summary": see `summary`;
        "runs": for each training what `judged` gives.
    """
    # Seed by seed, so that a disturbance of the machine meets all, and what an interrupted run has is even.
    jobs = list(product(range(settings.seeds), range(len(rooms.scenes)), variants))
    items = {
        f"{rooms.scenes[number].name}, {variant}, seed {seed}": VariantTraining(
            number, variant, variants[variant].config(rooms.scenes[number], settings, seed)
        )
        for seed, number, variant in jobs
    }
    runs = records_of(executor, store, judged, items, rooms, progress)
    ordered = [
        runs[f"{scene.name}, {variant}, seed {seed}"]
        for scene in rooms.scenes
        for variant in variants
        for seed in range(settings.seeds)
    ]
    return {
        "protocol": _protocol(rooms, variants, settings),
        "scenes": [
            {
                "scene": scene.name,
                "states": len(scene),
                "targets": len(scene.targets),
                "held_out_targets": list(scene.target_names[::EVERY]),
            }
            for scene in rooms.scenes
        ],
        "summary": summary(ordered),
        "runs": ordered,
    }


@dataclass(frozen=True)
class VariantTraining:
    """A training to do.

    Attributes:
        number: of the scene.
        variant: its name.
        config: how it is trained.
    """

    number: int
    variant: str
    config: RecogniserConfig


def judged(rooms: Rooms, training: VariantTraining) -> Run:
    """Train a recogniser in one scene and judge it on places it has not been trained in.

    Returns:
        "scene", "variant" and "seed"; "seconds": wall time of training, with making further views and pictures;
        "metrics": for each measurement what `RecognitionMetrics` says of all targets together.
    """
    scene = rooms.scenes[training.number]
    trained = train_recogniser(
        [scene],
        [rooms.features[training.number]],
        training.config,
        lambda done, total, note="": tell(f"{done}/{total} {note}"),
        backbone=rooms.backbone,
    )
    metrics = {name: measured.as_dict() for name, measured in trained.metrics.items()}
    for measured in metrics.values():
        del measured["per_target"]
    about = {"scene": scene.name, "variant": training.variant, "seed": training.config.seed}
    return {**about, "seconds": trained.seconds, "metrics": metrics}


def _protocol(rooms: Rooms, variants: Mapping[str, Variant], settings: RecogniserBenchmarkConfig) -> dict[str, Any]:
    unsaid = ("seed", "threads", "held_out_targets")
    return {
        "judged": "views of places not trained in, up to two pictures of each target in each measurement; objects of "
        "at least 0.3 % of the image count as there, smaller ones neither as there nor as absent",
        "threshold": "the lowest multiple of 0.05 at which at most 0.5 % of the judged views without a target that "
        "was learned count as showing it",
        "seconds": "training, with making further views and pictures; without the scene's own features",
        "seeds": settings.seeds,
        "threads": settings.threads or torch.get_num_threads(),
        "bfloat16": bool(torch.cpu.get_capabilities().get("avx512_bf16")),
        "backbone": rooms.backbone.name,
        "image_size": rooms.backbone.image_size,
        "start": rooms.start(),
        "goals": GOALS,
        "variants": {
            name: {
                "meaning": variant.meaning,
                "never_learned": variant.never_learned,
                "config": {
                    field: value
                    for field, value in asdict(variant.config(rooms.scenes[0], settings, 0)).items()
                    if field not in unsaid
                },
            }
            for name, variant in variants.items()
        },
    }
