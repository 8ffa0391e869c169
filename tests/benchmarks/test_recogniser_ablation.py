"""`benchmark recogniser`: as a user runs it, tiny; its figures are those of the training it names, and it goes on."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from active_perceiver.benchmarks.config import RecogniserBenchmarkConfig
from active_perceiver.benchmarks.recogniser import measure as recogniser
from active_perceiver.benchmarks.recogniser.measure import RecogniserBenchmark
from active_perceiver.benchmarks.recogniser.report import (
    ablation_rows,
    format_recogniser_ablation,
    keeps_goals,
    summary,
)
from active_perceiver.benchmarks.recogniser.variants import VARIANTS, chosen_variants
from active_perceiver.benchmarks.runner import OutputFiles, run_benchmark
from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.parallel.executor import SerialExecutor
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.recognition import RecognitionMetrics
from active_perceiver.recognition.train import CONFIGS, NO_AUGMENTATION, train_recogniser
from active_perceiver.scenes import Scene
from active_perceiver.utils.files import OutputExistsError
from active_perceiver.vision import Backbone, scene_features
from helpers.interrupted import InterruptedExecutor

TINY = ["--image-size", "96", "--threads", "1"]
QUICK = ("as before", "not trained here", "pooled", "pooled, targets held out")
"""Variants that make no further images."""


def command(scene_file: Path, *arguments: str) -> list[str]:
    return ["benchmark", "recogniser", "--scenes", str(scene_file), *TINY, *arguments]


def run(seed: int = 0, **changes: Any) -> dict[str, Any]:
    figures = {
        "auroc": 0.999, "ap50": 0.97, "mean_iou": 0.8, "recall": 0.9, "false_positive_rate": 0.004,
        "calibration_error": 0.01,
    }  # fmt: skip
    metrics = {name: {**figures, **changes.pop(name, {})} for name in ("seen pictures", "unseen pictures")}
    return {"scene": "toy", "variant": "default", "seed": seed, "seconds": 100.0, "metrics": metrics, **changes}


def test_help_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["benchmark", "recogniser", "--help"])
    assert stopped.value.code == 0
    assert "active-perceiver benchmark recogniser" in capsys.readouterr().out.split("Examples:")[1]


def test_a_run(scene: Scene, scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, picture = tmp_path / "r.json", tmp_path / "r.png"
    arguments = ["--variants", *QUICK, "--steps", "3", "--out", str(out), "--picture", str(picture)]
    assert main(command(scene_file, *arguments)) == 0
    said = capsys.readouterr()
    assert "no weights to start from" in said.err
    result = json.loads(out.read_text())
    assert result["command"] == "benchmark recogniser"
    protocol = result["protocol"]
    assert protocol["start"] is None
    assert {name: about["config"]["steps"] for name, about in protocol["variants"].items()} == {
        "as before": 3, "not trained here": 0, "pooled": 3, "pooled, targets held out": 3,
    }  # fmt: skip
    assert result["scenes"] == [{"scene": "toy_0", "states": len(scene), "targets": 3, "held_out_targets": ["ball0"]}]
    assert [one["variant"] for one in result["runs"]] == list(QUICK)
    assert {tuple(one["metrics"]) for one in result["runs"][:3]} == {("seen pictures", "unseen pictures")}
    assert "unknown targets" in result["runs"][3]["metrics"]
    assert format_recogniser_ablation(result) in said.out  # the table says what the file does
    assert Image.open(picture).format == "PNG"
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".part"] == []


def test_its_figures_are_those_of_the_recogniser_it_trains(scene: Scene, backbone: Backbone, tmp_path: Path) -> None:
    settings = RecogniserBenchmarkConfig(steps=4, threads=1, image_size=96, variants=("pooled, targets held out",))
    features = scene_features(scene, backbone)
    body = recogniser.measure_recogniser_ablation(
        recogniser.Rooms((scene,), (features,), backbone),
        chosen_variants(settings),
        dataclasses.replace(settings, seeds=2),
        RunStore(tmp_path),
        SerialExecutor(),
    )
    for seed, one in enumerate(body["runs"]):
        config = dataclasses.replace(CONFIGS["pooled"], steps=4, held_out_targets=("ball0",), seed=seed, threads=1)
        trained = train_recogniser([scene], [features], config)
        assert one["seed"] == seed
        assert list(one["metrics"]) == ["seen pictures", "unseen pictures", "unknown targets"]
        for name, measured in one["metrics"].items():
            expected = trained.metrics[name].as_dict()
            del expected["per_target"]
            assert measured == expected
            assert set(measured) == {field.name for field in dataclasses.fields(RecognitionMetrics)} - {"per_target"}
    (row,) = body["summary"]
    aps = [one["metrics"]["unseen pictures"]["ap50"] for one in body["runs"]]
    assert row["metrics"]["unseen pictures"]["ap50"] == pytest.approx(sum(aps) / 2)
    (drawn,) = ablation_rows(body)["toy_0"]
    assert drawn.unknown == row["metrics"]["unknown targets"]["ap50"]


def test_an_interrupted_run_goes_on(scene_file: Path, tmp_path: Path) -> None:
    files = OutputFiles(tmp_path / "r.json")
    resumed = dataclasses.replace(files, resume=True)
    settings = RecogniserBenchmarkConfig(
        (str(scene_file),), ("pooled", "as before"), steps=2, threads=1, image_size=96
    )
    first, second = (InterruptedExecutor(SerialExecutor(), at) for at in (2, 0))
    with pytest.raises(KeyboardInterrupt):
        run_benchmark(RecogniserBenchmark(settings, first), files)
    with pytest.raises(OutputExistsError, match="--resume"):
        run_benchmark(RecogniserBenchmark(settings, second), files)
    with pytest.raises(UserError, match="steps, configs"):
        run_benchmark(RecogniserBenchmark(dataclasses.replace(settings, steps=3), second), resumed)
    assert not files.out.exists()
    body = run_benchmark(RecogniserBenchmark(settings, second), resumed)
    # In the order of the page, whatever the order they were named in.
    assert [[one.config.kind for one in some.done] for some in (first, second)] == [["matching"], ["pooled"]]
    assert [one["variant"] for one in body["runs"]] == ["as before", "pooled"]


def test_each_variant_differs_from_the_default_in_what_it_says(scene: Scene) -> None:
    settings = RecogniserBenchmarkConfig()
    configs = {name: variant.config(scene, settings, 5) for name, variant in chosen_variants(settings).items()}
    assert list(configs) == list(VARIANTS)
    assert configs["default"] == dataclasses.replace(CONFIGS["matching"], seed=5)
    assert configs["pooled"] == dataclasses.replace(CONFIGS["pooled"], seed=5)
    default = dataclasses.asdict(configs["default"])
    changed = {
        name: {field for field, value in dataclasses.asdict(config).items() if value != default[field]}
        for name, config in configs.items()
        if config.kind == "matching"
    }
    assert changed == {
        "default": set(),
        "from scratch": {"start"},
        "no further views": {"augmentation"},
        "no further pictures": {"augmentation"},
        "no cut-outs": {"augmentation"},
        "no averaging": {"averaging"},
        "float32": {"precision"},
        "1400 steps": {"steps"},
        "as before": {"start", "augmentation", "averaging", "precision", "steps"},
        "targets held out": {"held_out_targets"},
        "from scratch, targets held out": {"start", "held_out_targets"},
        "not trained here": {"steps"},
    }
    augmentation = {name: dataclasses.astuple(config.augmentation) for name, config in configs.items()}
    views, pictures, crops = augmentation["default"]
    assert min(views, pictures, crops) > 0
    assert augmentation["no further views"] == (0, pictures, crops)
    assert augmentation["no further pictures"] == (views, 0, 0)
    assert augmentation["no cut-outs"] == (views, pictures, 0)
    assert configs["as before"].augmentation == NO_AUGMENTATION


def test_the_page_lists_the_variants() -> None:
    page = (Path(__file__).parents[2] / "docs" / "benchmarks" / "recogniser.md").read_text()
    rows = page.split("| variant |")[1].split("\n\n")[0].splitlines()[2:]
    assert [row.split("`")[1] for row in rows] == list(VARIANTS)


@pytest.mark.parametrize(
    ("changes", "kept"),
    [
        ({}, True),
        ({"seconds": 240.0}, True),
        ({"seconds": 241.0}, False),
        ({"seen pictures": {"auroc": 0.996}}, False),
        ({"unseen pictures": {"auroc": 0.996}}, True),
        ({"unseen pictures": {"ap50": 0.91}}, False),
        ({"unseen pictures": {"false_positive_rate": 0.01}}, False),
        ({"unseen pictures": {"ap50": None}}, False),
        ({"metrics": {}}, False),
    ],
)
def test_the_goals_are_kept_by_all_seeds_or_by_none(changes: dict[str, Any], kept: bool) -> None:
    assert keeps_goals(run(**changes)) is kept
    if "metrics" not in changes:
        (row,) = summary([run(0), run(1, **changes)])
        assert (row["kept"], row["seeds"]) == (kept, 2)


def test_means_are_of_all_seeds_and_what_a_seed_lacks_has_none() -> None:
    rows = summary([
        run(0, seconds=10.0), run(1, seconds=20.0, **{"seen pictures": {"auroc": None, "recall": 0.5}}),
        run(0, variant="float32"),
    ])  # fmt: skip
    assert [(row["variant"], row["seeds"], row["seconds"]) for row in rows] == [
        ("default", 2, 15.0),
        ("float32", 1, 100.0),
    ]
    assert rows[0]["metrics"]["seen pictures"]["recall"] == pytest.approx(0.7)
    assert rows[0]["metrics"]["seen pictures"]["auroc"] is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seeds": 0}, "at least 1"),
        ({"steps": 0}, "at least 1"),
        ({"threads": 0}, "at least 1"),
        ({"variants": ("no luck",)}, "no variant 'no luck'; there are 'default'"),
        ({"scenes": ()}, "at least one"),
        ({"scenes": ("nowhere.h5",)}, "nowhere"),
    ],
)
def test_wrong_settings_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        RecogniserBenchmark(RecogniserBenchmarkConfig(**change)).prepare()


def test_resume_needs_a_result_file() -> None:
    with pytest.raises(UserError, match="--out"):
        run_benchmark(RecogniserBenchmark(RecogniserBenchmarkConfig()), OutputFiles(resume=True))


@pytest.mark.parametrize("option", ["--out", "--picture"])
def test_what_is_there_is_not_overwritten(
    option: str, scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "precious"
    path.write_text("precious")
    assert main(command(scene_file, option, str(path))) == 2
    assert "--force" in capsys.readouterr().err
    assert path.read_text() == "precious"
