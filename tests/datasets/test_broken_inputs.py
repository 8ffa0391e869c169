"""Two hundred broken inputs: each gives a clear error or a sound scene, no traceback, no hang, no partial file."""

from dataclasses import replace
from pathlib import Path

import pytest

import active_perceiver.cli.main
from active_perceiver.scenes import Scene, SceneError, load_scene
from active_perceiver.scenes.hdf5_heaps import check_heaps
from helpers.broken_inputs import SOURCES, Verdict, judged, run_inputs

COUNTS = {
    "scene": 50, "coco": 24, "photos": 40, "moves": 14, "zhu": 24, "savn": 24, "savn_map": 6, "avd": 12,
    "avd_poses": 6,
}  # fmt: skip


@pytest.fixture(scope="module")
def verdicts() -> list[Verdict]:
    return run_inputs(COUNTS, seed=6)


@pytest.mark.xdist_group("broken_inputs")
def test_each_gives_a_clear_error_or_a_sound_scene(verdicts: list[Verdict]) -> None:
    assert [verdict for verdict in verdicts if verdict.problem] == []


@pytest.mark.xdist_group("broken_inputs")
def test_they_are_many_and_of_many_kinds(verdicts: list[Verdict]) -> None:
    assert COUNTS.keys() == SOURCES.keys()
    assert [verdict.number for verdict in verdicts] == list(range(200))
    assert len({verdict.done.split()[1] for verdict in verdicts}) > 20
    refused = [verdict.said for verdict in verdicts if verdict.said not in ("0", "1")]
    assert 120 < len(refused) < 195
    assert len(set(refused)) > 90


@pytest.mark.parametrize(
    ("faulty", "problem"),
    {
        "raises": (lambda out: 1 / 0, "traceback"),
        "says nothing": (lambda out: 2, "it said"),
        "writes nothing": (lambda out: 0, "but wrote"),
        "leaves a part": (lambda out: (out.with_suffix(".part").write_text(""), 0)[1], "but wrote"),
        "writes nonsense": (lambda out: (out.write_text("nonsense"), 0)[1], "not sound"),
    }.values(),
)
def test_a_command_that_does_otherwise_would_be_noticed(faulty, problem, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(
        active_perceiver.cli.main, "main", lambda words: faulty(Path(words[words.index("--out") + 1]))
    )
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    found, _ = judged(SOURCES["zhu"], tmp_path / "in", tmp_path / "out", "dump.h5")
    assert problem in found


def test_heaps_that_would_be_read_for_ever_are_refused(scene_file: Path, tmp_path: Path) -> None:
    """HDF5's library (2.0) never comes to an end in such a file."""
    data = scene_file.read_bytes()
    check_heaps(scene_file)
    start = data.index(b"GCOL\x01") + 16
    for number, hole in enumerate(
        (slice(start, start + 16), slice(start, start + 2000), slice(start + 8, start + 16))
    ):
        path = tmp_path / f"{number}.h5"
        path.write_bytes(data[: hole.start] + b"\0" * (hole.stop - hole.start) + data[hole.stop :])
        with pytest.raises(SceneError, match=rf"{number}.h5: the values of varying length at byte {start - 16}"):
            load_scene(path)


@pytest.mark.parametrize("name", ["a\nb", "\x1b[2J", "\udcff", "x" * 2000, ".", ".."])
def test_names_that_no_file_can_hold_are_refused(name: str, scene: Scene) -> None:
    with pytest.raises(SceneError, match="name"):
        replace(scene.targets[0], name=name)


def test_a_scene_must_have_a_size_an_angle_and_actions(scene: Scene) -> None:
    for change in ({"image_size": 0}, {"fov": float("nan")}, {"fov": 0.0}, {"actions": (scene.actions[0],) * 8}):
        with pytest.raises(SceneError):
            replace(scene, **change)


def test_brackets_in_an_error_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "a [red] room [/bold]"
    assert (
        active_perceiver.cli.main.main(["scenes", "import", "zhu", str(folder), "--out", str(tmp_path / "out.h5")])
        == 2
    )
    assert str(folder) in capsys.readouterr().err
