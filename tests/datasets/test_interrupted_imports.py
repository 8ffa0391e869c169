"""Ctrl-C in the middle of an import leaves no file behind, and what was there before as it was."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from active_perceiver.cli.main import main
from active_perceiver.scenes import load_scene, storage
from active_perceiver.utils import progress
from active_perceiver.utils.progress import ProgressCallback
from helpers.broken_inputs import SOURCES

IMPORTS = ("photos", "zhu", "savn", "avd")


@contextmanager
def interrupted_bar(label: str) -> Iterator[ProgressCallback]:
    """A progress bar during which somebody presses Ctrl-C after the third view."""

    def report(done: int, total: int, note: str = "") -> None:
        assert total > 3
        if done == 3:
            raise KeyboardInterrupt

    yield report


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def interrupted_while_writing(*arguments: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("place", "name", "interruption"),
    [(progress, "progress_bar", interrupted_bar), (storage, "_write_blobs", interrupted_while_writing)],
    ids=["reading", "writing"],
)
@pytest.mark.parametrize("source", IMPORTS)
def test_an_interrupted_import_leaves_nothing(  # type: ignore[no-untyped-def]
    source, place, name, interruption, tmp_path: Path, monkeypatch, capsys
) -> None:
    given, out = tmp_path / "in", tmp_path / "out" / "scene.h5"
    given.mkdir()
    SOURCES[source].write(given)
    before = files(given)
    command = [word.replace("{}", str(given)) for word in SOURCES[source].command]
    command += ["--out", str(out), "--image-size", "24"]
    with monkeypatch.context() as patch:
        patch.setattr(place, name, interruption)
        assert main(command) == 130
        assert "interrupted" in capsys.readouterr().err
        assert files(out.parent) == {}
        out.parent.mkdir(exist_ok=True)
        out.write_bytes(b"an earlier scene")
        assert main([*command, "--force"]) == 130
    assert files(out.parent) == {"scene.h5": b"an earlier scene"}
    assert files(given) == before
    assert main([*command, "--force"]) in (0, 1)
    assert len(load_scene(out)) > 3
