"""Reports of searches: from recordings and at once, of every kind of robot and of every end."""

import dataclasses
import json
import re
import shutil

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from active_perceiver.cli.main import main
from active_perceiver.cli.search import watching
from active_perceiver.figures.annotate import draw_detection
from active_perceiver.figures.video import search_frames
from active_perceiver.live.recording import read_recording
from active_perceiver.recognition.recogniser import Detection
from active_perceiver.reports.search_report import verdict
from helpers.recorded import record_of, setup_in

ALL = {"search.mp4", "report.html", "path.png", "final.png", "search.json"}


def frames_of(video) -> int:
    reader = imageio_ffmpeg.read_frames(str(video))
    next(reader)
    return sum(1 for _ in reader)


@pytest.fixture(scope="module")
def searched(wanderer, ball, scene_file, tmp_path_factory):
    """A search that was recorded and reported at once."""
    folder = tmp_path_factory.mktemp("searched")
    arguments = [
        "search", str(wanderer), "--picture", str(ball), "--robot", f"scene:{scene_file}", "--seed", "4",
        "--max-steps", "5", "--record", str(folder / "run"), "--out", str(folder / "out"),
    ]  # fmt: skip
    assert main(arguments) == 1
    return folder, arguments


def test_a_report_of_a_recording_is_the_report_made_at_once(searched, tmp_path, capsys):
    folder, _ = searched
    assert main(["report", str(folder / "run"), "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "not found: gave up after 5 actions" in text
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in (folder / "out").iterdir()} == ALL
    here, there = (json.loads((place / "search.json").read_text()) for place in (tmp_path, folder / "out"))
    assert here["steps"] == there["steps"]
    assert (here["reason"], here["actions"], len(here["steps"])) == ("max steps", 5, 6)
    assert frames_of(tmp_path / "search.mp4") == frames_of(folder / "out" / "search.mp4") == 6 + 8
    np.testing.assert_array_equal(*(np.asarray(Image.open(p / "path.png")) for p in (tmp_path, folder / "out")))


def test_neither_report_nor_recording_is_overwritten_without_force(searched, tmp_path, capsys):
    folder, arguments = searched
    copy = shutil.copytree(folder, tmp_path / "copy")
    here = [text.replace(str(folder), str(copy)) for text in arguments]
    before = {path: path.read_bytes() for path in copy.rglob("*") if path.is_file()}
    assert main(here) == 2
    assert "run is not empty" in capsys.readouterr().err.replace("\n", " ")
    assert main([*here[:-4], "--out", str(copy / "out")]) == 2
    assert main(["report", str(copy / "run"), "--out", str(copy / "out")]) == 2
    assert "--force to replace the report" in capsys.readouterr().err.replace("\n", " ")
    assert {path: path.read_bytes() for path in copy.rglob("*") if path.is_file()} == before
    (copy / "run" / "final.png").write_bytes(b"mine")
    assert main(["report", str(copy / "run")]) == 2
    assert (copy / "run" / "final.png").read_bytes() == b"mine"
    assert main(["report", str(copy / "run"), "--force"]) == 0
    assert {path.name for path in (copy / "run").iterdir()} > ALL
    assert Image.open(copy / "run" / "final.png").size == (600, 600)


def test_the_page_has_all_in_it_and_needs_no_network(searched):
    folder, _ = searched
    text = (folder / "out" / "report.html").read_text()
    assert re.findall(r'(?:src|href)="(?!data:)', text) == []
    assert text.count("data:video/mp4;base64,") == 1
    assert text.count("<img") == 3 + 6  # the picture, the last view, the path and each look
    assert len(re.findall(r"<tr><td>\d+</td>", text)) == 6
    for words in ("Search for ball", "in toy_0", "max steps", f"scene:{folder.parent}"[:8], "not found"):
        assert words in text


@pytest.mark.parametrize("known", ["poses", "nothing"])
def test_without_a_scene_the_path_lies_on_plain_axes_and_without_poses_there_is_none(scene, tmp_path, known):
    record_of(scene, tmp_path / "run", floor=None)
    if known == "nothing":
        log = tmp_path / "run" / "steps.jsonl"
        log.write_text(re.sub(r'"pose":(\[.*?\]|null)', '"pose":null', log.read_text()))
    assert main(["report", str(tmp_path / "run"), "--out", str(tmp_path / "out")]) == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == ALL - (
        {"path.png"} if known == "nothing" else set()
    )
    frames = list(search_frames(read_recording(tmp_path / "run").record, None, "ball"))
    assert len(frames) == 4
    assert (frames[-1][200:, 660:].std() > 5) == (known == "poses")


def test_a_path_grows_as_if_the_plan_were_drawn_anew(scene, tmp_path):
    """The plan of a video is drawn once; each frame is what it is in a video that ends there."""
    record = record_of(scene, tmp_path / "run")
    whole = list(search_frames(record, scene, "ball"))
    for count in range(1, 5):
        *_, last = search_frames(dataclasses.replace(record, step_records=record.step_records[:count]), scene, "ball")
        np.testing.assert_array_equal(whole[count - 1][160:, 640:], last[160:, 640:])


def test_a_box_lies_right_on_a_view_that_is_not_square():
    view = np.full((30, 40, 3), 120, np.uint8)
    drawn = draw_detection(view, Detection(0.9, np.array([0.5, 0.5, 0.5, 0.5])), "a name much too long " * 9, 400)
    red = (np.abs(drawn.astype(int) - (255, 77, 46)) < 12).all(-1)
    rows = np.flatnonzero(red[:, 110:290].mean(1) > 0.9)
    assert abs(rows[-1] - 300) <= 3
    assert (drawn[25, :100] > 200).all()  # above the view
    assert (drawn[60, 5] == 120).all()


def test_verdicts_say_how_it_ended(scene, tmp_path):
    record = record_of(scene, tmp_path)
    cases = {
        "found after 3 actions in 2.5 s": {"found": True, "reason": "found"},
        "not found: gave up after 3 actions in 2.5 s (max minutes)": {"reason": "max minutes"},
        "interrupted after 3 actions in 2.5 s": {"reason": "interrupted"},
        "error after 3 actions in 2.5 s: it is: gone": {"reason": "error: it is: gone"},
        "dry run: 4 looks in 2.5 s, nothing moved; would say found at 0": {"dry_run": True},
        "dry run (interrupted): 4 looks in 2.5 s, nothing moved; would say found at 0": {
            "dry_run": True,
            "reason": "interrupted",
        },
    }
    for words, changes in cases.items():
        assert verdict(dataclasses.replace(record, **changes)) == words


def test_a_dry_run_shows_and_records_what_it_would_do(wanderer, ball, scene_file, tmp_path, capsys):
    arguments = [
        "search", str(wanderer), "--picture", str(ball), "--robot", f"scene:{scene_file}", "--start", "3",
        "--max-steps", "2", "--dry-run", "--record", str(tmp_path / "run"),
    ]  # fmt: skip
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert len(re.findall(r" would \w+\n", text)) == 2
    assert "nothing moved" in text
    read = read_recording(tmp_path / "run")
    assert read.setup.dry_run
    assert read.record.dry_run
    assert len({step_record.pose for step_record in read.record.step_records}) == 1
    assert main(["report", str(tmp_path / "run")]) == 0
    assert "nothing it decided was carried out" in (tmp_path / "run" / "report.html").read_text()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--max-steps", "0"], "at least 1 action"),
        (["--max-minutes", "0"], "more than 0"),
        (["--max-minutes", "nan"], "more than 0"),
        (["--record", "FILE"], "is a file"),
        (["--out", "FILE"], "is a file"),
    ],
    ids=str,
)
def test_what_no_search_can_do_is_refused(wanderer, ball, scene_file, options, message, capsys):
    options = [str(ball) if option == "FILE" else option for option in options]
    arguments = ["search", str(wanderer), "--picture", str(ball), "--robot", f"scene:{scene_file}", *options]
    assert main(arguments) == 2
    assert message in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.parametrize("what", ["nothing", "a folder", "a search without a look"])
def test_reports_of_what_is_no_recording_are_refused(scene, tmp_path, what, capsys):
    if what == "a folder":
        (tmp_path / "run").mkdir()
    elif what == "a search without a look":
        record_of(scene, tmp_path / "run")
        (tmp_path / "run" / "steps.jsonl").write_text("")
    assert main(["report", str(tmp_path / "run")]) == 2
    error = capsys.readouterr().err.replace("\n", " ")
    assert ("holds no look" if "look" in what else "is not a recording") in error


def test_lines_where_there_is_no_terminal(scene, tmp_path, capsys):
    record, setup = record_of(scene, tmp_path), setup_in(scene)
    with watching(setup) as look:
        for number, step_record in enumerate(record.step_records):
            look(number, step_record)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert re.fullmatch(r"   0  sees 0\.\d\d, [\d.]+ % of the view +MoveAhead", lines[0])
    assert re.fullmatch(r"   1  sees - +MoveBack", lines[1])
