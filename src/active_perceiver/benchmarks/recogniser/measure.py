"""What each ingredient of the recogniser's training is worth, and how good it is on targets it never learned."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any

import torch

from active_perceiver.benchmarks.config import RecogniserBenchmarkConfig
from active_perceiver.benchmarks.outputs import check_outputs, write_outputs
from active_perceiver.benchmarks.recogniser.report import GOALS, ablation_rows, format_recogniser_ablation, summary
from active_perceiver.benchmarks.recogniser.variants import EVERY, Variant, chosen_variants
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.figures.ablation import ablation_figure
from active_perceiver.parallel.run_store import check_resume, kept_runs
from active_perceiver.recognition.pretrained import pretrained_path
from active_perceiver.recognition.train import CONFIGS, RecogniserConfig, train_recogniser
from active_perceiver.scenes import Scene
from active_perceiver.training.common import open_backbone, open_scenes
from active_perceiver.training.config import TrainConfig
from active_perceiver.utils.progress import ProgressCallback, console, progress_bar, quiet
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures

Run = dict[str, Any]


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


def recogniser_command(
    settings: RecogniserBenchmarkConfig,
    out: Path | None = None,
    picture: Path | None = None,
    *,
    force: bool = False,
    resume: bool = False,
) -> dict[str, Any]:
    """Measure, print a table, write the result and the picture if they are asked for.

    With `out`, finished trainings are kept beside it until all are done, and `resume` goes on after them.

    Args:
        settings: what is trained, where and how often.
        out: the JSON file.
        picture: the PNG file.
        force: replace existing files.
        resume: go on with an interrupted run.

    Returns:
        The body of the result file, see `measure_recogniser_ablation`.

    Raises:
        OutputExistsError: if a file exists, or trainings are kept, and neither `force` nor `resume` says what to do.
        UserError: if the settings make no sense, or a scene or the backbone is not to be had.
    """
    # An interrupted run has not written its result yet, so `resume` has nothing to say about an existing one.
    check_outputs(force, out, picture)
    variants = chosen_variants(settings)
    check_resume(resume, out)
    scenes = open_scenes(settings.scenes)
    for scene in scenes:
        scene.require_targets()
    backbone = open_backbone(TrainConfig(backbone=settings.backbone, image_size=settings.image_size))
    # Kept runs are compared by what they depend on before the features, which take minutes, are computed.
    rooms = Rooms(scenes, (), backbone)
    facts = {
        **asdict(settings),
        "backbone": backbone.fingerprint,
        "start": rooms.start(),
        "contents": {scene.name: scene.content_hash for scene in scenes},
        "configs": {name: asdict(variant.config(scenes[0], settings, 0)) for name, variant in variants.items()},
    }
    with kept_runs(out, facts, force=force, resume=resume) as (done, keep):
        if rooms.start() is None:
            console.print(
                f"note: there are no weights to start from for {backbone.name} at {backbone.image_size} pixels; all "
                "variants start from random ones",
                highlight=False,
            )
        rooms = Rooms(scenes, tuple(features_of(scene, backbone) for scene in scenes), backbone)
        with progress_bar("trainings") as report:
            body = measure_recogniser_ablation(rooms, variants, settings, done, keep, report)
        print(format_recogniser_ablation(body))
        write_outputs("benchmark recogniser", body, out, picture, lambda: ablation_figure(ablation_rows(body)))
    return body


def measure_recogniser_ablation(
    rooms: Rooms,
    variants: Mapping[str, Variant],
    settings: RecogniserBenchmarkConfig,
    done: Sequence[Run] = (),
    keep: Callable[[Run], None] = lambda run: None,
    progress: ProgressCallback = quiet,
) -> dict[str, Any]:
    """Train every variant in every scene with every seed, one after the other.

    Args:
        rooms: where.
        variants: what, by name.
        settings: how often.
        done: runs that are finished already.
        keep: is called with each run that is finished.
        progress: called with the trainings done and to do.

    Returns:
        "protocol"; "scenes": "scene", "states", "targets" and "held_out_targets" of each; "summary": see `summary`;
        "runs": for each training "scene", "variant", "seed" and what `judged` gives.
    """
    runs = {(run["scene"], run["variant"], run["seed"]): run for run in done}
    # Seed by seed, so that a disturbance of the machine meets all, and what an interrupted run has is even.
    jobs = list(product(range(settings.seeds), range(len(rooms.scenes)), variants))
    for count, (seed, number, variant) in enumerate(jobs):
        scene = rooms.scenes[number]
        key = (scene.name, variant, seed)
        if key not in runs:
            config = variants[variant].config(scene, settings, seed)
            job = f"{scene.name}, {variant}, seed {seed}"
            measured = judged(rooms, number, config, _counted(progress, count, len(jobs), job))
            runs[key] = {"scene": scene.name, "variant": variant, "seed": seed, **measured}
            keep(runs[key])
    progress(len(jobs), len(jobs))
    ordered = [
        runs[scene.name, variant, seed]
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


def judged(rooms: Rooms, number: int, config: RecogniserConfig, progress: ProgressCallback = quiet) -> Run:
    """Train a recogniser in one scene and judge it on places it has not been trained in.

    Returns:
        "seconds": wall time of training, with making further views and pictures; "metrics": for each measurement
        what `RecognitionMetrics` says of all targets together.
    """
    trained = train_recogniser(
        [rooms.scenes[number]],
        [rooms.features[number]],
        config,
        lambda step, total, _: progress(step, total, "updates"),
        backbone=rooms.backbone,
        further_progress=lambda done, total: progress(done, total, "further views and pictures"),
    )
    metrics = {name: measured.as_dict() for name, measured in trained.metrics.items()}
    for measured in metrics.values():
        del measured["per_target"]
    return {"seconds": trained.seconds, "metrics": metrics}


def _counted(progress: ProgressCallback, count: int, of: int, job: str) -> ProgressCallback:
    """Within one of several trainings, which the bar counts, the note says how far it is."""

    def report(done: int, total: int, note: str = "") -> None:
        progress(count, of, f"{job}: {done}/{total} {note}")

    progress(count, of, job)
    return report


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
