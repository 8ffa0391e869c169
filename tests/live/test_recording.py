"""Recordings: what is read is what was seen, whatever happened to the search, and damage is named."""

import dataclasses
import errno
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from active_perceiver.errors import UserError
from active_perceiver.live.recorder import Recorder, RecordingError, check_folder
from active_perceiver.live.recording import read_recording
from active_perceiver.scenes.images import encode_image
from active_perceiver.utils.files import OutputExistsError
from helpers.recorded import record_of, setup_in, step_records_in


@pytest.fixture(scope="module")
def kept(scene, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kept") / "run"
    record_of(scene, folder)
    return folder


@pytest.fixture
def copy(kept, tmp_path):
    return Path(shutil.copytree(kept, tmp_path / "copy"))


@pytest.mark.parametrize("encoded", [False, True])
def test_what_is_read_is_what_was_seen(scene, tmp_path, encoded):
    record = record_of(scene, tmp_path, encoded, max_minutes=float("inf"))
    read = read_recording(tmp_path)
    setup = setup_in(scene, max_minutes=float("inf"))
    assert dataclasses.replace(read.setup, floor=None) == dataclasses.replace(setup, floor=None)
    np.testing.assert_allclose(read.setup.floor.poses, setup.floor.poses)
    np.testing.assert_array_equal(read.setup.floor.floor_plan.outline, scene.floor_plan.outline)
    assert (read.record.found, read.record.seconds, read.record.reason) == (False, 2.5, "max steps")
    np.testing.assert_array_equal(read.record.picture, record.picture)
    for there, here in zip(read.record.step_records, record.step_records, strict=True):
        assert (there.pose, there.robot_moved, there.seconds) == (here.pose, here.robot_moved, here.seconds)
        assert (there.step.action, there.step.found) == (here.step.action, here.step.found)
        np.testing.assert_array_equal(there.step.probabilities, here.step.probabilities)
        assert (there.step.detection is None) == (here.step.detection is None)
        if here.step.detection is not None:
            assert there.step.detection.score == here.step.detection.score
            np.testing.assert_array_equal(there.step.detection.box, here.step.detection.box)
        assert there.frame == (here.frame if encoded else encode_image(here.frame, "jpeg", 92))
    assert {path.suffix for path in (tmp_path / "frames").iterdir()} == {".png" if encoded else ".jpg"}


def test_images_of_other_kinds_become_jpegs(scene, tmp_path):
    step_record = step_records_in(scene, 1)[0]
    Image.fromarray(step_record.frame).save(tmp_path / "x.bmp")
    with Recorder(tmp_path / "run", setup_in(scene), scene.view(0)) as recorder:
        recorder.keep(dataclasses.replace(step_record, frame=(tmp_path / "x.bmp").read_bytes()))
    kept = (tmp_path / "run" / "frames" / "00000.jpg").read_bytes()
    assert kept == encode_image(step_record.frame, "jpeg", 92)


def test_it_can_be_read_wherever_the_log_was_cut(copy):
    """As a kill at any moment leaves it: a look counts as soon as its line is whole."""
    log = copy / "steps.jsonl"
    whole = log.read_bytes()
    ends = [number + 1 for number, byte in enumerate(whole) if byte == ord("\n")]
    for size in [*range(0, len(whole), 7), *ends, *(end - 1 for end in ends)]:
        log.write_bytes(whole[:size])
        looks = sum(end <= size for end in ends[:-1])
        if not looks:
            with pytest.raises(RecordingError, match="holds no look"):
                read_recording(copy)
            continue
        record = read_recording(copy).record
        assert len(record.step_records) == looks
        if size == len(whole):
            assert record.reason == "max steps"
        else:
            assert (record.ending, record.seconds) == ("cut off", record.step_records[-1].seconds)


def test_a_search_that_was_killed_after_found_has_found(copy):
    log = copy / "steps.jsonl"
    lines = log.read_text().splitlines()[:-1]
    lines[-1] = lines[-1].replace('"found":false', '"found":true')
    log.write_text("\n".join(lines) + "\n")
    assert read_recording(copy).record.ending == "found"


@pytest.mark.parametrize(
    ("error", "reason", "ending"),
    [
        (KeyboardInterrupt(), "interrupted", "interrupted"),
        (UserError("the robot is gone"), "error: the robot is gone", "error"),
        (ValueError("odd"), "error: ValueError odd", "error"),
    ],
    ids=repr,
)
def test_it_notes_why_a_search_did_not_end_by_itself(scene, tmp_path, error, reason, ending):
    def broken_search():
        with Recorder(tmp_path, setup_in(scene), scene.view(0)) as recorder:
            recorder.keep(step_records_in(scene, 1)[0])
            (tmp_path / "steps.jsonl").open("ab").write(b'{"look":1,"fra')  # what an interrupt left
            raise error

    with pytest.raises(type(error)):
        broken_search()
    record = read_recording(tmp_path).record
    assert (record.reason, record.ending, len(record.step_records)) == (reason, ending, 1)


def test_a_full_disk_is_a_sentence(scene, tmp_path, monkeypatch):
    def full(file):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch, Recorder(tmp_path / "run", setup_in(scene), scene.view(0)) as recorder:
        recorder.keep(step_records_in(scene, 1)[0])
        patch.setattr("active_perceiver.live.recorder.os.fsync", full)
        with pytest.raises(RecordingError, match=r"run cannot be written: No space left"):
            recorder.keep(step_records_in(scene, 1)[0])
    assert len(read_recording(tmp_path / "run").record.step_records) == 1


def set_line(number, **changes):
    """A change of one line of the log; a value of ... removes the name."""

    def change(folder: Path) -> None:
        log = folder / "steps.jsonl"
        lines = log.read_text().splitlines()
        value = {**json.loads(lines[number - 1]), **changes}
        lines[number - 1] = json.dumps({name: item for name, item in value.items() if item is not ...})
        log.write_text("\n".join(lines) + "\n")

    return change


def write_line(number, text):
    def change(folder: Path) -> None:
        log = folder / "steps.jsonl"
        lines = log.read_text().splitlines()
        lines[number - 1] = text
        log.write_text("\n".join(lines) + "\n")

    return change


def set_header(**changes):
    def change(folder: Path) -> None:
        path = folder / "recording.json"
        value = {**json.loads(path.read_text()), **changes}
        path.write_text(json.dumps({name: item for name, item in value.items() if item is not ...}))

    return change


LINE = r"line {} of \S*steps\.jsonl"
HEADER = r"recording\.json is damaged: "
DAMAGES = {
    "broken": (write_line(2, '{"look":1'), LINE.format(2) + " is damaged: it is no JSON object"),
    "no object": (write_line(3, "[1]"), LINE.format(3) + " is damaged: it is no JSON object"),
    "nested": (write_line(2, "[" * 100_000), LINE.format(2)),
    "frame missing": (lambda folder: (folder / "frames/00002.jpg").unlink(), LINE.format(3) + ".*00002.jpg.*No such"),
    "frame empty": (lambda folder: (folder / "frames/00002.jpg").write_bytes(b""), LINE.format(3) + ".*00002.jpg"),
    "frame torn": (
        lambda folder: (folder / "frames/00002.jpg").write_bytes((folder / "frames/00001.jpg").read_bytes()[:200]),
        LINE.format(3) + ".*00002.jpg.*broken or truncated",
    ),
    "frame elsewhere": (set_line(1, frame="../picture.png"), LINE.format(1) + ".*frame"),
    "frame no text": (set_line(1, frame=7), LINE.format(1) + ".*`str`, got `int` - at `..frame`"),
    "look left out": (set_line(2, look=4), LINE.format(2) + ".*look is not 1"),
    "look no number": (set_line(2, look=True), LINE.format(2) + ".*`int`, got `bool` - at `..look`"),
    "pose short": (set_line(1, pose=[1, 2, 3]), LINE.format(1) + ".*length 4, got 3 - at `..pose`"),
    "pose NaN": (set_line(1, pose=[1, 2, 3, float("nan")]), LINE.format(1) + ".*pose"),
    "pose huge": (set_line(1, pose=[1, 2, 3, 10**30]), LINE.format(1) + ".*pose"),
    "pose of 400 digits": (set_line(1, pose=[1, 2, 3, 10**400]), LINE.format(1) + ".*401 digits"),
    "moved a number": (set_line(2, moved=1), LINE.format(2) + ".*`bool . null`, got `int` - at `..moved`"),
    "action unknown": (set_line(2, action="Fly"), LINE.format(2) + ".*'Fly' - at `..action`"),
    "action missing": (set_line(2, action=...), LINE.format(2) + ".*missing required field `action`"),
    "found a text": (set_line(1, found="yes"), LINE.format(1) + ".*`bool`, got `str` - at `..found`"),
    "score alone": (set_line(1, box=None), LINE.format(1) + ".*score and box"),
    "score above 1": (set_line(1, score=1.5), LINE.format(1) + ".*a score is a probability"),
    "box negative": (set_line(1, box=[0.5, 0.5, -1, 1]), LINE.format(1) + ".*a box is four"),
    "probabilities few": (set_line(1, probabilities=[1.0]), LINE.format(1) + ".*probabilities are not 8"),
    "seconds negative": (set_line(1, seconds=-1), LINE.format(1) + ".*seconds"),
    "end without reason": (set_line(5, reason=...), LINE.format(5) + ".*missing required field `reason`"),
    "end in the middle": (
        write_line(2, '{"ended":true,"found":false,"reason":"x","seconds":1}'),
        LINE.format(3) + " comes after the end",
    ),
    "no log": (lambda folder: (folder / "steps.jsonl").unlink(), "steps.jsonl cannot be read: No such file"),
    "no picture": (lambda folder: (folder / "picture.png").unlink(), r"there is no file \S*picture.png"),
    "no header": (lambda folder: (folder / "recording.json").unlink(), "is not a recording"),
    "header torn": (lambda folder: (folder / "recording.json").write_text('{"format'), "is not a recording"),
    "other format": (set_header(format="x"), "is not a recording"),
    "newer": (set_header(version=9), "has version 9"),
    "field missing": (set_header(seed=..., place=...), HEADER + ".*missing required field `(place|seed)`"),
    "actions unknown": (set_header(actions=["Fly"]), HEADER + ".*'Fly' - at `..actions"),
    "steps none": (set_header(max_steps=0), HEADER + ".*>= 1 - at `..max_steps`"),
    "steps a text": (set_header(max_steps="20"), HEADER + ".*`int`, got `str` - at `..max_steps`"),
    "minutes NaN": (set_header(max_minutes=float("nan")), HEADER + ".*> 0.0 - at `..max_minutes`"),
    "dry a number": (set_header(dry_run=0), HEADER + ".*`bool`, got `int` - at `..dry_run`"),
    "place a list": (set_header(place=[1]), HEADER + ".*`str`, got `array` - at `..place`"),
    "floor a text": (set_header(floor="x"), HEADER + ".*`object . null`, got `str` - at `..floor`"),
    "floor empty": (set_header(floor={}), HEADER + ".*missing required field `places` - at `..floor`"),
    "places wrong": (
        set_header(floor={"places": [["1", "2"]], "outline": None, "obstacles": []}),
        HEADER + ".*floor.places",
    ),
    "obstacle wrong": (
        set_header(floor={"places": [[1, 2]], "outline": [[0, 0]], "obstacles": [["x", 3]]}),
        HEADER + ".*floor.obstacles",
    ),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damage_is_named(copy, name):
    change, message = DAMAGES[name]
    change(copy)
    with pytest.raises(UserError, match=message):
        read_recording(copy)


def test_halves_of_characters_do_not_reach_a_page(copy):
    set_header(picture="\ud800.png")(copy)
    set_line(5, reason="error: \udfff")(copy)
    read = read_recording(copy)
    assert read.setup.picture == "?.png"
    assert read.record.reason == "error: ?"


def test_what_is_there_is_not_overwritten(copy, scene, tmp_path):
    before = (copy / "steps.jsonl").read_bytes()
    with pytest.raises(OutputExistsError, match="--force"):
        Recorder(copy, setup_in(scene), scene.view(0))
    assert (copy / "steps.jsonl").read_bytes() == before
    with pytest.raises(OutputExistsError, match="is a file"):
        check_folder(copy / "picture.png", force=True)
    check_folder(tmp_path / "new", force=False)
    (tmp_path / "empty").mkdir()
    check_folder(tmp_path / "empty", force=False)


def test_force_removes_what_a_recording_consists_of_and_nothing_else(copy, scene):
    mine = {
        "notes.txt",
        "frames/mine.jpg",
        "frames/1.jpg",
        "frames/00000.txt",
        "report.html",
        "deep/frames/00000.jpg",
    }
    for name in mine:
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        (copy / name).write_text("mine")
    with Recorder(copy, setup_in(scene, seed=99), scene.view(0), force=True) as recorder:
        recorder.keep(step_records_in(scene, 1)[0])
    files = {path.relative_to(copy).as_posix() for path in copy.rglob("*") if path.is_file()}
    assert files == mine | {"recording.json", "picture.png", "steps.jsonl", "frames/00000.jpg"}
    assert all((copy / name).read_text() == "mine" for name in mine)
    read = read_recording(copy)
    assert (read.setup.seed, len(read.record.step_records)) == (99, 1)


@pytest.mark.parametrize("header", [None, "{", "[]", '{"format": "active-perceiver-agent"}'])
def test_force_does_not_touch_a_folder_that_is_no_recording(copy, scene, header):
    (copy / "recording.json").unlink()
    if header is not None:
        (copy / "recording.json").write_text(header)
    before = sorted(copy.rglob("*"))
    with pytest.raises(OutputExistsError, match="holds no recording"):
        Recorder(copy, setup_in(scene), scene.view(0), force=True)
    assert sorted(copy.rglob("*")) == before


def test_frames_behind_a_link_are_left_alone(copy, scene, tmp_path):
    shutil.move(copy / "frames", tmp_path / "elsewhere")
    (copy / "frames").symlink_to(tmp_path / "elsewhere")
    with Recorder(copy, setup_in(scene), scene.view(0), force=True):
        pass
    assert len(list((tmp_path / "elsewhere").iterdir())) == 4
