"""What is made of a search that has ended: a video, a page, pictures and its steps as JSON."""

from __future__ import annotations

import math
from pathlib import Path

from PIL import Image

from active_perceiver.figures.annotate import draw_detection
from active_perceiver.figures.video import write_video
from active_perceiver.live import SearchRecord
from active_perceiver.live.recorder import step_json
from active_perceiver.live.recording import Recording
from active_perceiver.live.recording_header import RecordingHeader
from active_perceiver.live.search_loop import MAX_MINUTES, MAX_STEPS
from active_perceiver.reports import page
from active_perceiver.reports.search_card import path_png, search_card
from active_perceiver.scenes.floor_plan import HasFloorPlan
from active_perceiver.utils.files import OutputExistsError, replacing
from active_perceiver.utils.progress import ProgressCallback, quiet
from active_perceiver.utils.result import format_number, write_result

REPORT_FILES = ("search.mp4", "report.html", "path.png", "final.png", "search.json")


def check_report(out: Path, force: bool) -> None:
    """Make sure that a report may be written into a folder.

    Raises:
        OutputExistsError: if there is one that may not be replaced, or it is no folder.
    """
    if out.exists() and not out.is_dir():
        raise OutputExistsError(f"{out} is a file; a report needs a folder: give another name")
    there = [name for name in REPORT_FILES if (out / name).exists()]
    if there and not force:
        raise OutputExistsError(f"{out / there[0]} exists; give another --out, or --force to replace the report")


def write_report(recording: Recording, out: Path, report: ProgressCallback = quiet) -> list[str]:
    """Write what `REPORT_FILES` names; without poses there is no `path.png`.

    Args:
        recording: a search, read from the disk or just ended.
        out: folder; made if it is not there.
        report: called after every frame of the video.

    Returns:
        The names of the files that were written.
    """
    setup, record = recording.setup, recording.record
    write_search(record, setup.floor, setup.label, out, setup.place, report)
    begun = setup.started[:16].replace("T", " ")
    lead = f"A search in {setup.place}, begun {begun}. {verdict(record).capitalize()}."
    if setup.dry_run:
        lead += " The agent looked and decided; nothing it decided was carried out."
    page.write_page(
        out / "report.html",
        "search_report.html.j2",
        title=f"Search for {setup.label}",
        lead=lead,
        card=search_card(record, setup.label, verdict(record), (out / "search.mp4").read_bytes(), setup.floor),
        steps=_steps_table(record),
        setup=_setup_table(setup, record),
    )
    return [name for name in REPORT_FILES if (out / name).exists()]


def write_search(
    record: SearchRecord,
    room: HasFloorPlan | None,
    label: str,
    out: Path,
    place: str,
    report: ProgressCallback = quiet,
) -> None:
    """Write `search.mp4`, `path.png` (if poses are known), `final.png` and `search.json` into a folder.

    Args:
        record: the search.
        room: for the floor plan; without it the path is shown on plain axes.
        label: name of what was searched.
        out: the folder.
        place: name of the scene or room.
        report: called after every frame of the video.
    """
    write_video(record, out / "search.mp4", room, label, force=True, report=report)
    path = path_png(record, label, room)
    if path is None:
        (out / "path.png").unlink(missing_ok=True)  # of an earlier search
    else:
        with replacing(out / "path.png") as temporary:
            temporary.write_bytes(path)
    last = record.step_records[-1]
    with replacing(out / "final.png") as temporary:
        Image.fromarray(draw_detection(last.image, last.step.detection, label)).save(temporary)
    body = {
        "scene": place,
        "found": record.found,
        "reason": record.reason,
        "dry_run": record.dry_run,
        "actions": record.actions,
        "seconds": record.seconds,
        "steps": [step_json(step_record) for step_record in record.step_records],
    }
    write_result(out / "search.json", "search", body)


def verdict(record: SearchRecord) -> str:
    """One line on how a search ended."""
    spent = f"{record.actions} actions in {record.seconds:.1f} s"
    if record.dry_run:
        looks, times = len(record.step_records), sum(step_record.step.found for step_record in record.step_records)
        early = "" if record.reason in (MAX_STEPS, MAX_MINUTES) else f" ({record.reason})"
        return f"dry run{early}: {looks} looks in {record.seconds:.1f} s, nothing moved; would say found at {times}"
    if record.found:
        return f"found after {spent}"
    if record.reason in (MAX_STEPS, MAX_MINUTES):
        return f"not found: gave up after {spent} ({record.reason})"
    cause, _, detail = record.reason.partition(": ")
    return f"{cause} after {spent}" + (f": {detail}" if detail else "")


def _steps_table(record: SearchRecord) -> page.Table:
    rows, last = [], len(record.step_records) - 1
    for look, step_record in enumerate(record.step_records):
        detection = step_record.step.detection
        rows.append(
            [
                look,
                format_number(None if detection is None else detection.score, ".2f"),
                "-" if detection is None else f"{100 * detection.area:.1f} %",
                record.caption(look) if record.dry_run or look == last else step_record.step.action.value,
                {True: "yes", False: "no", None: "-"}[record.robot_moved(look)],
                f"{step_record.seconds:.1f}",
            ]
        )
    note = (
        "Score: the agent's confidence that it sees what it searches for; area: of its box, as a share of the view; "
        "moved: whether the action changed where the robot is, if the robot says."
    )
    head = ["look", "score", "area", "decided", "moved", "seconds"]
    return page.Table(head, rows, note)


def _setup_table(setup: RecordingHeader, record: SearchRecord) -> page.Table:
    unlimited = math.isinf(setup.max_minutes)
    minutes = "no limit of time" if unlimited else f"{setup.max_minutes:g} minutes"
    rows: list[list[object]] = [
        ["picture", setup.picture],
        ["agent", setup.agent],
        ["robot", setup.robot],
        ["place", f"{setup.place}, from {setup.start}"],
        ["begun", setup.started],
        ["policy branch", setup.scene or "the agent's only one"],
        ["actions", ", ".join(action.value for action in setup.actions)],
        ["limits", f"{setup.max_steps} {'looks' if setup.dry_run else 'actions'}, {minutes}"],
        ["seed", "-" if setup.seed is None else setup.seed],
        ["confirm, explore", f"{'yes' if setup.confirm else 'no'}, {'yes' if setup.explore else 'no'}"],
        ["ended", record.reason],
        ["software", f"active-perceiver {setup.software}"],
    ]
    return page.Table((), rows)
