"""docs/your-own-room.md can be followed: its commands, one after the other, on a small room."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest

from active_perceiver.capture.rendered import photographs
from active_perceiver.cli.main import main
from active_perceiver.parallel.executor import SerialExecutor
from active_perceiver.parallel.process_pool import ProcessExecutor
from active_perceiver.scenes import load_scene
from box_room import box_room
from indoor_rooms.renderer import compiled

PAGE = Path(__file__).parents[2] / "docs" / "your-own-room.md"
# What makes it small. The room of the test holds a box and little else.
SMALL = {
    "--places 27": "--places 6 --width 120",
    "--targets mug bag scissors stapler": "--targets TARGETS",
    "train --scenes": "train --recogniser-steps 60 --image-size 96 --scenes",
    "targets/mug/": "targets/TARGET/",
    "evaluate agent": "evaluate agent --searches 4",
}


def commands() -> list[list[str]]:
    """Every command in the page's fenced blocks, with what makes it small."""
    targets = list(box_room().targets)
    found = []
    for block in re.findall(r"^```\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL):
        for line in block.splitlines():
            assert line.startswith("active-perceiver "), f"no command: {line}"
            for long, short in SMALL.items():
                line = line.replace(long, short)
            line = line.replace("TARGETS", " ".join(targets)).replace("TARGET", targets[0])
            found.append(shlex.split(line)[1:])
    return found


def test_the_page_has_commands_for_all_that_it_promises() -> None:
    text = PAGE.read_text()
    for long in SMALL:
        assert long in text, f"the test makes '{long}' small, which is not in the page any more"
    first = [" ".join(command[:2]) for command in commands()]
    assert first == [
        "scenes capture", "scenes import", "scenes check", "scenes info", "train --recogniser-steps",
        "evaluate agent", "search agent", "scenes import", "scenes label",
    ]  # fmt: skip


@pytest.mark.xdist_group("tutorial")
def test_the_commands_lead_to_an_agent_that_finds_its_targets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(compiled, "MAX_TRIANGLES", 2000)
    monkeypatch.setattr(ProcessExecutor, "map", lambda _, *work: SerialExecutor().map(*work))
    monkeypatch.setattr(photographs, "make_room", lambda layout, seed: box_room())
    for command in commands():
        if "second_photos" in command:  # the reader's second room is the first one, not labelled
            shutil.copytree("photos", "second_photos", ignore=shutil.ignore_patterns("annotations.json"))
        code = main(command)
        # After so little training a search may find nothing; a scene without boxes cannot be searched.
        may_fail = command[0] == "search" or "second_photos" in command
        assert code == 0 or (may_fail and code == 1), capsys.readouterr().err
    scene, result = load_scene(Path("room.h5")), json.loads(Path("own_room.json").read_text())
    assert len({tuple(pose[:2]) for pose in scene.poses.tolist()}) == 6
    assert len(scene) == 48
    assert result["overall"]["success"] == pytest.approx(1.0)
    for name in ("room.jpg", "agent/config.json", "search/path.png", "search/search.mp4", "second_room.h5"):
        assert Path(name).is_file(), name
