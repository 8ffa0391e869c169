"""Files appear whole or not at all, and a place that cannot be written to is named."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.utils import temporaries
from active_perceiver.utils.files import OutputError, OutputExistsError, replacing, replacing_folder
from active_perceiver.utils.temporaries import temporary_prefix

FULL_DISK = Path("/dev/full")


def test_a_file_takes_its_place_when_it_is_whole(tmp_path):
    path = tmp_path / "new" / "result.json"
    with replacing(path) as temporary:
        temporary.write_text("1")
        assert not path.exists()
    with pytest.raises(ZeroDivisionError), replacing(path):
        raise ZeroDivisionError
    with pytest.raises(OutputExistsError, match="--force"), replacing(path, force=False):
        pytest.fail("it began")
    assert path.read_text() == "1"
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("make", [replacing, replacing_folder])
def test_a_place_below_a_file_is_named(make, tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match=r"file.x cannot be written \(.+\); give another place"), \
            make(tmp_path / "file" / "x"):  # fmt: skip
        pytest.fail("it began")
    assert list(tmp_path.iterdir()) == [tmp_path / "file"]


def test_a_folder_is_not_replaced_by_a_file(tmp_path):
    (tmp_path / "there").mkdir()
    with pytest.raises(OutputError, match="there cannot be written"), replacing(tmp_path / "there") as temporary:
        temporary.write_text("1")
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


@pytest.mark.skipif(not FULL_DISK.exists(), reason="the system has no disk that is always full")
@pytest.mark.parametrize("make", [replacing, replacing_folder])
def test_a_full_disk_is_named_and_nothing_stays(make, tmp_path):
    with pytest.raises(OutputError, match="No space left") as robot_moved, make(tmp_path / "out"):
        FULL_DISK.write_text("x")
    assert robot_moved.value.strerror
    assert list(tmp_path.iterdir()) == []


def test_other_errors_inside_stay_what_they_are(tmp_path):
    with pytest.raises(FileNotFoundError) as robot_moved, replacing(tmp_path / "out"):
        (tmp_path / "elsewhere").read_bytes()
    assert not isinstance(robot_moved.value, UserError)


def test_a_command_says_it_in_a_sentence(tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    grid = [
        "scenes",
        "capture",
        "grid",
        "--across",
        "2",
        "--along",
        "2",
        "--out",
        str(tmp_path / "file" / "poses.csv"),
    ]
    assert main(grid) == 2
    assert "cannot be written" in capsys.readouterr().err


# ---- power cuts


@pytest.fixture
def calls(monkeypatch) -> list[str]:
    """Names of what was flushed, and renamed to, in order; of a temporary file or folder only that it is one."""
    told: list[str] = []
    flushed, replaced, renamed = os.fsync, Path.replace, Path.rename

    def name(path) -> str:
        return "temporary" if ".part" in Path(path).name else Path(path).name

    def fsync(file):
        told.append(f"flush {name(Path(f'/proc/self/fd/{file}').readlink())}")
        flushed(file)

    def replace(self, target):
        told.append(f"rename {name(target)}")
        return replaced(self, target)

    def rename(self, target):
        told.append(f"rename {name(target)}")
        return renamed(self, target)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(Path, "replace", replace)
    monkeypatch.setattr(Path, "rename", rename)
    return told


needs_proc = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="only Linux says what a number stands for")


@needs_proc
def test_a_file_is_on_the_disk_before_its_name_is(tmp_path, calls):
    with replacing(tmp_path / "scene.h5") as temporary:
        temporary.write_text("1")
    assert calls == ["flush temporary", "rename scene.h5", f"flush {tmp_path.name}"]


@needs_proc
def test_a_folder_is_on_the_disk_before_its_name_is(tmp_path, calls):
    (tmp_path / "agent").mkdir()
    with replacing_folder(tmp_path / "agent", force=True) as made:
        (made / "maps").mkdir()
        (made / "config.json").write_text("1")
        (made / "maps" / "room.npz").write_text("1")
        (made / "link").symlink_to("config.json")
    assert calls == [
        "flush config.json", "flush agent", "flush room.npz", "flush maps", "rename .replaced", "rename agent",
        f"flush {tmp_path.name}",
    ]  # fmt: skip


def test_a_disk_that_cannot_flush_will_do(tmp_path, monkeypatch):
    def refuse(file):
        raise OSError(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr(os, "fsync", refuse)
    with replacing(tmp_path / "out") as temporary:
        temporary.write_text("1")
    assert (tmp_path / "out").read_text() == "1"


def test_a_disk_that_is_full_when_it_is_flushed_is_named(tmp_path, monkeypatch):
    (tmp_path / "out").write_text("old")

    def full(file):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match="out cannot be written"), replacing(tmp_path / "out") as temporary:
        temporary.write_text("new")
    assert (tmp_path / "out").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


# ---- killed runs

WRITE_AND_WAIT = """
import sys, pathlib
from active_perceiver.utils.files import {make}
with {make}(pathlib.Path(sys.argv[1])) as temporary:
    print("begun", flush=True)
    sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def no_folder_was_looked_through(monkeypatch):
    monkeypatch.setattr(temporaries, "_looked_through", set())


@pytest.fixture
def writing():
    """Starts a process that has begun to write, and is killed by `.kill()`."""
    running = []

    def start(make: str, path: Path) -> subprocess.Popen:
        process = subprocess.Popen(
            [sys.executable, "-c", WRITE_AND_WAIT.format(make=make), path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        running.append(process)
        assert process.stdout.readline() == b"begun\n"
        return process

    yield start
    for process in running:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("make", ["replacing", "replacing_folder"])
def test_what_a_killed_run_left_is_removed_by_the_next(make, tmp_path, writing):
    killed, running = writing(make, tmp_path / "old.h5"), writing(make, tmp_path / "other.h5")
    killed.kill()
    killed.wait()
    foreign = [tmp_path / ".a.part", tmp_path / ".old.h5.abcd1234.part.h5", tmp_path / ".x.ap-00000000-1-1-abc.part"]
    for path in foreign:
        path.write_text("mine")
    with replacing(tmp_path / "new"):
        pass
    left = {path.name.partition(".ap-")[0] for path in tmp_path.iterdir() if path not in foreign}
    assert left == {"new", ".other.h5"}, "what runs is left alone"
    assert all(path.read_text() == "mine" for path in foreign)
    assert running.poll() is None


def test_a_process_with_the_number_of_one_that_was_killed_keeps_nothing(tmp_path):
    name = temporary_prefix(tmp_path / "old").rsplit("-", 2)[0]  # without when it was started
    (tmp_path / f"{name}-12-x.part").write_text("")
    with replacing(tmp_path / "new"):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["new"]


def test_a_folder_killed_while_it_took_its_place_takes_it(tmp_path):
    ours = tmp_path / (temporary_prefix(tmp_path / "agent").replace(f"-{os.getpid()}-", "-999999999-") + "x.part")
    for place, text in (("agent", "new"), (".replaced", "old")):
        (ours / place).mkdir(parents=True)
        (ours / place / "config.json").write_text(text)
    with replacing(tmp_path / "other"):
        pass
    assert sorted(path.name for path in tmp_path.iterdir()) == ["agent", "other"]
    assert (tmp_path / "agent" / "config.json").read_text() == "new"


def test_names_may_be_as_long_as_the_system_lets_them(tmp_path):
    with replacing(tmp_path / ("ä" * 120)) as temporary:
        temporary.write_text("1")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["1"]
