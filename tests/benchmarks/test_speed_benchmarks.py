"""`benchmark env` and `benchmark act`, as a user runs them, tiny; nothing here depends on how fast the machine is."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from active_perceiver.benchmarks.act.worker import PARTS
from active_perceiver.cli.main import main
from helpers.small import SIZE

SMALL = ["--image-size", str(SIZE), "--frame", "64", "48", "--threads", "1", "--repeats", "3", "--starts", "1"]


@pytest.mark.parametrize("what", ["render", "env", "act"])
def test_help_has_examples(what: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["benchmark", what, "--help"])
    assert stopped.value.code == 0
    assert f"active-perceiver benchmark {what}" in capsys.readouterr().out.split("Examples:")[1]


def test_env_measures_every_environment(scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, picture = tmp_path / "env.json", tmp_path / "env.png"
    arguments = ["benchmark", "env", "--scene", str(scene_file), "--seconds", "0.02", "--counts", "1", "7"]
    assert main([*arguments, "--out", str(out), "--picture", str(picture)]) == 0
    result = json.loads(out.read_text())
    assert result["command"] == "benchmark env"
    assert result["protocol"]["scene"] == "toy_0"
    speeds = {(speed["environment"], speed["searches"]): speed for speed in result["speeds"]}
    vectors = [(name, count) for count in (1, 7) for name in ("SyncVectorEnv", "SearchVectorEnv", "Searches")]
    assert list(speeds) == [("SearchEnv", 1), *vectors]
    for (_, count), speed in speeds.items():
        assert 0 < speed["per_second"]["least"] <= speed["per_second"]["median"] <= speed["per_second"]["most"]
        assert speed["steps"] % count == 0
        assert speed["steps"] >= count * result["protocol"]["rounds"]
    assert "SearchVectorEnv" in capsys.readouterr().out
    assert Image.open(picture).format == "PNG"


def check_times(entry: dict[str, Any]) -> None:
    times = entry["ms"]
    assert list(times) == [*PARTS, "rest", "whole"]
    for part in PARTS:
        assert 0 < times[part]["median"] <= times[part]["p95"]
        assert times[part]["median"] <= times["whole"]["median"]
    assert times["rest"]["median"] > 0
    means = [times[part]["mean"] for part in (*PARTS, "rest")]
    assert sum(means) == pytest.approx(times["whole"]["mean"], rel=1e-3)
    cold = entry["cold_start"]
    assert list(cold) == ["import", "load", "reset", "first action", "whole"]
    assert min(cold.values()) > 0
    assert max(cold.values()) == cold["whole"]
    assert entry["torch_imported"] is False
    assert entry["peak_memory_gib"] is None or 0.01 < entry["peak_memory_gib"] < 100


def test_act_without_an_agent_measures_random_weights_beside_torch(
    scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ACTIVE_PERCEIVER_CACHE", str(tmp_path / "cache"))
    out, picture = tmp_path / "act.json", tmp_path / "act.png"
    arguments = ["benchmark", "act", "--scene", str(scene_file), "--backbones", "efficientnet_lite0", *SMALL]
    assert main([*arguments, "--out", str(out), "--picture", str(picture)]) == 0
    result = json.loads(out.read_text())
    (entry,) = result["actions"]
    assert (entry["backbone"], entry["image_size"], entry["threads"]) == ("efficientnet_lite0", SIZE, 1)
    assert entry["weights"] == "random"
    assert not (tmp_path / "cache").exists()  # random weights must never be taken for the published ones
    check_times(entry)
    eager = entry["torch"]
    assert eager["torch_imported"] is True
    assert 0 < eager["ms"]["backbone"]["median"] <= eager["ms"]["backbone"]["p95"]
    text = capsys.readouterr().out
    assert "weights: random" in text
    assert f"{entry['ms']['whole']['median']:.2f}" in text
    assert Image.open(picture).format == "PNG"


def test_act_measures_a_given_agent_without_torch(
    wanderer: Path, scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from active_perceiver.benchmarks.act import measure as act_speed

    monkeypatch.setattr(act_speed, "find_spec", lambda _: None)
    out = tmp_path / "act.json"
    arguments = ["benchmark", "act", "--scene", str(scene_file), "--agent", str(wanderer), *SMALL]
    assert main([*arguments, "--starts", "2", "--out", str(out)]) == 0
    (entry,) = json.loads(out.read_text())["actions"]
    assert entry["weights"] == "the agent's"
    assert entry["torch"] is None
    check_times(entry)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["env", "--scene", "atlantis"], "neither a bundled scene"),
        (["env", "--seconds", "0"], "must be positive"),
        (["env", "--counts", "0"], "must be positive"),
        (["act", "--scene", "atlantis"], "neither a bundled scene"),
        (["act", "--backbones", "resnet51"], "there is no backbone 'resnet51'"),
        (["act", "--image-size", "100", "--backbones", "resnet50"], "multiple of 32"),
        (["act", "--threads", "0"], "must be at least 1"),
        (["act", "--agent", "nowhere"], "is not an agent"),
        (["act", "--agent", "nowhere", "--backbones", "resnet50"], "not both"),
    ],
)
def test_wrong_input_is_explained(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["benchmark", *arguments]) == 2
    error = capsys.readouterr().err.replace("\n", " ")
    assert message in error
    assert "Traceback" not in error


@pytest.mark.parametrize("what", ["env", "act"])
@pytest.mark.parametrize("option", ["--out", "--picture"])
def test_what_is_there_is_not_overwritten(
    what: str, option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "precious"
    path.write_text("precious")
    assert main(["benchmark", what, option, str(path)]) == 2
    assert "--force" in capsys.readouterr().err
    assert path.read_text() == "precious"


def test_force_replaces(scene_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "env.json"
    out.write_text("old")
    arguments = ["benchmark", "env", "--scene", str(scene_file), "--seconds", "0.001", "--counts", "2"]
    assert main([*arguments, "--out", str(out), "--force"]) == 0
    assert json.loads(out.read_text())["protocol"]["seconds"] == 0.001


def test_a_damaged_agent_is_named(wanderer: Path, scene_file: Path, tmp_path: Path, capsys: Any) -> None:
    shutil.copytree(wanderer, tmp_path / "agent")
    (tmp_path / "agent" / "policy.onnx").write_bytes(b"broken")
    arguments = ["benchmark", "act", "--scene", str(scene_file), "--agent", str(tmp_path / "agent"), *SMALL]
    assert main(arguments) == 2
    assert "policy.onnx is not a readable ONNX model" in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.skipif(sys.platform != "linux", reason="tells its memory another way")
def test_peak_memory_is_that_of_the_process_alone() -> None:
    ballast = np.ones(2**25)  # 256 MiB, more than the small process below needs
    script = "from active_perceiver.utils.memory import peak_memory; print(peak_memory())"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert 0.005 < float(done.stdout) < ballast.nbytes / 2**30 / 2
