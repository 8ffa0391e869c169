"""Broken inputs put through the command line, each judged: a clear error or a sound scene, and nothing left behind.

`run_inputs` runs this file as a process, with how many inputs of each source, a seed and the number of the first one:
damaged files can take a process with them, in C. A line of JSON comes before each input, one with the verdict after
it; after an input that ended the process, another one goes on.
"""

from __future__ import annotations

import contextlib
import faulthandler
import io
import json
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np

from active_perceiver.datasets.coco.writer import coco_annotations
from active_perceiver.datasets.photos.pose_table import write_moves
from active_perceiver.scenes import Scene, load_scene, save_scene
from helpers.breaking import broken
from helpers.foreign import avd_scene, savn_scene, write_avd, write_savn, write_zhu, zhu_scene
from helpers.photographs import photograph_scene
from helpers.toy import toy_scene

LIMIT = 20
"""Seconds after which an input counts as one that hangs."""


@dataclass(frozen=True)
class Source:
    """Sound files, and the command that makes a scene of them.

    Attributes:
        write: writes them into a folder that is there.
        command: words of the command, `{}` for that folder.
        files: patterns of the files that are broken, the same one twice to break it more often.
        image_size: of the scene that is made; None if the command has no such option.
    """

    write: Callable[[Path], None]
    command: tuple[str, ...]
    files: tuple[str, ...]
    image_size: int | None = 24


@dataclass(frozen=True)
class Verdict:
    """What came of an input.

    Attributes:
        number: of the input.
        done: which file was broken, and how.
        problem: what is wrong with what came of it; empty if nothing is.
        said: the error, or the exit code if there was none.
        seconds: how long it took.
    """

    number: int
    done: str
    problem: str
    said: str
    seconds: float


def _small_scene() -> Scene:
    scene = toy_scene(side=2, image_size=24, targets=2, tilts=(0.0, 30.0))
    labels = np.full(len(scene), 2, np.uint8)
    labels[0] = 1
    return replace(scene, labels=labels)


def _write_scene(folder: Path) -> None:
    scene = _small_scene()
    save_scene(scene, folder / "room.h5")
    (folder / "boxes.json").write_text(json.dumps(coco_annotations(scene)))


def _write_photos(folder: Path) -> None:
    scene = _small_scene()
    photograph_scene(scene, folder / "photos", size=(48, 36))


def _write_photos_with_moves(folder: Path) -> None:
    _write_photos(folder)
    scene = _small_scene()
    names = [f"IMG_{state:04d}.jpg" for state in range(len(scene))]
    write_moves(folder / "photos" / "moves.csv", names, scene.actions, scene.transitions)


def _write_zhu(folder: Path) -> None:
    """A dump whose pictures are a tenth as large, so that the rest of it is hit, too."""
    write_zhu(folder / "large.h5", zhu_scene(side=2), crops=1)
    with h5py.File(folder / "large.h5") as large, h5py.File(folder / "dump.h5", "w") as file:
        for name in large:
            file[name] = large[name][:, ::10, ::10] if name == "observation" else large[name][()]
    (folder / "large.h5").unlink()


def _write_savn(folder: Path) -> None:
    scene = savn_scene(side=2, image_size=32, headings=(0, 90, 180, 270))
    write_savn(folder / "FloorPlan1_physics", scene, boxes=True)


def _write_savn_without_boxes(folder: Path) -> None:
    write_savn(folder / "FloorPlan1_physics", savn_scene(side=2, image_size=16, headings=(0, 90, 180, 270)))


def _write_avd(folder: Path) -> None:
    write_avd(folder / "Home_001_1", avd_scene(side=2, headings=(0, 30, 60, 90)), width=128, height=96)


_IMPORT = ("scenes", "import")
_PHOTOS = (*_IMPORT, "photos", "{}/photos")
_SAVN = (*_IMPORT, "savn", "{}/FloorPlan1_physics")
_AVD = (*_IMPORT, "avd", "{}/Home_001_1")
SOURCES = {
    "scene": Source(_write_scene, ("scenes", "label", "{}/room.h5", "--from", "{}/boxes.json"), ("room.h5",), None),
    "coco": Source(_write_scene, ("scenes", "label", "{}/room.h5", "--from", "{}/boxes.json"), ("boxes.json",), None),
    "photos": Source(
        _write_photos, _PHOTOS,
        ("photos/poses.csv", "photos/poses.csv", "photos/annotations.json", "photos/*.jpg", "photos/targets/*/*"),
    ),
    "moves": Source(_write_photos_with_moves, _PHOTOS, ("photos/moves.csv", "photos/poses.csv")),
    "zhu": Source(_write_zhu, (*_IMPORT, "zhu", "{}/dump.h5"), ("dump.h5",)),
    "savn": Source(
        _write_savn, _SAVN,
        ("*/graph.json", "*/metadata.json", "*/metadata.json", "*/images.hdf5", "*/grid.json"),
    ),
    "savn_map": Source(_write_savn_without_boxes, _SAVN, ("*/visible_object_map.json",)),
    "avd": Source(
        _write_avd, _AVD, ("*/annotations.json", "*/annotations.json", "instance_id_map.txt", "*/jpg_rgb/*")
    ),
    "avd_poses": Source(_write_avd, _AVD, ("*/image_structs.mat",)),
}  # fmt: skip


def run_inputs(counts: dict[str, int], seed: int) -> list[Verdict]:
    """Break the files of each source in so many ways; one verdict for each."""
    verdicts: list[Verdict] = []
    while len(verdicts) < sum(counts.values()):
        words = [sys.executable, "-m", "helpers.broken_inputs", json.dumps(counts), str(seed), str(len(verdicts))]
        ran = subprocess.run(words, capture_output=True, text=True, check=False, cwd=Path(__file__).parents[1])
        lines = [json.loads(line) for line in ran.stdout.splitlines()]
        assert lines, ran.stderr
        verdicts += [Verdict(**line) for line in lines if "problem" in line]
        if "problem" not in lines[-1]:  # the process died, or the input took too long
            problem = f"the process ended with {ran.returncode}: {ran.stderr[-3000:]}"
            verdicts.append(Verdict(**lines[-1], problem=problem, said="", seconds=np.nan))
    return verdicts


def broken_folders(
    counts: dict[str, int], seed: int, first: int, place: Path
) -> Iterator[tuple[Source, Path, str, str]]:
    """For one input after the other its source, a folder with it, the broken file in there, and what was done."""
    sound, folder, written = place / "sound", place / "in", ""
    for source, number in [(name, number) for name, count in counts.items() for number in range(count)][first:]:
        if source != written:
            shutil.rmtree(sound, ignore_errors=True)
            sound.mkdir()
            SOURCES[source].write(sound)
            written = source
        rng = np.random.default_rng([seed, *source.encode(), number])
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(sound, folder)
        patterns = SOURCES[source].files
        found = sorted(folder.glob(patterns[number % len(patterns)]))
        path = found[int(rng.integers(len(found)))]
        done, data = broken(path.read_bytes(), path.suffix, rng)
        path.write_bytes(data)
        yield SOURCES[source], folder, str(path.relative_to(folder)), done


def _files(folder: Path) -> dict[str, int]:
    return {str(path.relative_to(folder)): path.stat().st_size for path in folder.rglob("*") if path.is_file()}


def judged(source: Source, folder: Path, out: Path, path: str) -> tuple[str, str]:
    """Run the command; what is wrong with what came of it, and what it said."""
    from active_perceiver.cli.main import main

    words = [word.replace("{}", str(folder)) for word in source.command]
    words += ["--out", str(out / "scene.h5")]
    words += [] if source.image_size is None else ["--image-size", str(source.image_size)]
    before = _files(folder)
    # As Python opens them in a terminal: text that cannot be encoded is an error on standard output only.
    printed = io.TextIOWrapper(io.BytesIO(), "utf-8")
    complained = io.TextIOWrapper(io.BytesIO(), "utf-8", "backslashreplace")
    with warnings.catch_warnings(), contextlib.redirect_stdout(printed), contextlib.redirect_stderr(complained):
        warnings.simplefilter("always")
        try:
            code = main(words)
        except BaseException:
            return f"traceback: {traceback.format_exc()}", ""
    complained.seek(0)
    lines = [line for line in complained.read().replace("\r", "\n").split("\n") if line.strip()]
    lines = [line for line in lines if not line.startswith("views  ")]  # the progress bar
    left = sorted(_files(out))
    if _files(folder) != before:
        return f"the input's folder has {sorted(_files(folder).items() ^ before.items())}", ""
    if code in (0, 1):
        if lines:
            return f"it is well, but said {lines}", ""
        if left != ["scene.h5"]:
            return f"it is well, but wrote {left}", ""
        try:
            load_scene(out / "scene.h5")
        except Exception as error:
            return f"what it wrote is not sound: {error}", ""
        return "", str(code)
    if len(lines) != 1 or not lines[0].startswith("error: ") or any(ord(sign) < 32 for sign in lines[0]):
        return f"exit code {code}, it said {lines}", ""
    if left:
        return f"an error, but {left} is left", ""
    if Path(path).name not in lines[0] and str(folder) not in lines[0] and "of scene 'toy_0'" not in lines[0]:
        return f"no file is named: {lines[0]}", ""
    if len(lines[0]) > 700:
        return f"the error is too long: {lines[0][:1000]}", ""
    return "", lines[0].replace(str(folder), "").removeprefix("error: ")


def _main(counts: dict[str, int], seed: int, first: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        for number, (source, folder, path, done) in enumerate(broken_folders(counts, seed, first, place), first):
            shutil.rmtree(place / "out", ignore_errors=True)
            (place / "out").mkdir()
            about = {"number": number, "done": f"{path} {done}"}
            print(json.dumps(about), flush=True)
            faulthandler.dump_traceback_later(LIMIT, exit=True)
            start = time.perf_counter()
            problem, said = judged(source, folder, place / "out", path)
            seconds = time.perf_counter() - start
            faulthandler.cancel_dump_traceback_later()
            print(json.dumps({**about, "problem": problem, "said": said, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    faulthandler.enable()
    _main(json.loads(sys.argv[1]), *map(int, sys.argv[2:]))
