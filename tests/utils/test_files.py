"""Files appear whole or not at all, and a place that cannot be written to is named."""

from pathlib import Path

import pytest

from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.utils.files import OutputError, OutputExistsError, replacing, replacing_folder

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
