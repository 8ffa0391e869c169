"""The live view, and searches that are killed or interrupted in the middle."""

import io
import os
import re
import signal
import subprocess
import sys
import time

import pytest
from rich.console import Console

from active_perceiver.cli.interrupts import stopped_like_interrupted
from active_perceiver.cli.main import main
from active_perceiver.cli.search import watching
from active_perceiver.live.recording import read_recording
from active_perceiver.live.terminal_view import LiveView
from helpers.recorded import setup_in, step_records_in

LONG = 300  # seconds after which a child that does nothing is given up


def format_number(setup, step_records) -> str:
    view = LiveView(setup)
    for number, step_record in enumerate(step_records):
        view.looked(number, step_record)
    console = Console(file=io.StringIO(), width=100, force_terminal=False)
    console.print(view.rendered())
    return console.file.getvalue()


def test_the_view_shows_the_last_look_and_those_before(scene):
    step_records = step_records_in(scene, 9)
    last = step_records[-1].step
    text = format_number(setup_in(scene), step_records)
    assert "searching for ball in toy_0" in text
    assert re.search(r"actions .* 8 of 20 ", text)
    assert re.search(r"time .* 0:00 of 5:00 ", text)
    assert re.search(rf"confidence .* {last.detection.score:.2f} ", text)
    assert f"{100 * last.detection.area:.1f} %" in text
    for action, share in zip(setup_in(scene).actions, last.probabilities, strict=True):
        assert re.search(rf"│ {action.value} .* {100 * share:.0f} %", text)
    assert re.findall(r"│ +(\d+) +(?:0\.\d\d|-) ", text) == ["3", "4", "5", "6", "7", "8"]
    assert "no, blocked" in text
    assert text.count("━") > 20


def test_the_view_before_the_first_look_and_without_limits(scene):
    text = format_number(setup_in(scene, max_minutes=float("inf"), dry_run=True, place="[bold]attic[/]"), ())
    assert "waiting for the first look" in text
    assert "[bold]attic[/] (dry run)" in text  # what a user named is no markup
    assert re.search(r"looks +0 of 20", text.replace("━", ""))


def test_a_terminal_is_left_as_it_was_also_by_an_error(scene):
    console = Console(file=io.StringIO(), force_terminal=True, width=100, _environ={"TERM": "xterm"})

    def interrupted_search():
        with watching(setup_in(scene), console) as look:
            look(0, step_records_in(scene, 1)[0])
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted_search()
    text = console.file.getvalue()
    assert text.rindex("\x1b[?25h") > text.rindex("\x1b[?25l")  # the cursor is back
    assert "0 of 20" in text


def begun(wanderer, ball, scene_file, run, **options) -> subprocess.Popen:
    """A search without end, some looks into it."""
    command = [
        sys.executable, "-m", "active_perceiver", "search", str(wanderer), "--picture", str(ball), "--robot",
        f"scene:{scene_file}", "--max-steps", "1000000", "--threads", "1", "--record", str(run),
    ]  # fmt: skip
    child = subprocess.Popen(command, **options)
    until = time.monotonic() + LONG
    log = run / "steps.jsonl"
    while not log.is_file() or log.read_bytes().count(b"\n") < 3:
        assert child.poll() is None, "the search ended by itself"
        assert time.monotonic() < until, "the search has not begun"
        time.sleep(0.02)
    return child


def test_a_killed_search_leaves_a_recording_that_makes_a_report(wanderer, ball, scene_file, tmp_path, capsys):
    child = begun(wanderer, ball, scene_file, tmp_path / "run", stdout=subprocess.DEVNULL)
    child.kill()
    assert child.wait(LONG) == -signal.SIGKILL
    record = read_recording(tmp_path / "run").record
    assert len(record.step_records) >= 3
    assert record.ending == "cut off"
    assert main(["report", str(tmp_path / "run")]) == 0
    assert "cut off after" in capsys.readouterr().out
    assert "the search was killed" in (tmp_path / "run" / "report.html").read_text()


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_what_ends_a_search_is_noted_and_ends_with_130(wanderer, ball, scene_file, tmp_path, how):
    child = begun(
        wanderer, ball, scene_file, tmp_path / "run", stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    child.send_signal(getattr(signal, how))
    out, error = child.communicate(timeout=LONG)
    assert child.returncode == 130
    assert "Traceback" not in error
    assert f"active-perceiver report {tmp_path / 'run'}" in error
    record = read_recording(tmp_path / "run").record
    assert record.reason == "interrupted"
    looks = len(re.findall(r"^ *\d+  sees ", out, re.MULTILINE))
    assert len(record.step_records) - looks in (0, 1)  # kept before it is shown


def test_under_nohup_the_end_of_the_terminal_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stopped_like_interrupted():
            os.kill(os.getpid(), signal.SIGHUP)
            with pytest.raises(KeyboardInterrupt):
                os.kill(os.getpid(), signal.SIGTERM)
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")
def test_ctrl_c_leaves_the_terminal_sound(wanderer, ball, scene_file, tmp_path):
    import pty

    terminal, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100", "LINES": "40"}
    run = tmp_path / "run"
    child = begun(wanderer, ball, scene_file, run, stdout=theirs, stderr=theirs, stdin=theirs, env=environment)
    os.close(theirs)
    child.send_signal(signal.SIGINT)
    text = b""
    while True:  # reading fails once the child has closed its side
        try:
            text += os.read(terminal, 65536) or b""
        except OSError:
            break
    os.close(terminal)
    assert child.wait(LONG) == 130
    view, _, rest = text.decode().rpartition("\x1b[?25h")
    assert "searching for ball in toy_0" in view
    assert "of 1000000" in view
    assert "\x1b[?25l" not in rest  # the cursor is back
    assert "kept in" in rest
    assert "interrupted" in rest
    assert read_recording(run).record.reason == "interrupted"
