"""Freeze what the commands do, to see whether a restructuring changed anything.

    python tests/golden/record.py --out /tmp/before               # before it
    python tests/golden/record.py --check /tmp/before             # after it; exit code 1 and a diff if they differ
    python tests/golden/record.py --check /tmp/before --only help rooms

Short trainings, evaluations, searches and renderings run through `python -m active_perceiver` with fixed seeds; what
they wrote goes into the folder as text, without dates, durations, versions and paths. Both runs must be made on the
same machine with the same packages: floating point numbers differ between processors. All takes some three minutes.

The texts of `--help` do not depend on the machine; `expected/help.txt` has them, and `test_help.py` compares. After a
change of an option, renew them and look at the diff:

    python tests/golden/record.py --only help --out tests/golden/expected --force
"""

from __future__ import annotations

import argparse
import difflib
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from commands import all_helps, run
from facts import agent_facts, digest, hdf5_facts, json_facts, log_facts, page_text
from PIL import Image

HERE = Path(__file__).parent
SHOWN = 200
"""Lines of a diff that are printed."""

TOY = ("--scenes", "toy_0.h5", "--image-size", "96")
KITCHEN = ("--scenes", "kitchen_1", "--targets", "record", "--image-size", "64")


def helps(work: Path) -> dict[str, str]:
    """Every help."""
    return {"help.txt": "\n".join(f"===== {name}\n{text}" for name, text in all_helps().items())}


def toy(work: Path) -> dict[str, Any]:
    """The toy scene: a training, its evaluations, a recorded search and the report of it."""
    _toy_scene(work)
    augmentation = ("--view-augmentation", "1", "--viewpoint-jitter-degrees", "10")
    run(work, "train", *TOY, "--recogniser-steps", "120", *augmentation, "--out", "toy")
    made = {
        "toy_agent.json": agent_facts(work / "toy", work),
        "toy_evaluate.json": _evaluated(work, "toy", "--searches", "30", "--confirm"),
        "toy_episodes.json": _evaluated(work, "toy", "--protocol", "paper", "--searches", "5"),
    }
    # Two searches: one that may find, one to the end and explored.
    for seed, options in ((4, ()), (5, ("--confirm",))):
        name = f"toy_search_{seed}"
        picture = "toy/targets/toy_0/ball1/01.png"
        made |= _searched(work, name, "toy", picture, "scene:toy_0.h5", "--seed", str(seed), *options)
    return made


def view(work: Path) -> dict[str, Any]:
    """An agent that searches for views, by PPO."""
    _toy_scene(work)
    run(work, "train", "--task", "view", *TOY, "--learner", "ppo", "--out", "view")
    return {"view_agent.json": agent_facts(work / "view", work)}


def kitchen(work: Path) -> dict[str, Any]:
    """The bundled kitchen: a training, an evaluation, a search on recorded views and one on the simulated robot."""
    run(work, "train", *KITCHEN, "--recogniser-steps", "20", "--view-augmentation", "0", "--learner", "distil",
        "--out", "kitchen")  # fmt: skip
    made = {
        "kitchen_agent.json": agent_facts(work / "kitchen", work),
        "kitchen_evaluate.json": _evaluated(work, "kitchen", "--searches", "10"),
    }
    picture = "kitchen/targets/kitchen_1/mug/00.webp"
    for name in ("scene", "room"):
        place = f"{name}:kitchen_1"
        made |= _searched(
            work, f"kitchen_search_{name}", "kitchen", picture, place, "--seed", "3", "--max-steps", "15"
        )
    return made


def rooms(work: Path) -> dict[str, Any]:
    """A room of each layout from one place, and whether each is sound."""
    run(work, "scenes", "preview", "--count", "1", "--views", "1", "--image-size", "64", "--picture", "rooms.png",
        "--out", "rooms.json")  # fmt: skip
    pixels = Image.open(work / "rooms.png").convert("RGB")
    return {
        "rooms.json": {
            "pixels": [digest(pixels.tobytes()), pixels.size],
            "result": json_facts(work / "rooms.json", work),
        }
    }


def rendering(work: Path) -> dict[str, Any]:
    """A rendered scene: views, boxes, pictures of targets."""
    run(work, "scenes", "render", "kitchen", "--places", "2", "--image-size", "64", "--out", "kitchen_1.h5")
    return {"rendered_scene.json": hdf5_facts(work / "kitchen_1.h5")}


SECTIONS: dict[str, Callable[[Path], dict[str, Any]]] = {
    "help": helps,
    "toy": toy,
    "view": view,
    "kitchen": kitchen,
    "rooms": rooms,
    "rendering": rendering,
}
"""What can be recorded: name -> given a folder to work in, file name -> text, or plain data to write as JSON."""


def _toy_scene(work: Path) -> None:
    if not (work / "toy_0.h5").exists():
        subprocess.run([sys.executable, HERE / "toy_file.py", work / "toy_0.h5"], check=True)


def _evaluated(work: Path, agent: str, *options: str) -> Any:
    run(work, "evaluate", agent, "--out", "evaluated.json", "--force", *options)
    return json_facts(work / "evaluated.json", work)


def _searched(work: Path, name: str, agent: str, picture: str, robot: str, *options: str) -> dict[str, Any]:
    """A recorded search, and its report."""
    folder = work / name
    run(work, "search", agent, "--picture", picture, "--robot", robot, "--threads", "1", "--record", name, *options,
        allowed=(0, 1))  # fmt: skip
    made = {
        f"{name}.json": {
            "recording": json_facts(folder / "recording.json", work),
            "steps": log_facts(folder / "steps.jsonl", work),
            "frames": {path.name: digest(path.read_bytes()) for path in sorted((folder / "frames").iterdir())},
        }
    }
    _with_even_times(folder)
    run(work, "report", name)
    made[f"{name}_report.html"] = page_text(folder / "report.html", work)
    made[f"{name}_report.json"] = {
        "search.json": json_facts(folder / "search.json", work),
        "video": (folder / "search.mp4").stat().st_size > 0,
        **{name: digest(Image.open(folder / name).tobytes()) for name in ("path.png", "final.png")},
    }
    return made


def _with_even_times(recording: Path) -> None:
    """Let a search have taken half a second for each look, and have begun at a fixed time, for its report says so."""
    header = json.loads((recording / "recording.json").read_text()) | {"started": "2026-01-02T03:04:05+00:00"}
    (recording / "recording.json").write_text(json.dumps(header))
    lines = [json.loads(line) for line in (recording / "steps.jsonl").read_text().splitlines()]
    even = [json.dumps(line | {"seconds": 0.5 * look}) for look, line in enumerate(lines)]
    (recording / "steps.jsonl").write_text("".join(f"{line}\n" for line in even))


def record(out: Path, names: list[str]) -> None:
    """Run some sections, and write what they gave into a folder."""
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        for name in names:
            print(f"recording: {name}", file=sys.stderr)
            for file, content in SECTIONS[name](Path(work).resolve()).items():
                text = content if isinstance(content, str) else json.dumps(content, indent=1, sort_keys=True) + "\n"
                (out / file).write_text(text)


def differences(before: Path, after: Path, complete: bool) -> list[str]:
    """Lines of a diff of what was recorded; none if both are the same.

    Args:
        before: a folder that `record` made.
        after: another.
        complete: whether `after` has all sections; what it lacks is a difference then.
    """
    files = {path.name for path in after.iterdir()}
    if complete:
        files |= {path.name for path in before.iterdir()}
    lines: list[str] = []
    for name in sorted(files):
        old, new = (
            (folder / name).read_text().splitlines() if (folder / name).exists() else [] for folder in (before, after)
        )
        lines += difflib.unified_diff(old, new, f"before/{name}", f"after/{name}", lineterm="", n=2)
    return lines


def main() -> int:
    """Record, or compare with what was recorded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--out", type=Path, help="folder to write")
    what.add_argument("--check", type=Path, help="folder to compare with")
    parser.add_argument(
        "--only", nargs="+", choices=SECTIONS, default=list(SECTIONS), help="sections; all if not given"
    )
    parser.add_argument("--force", action="store_true", help="write into a folder that is not empty")
    given = parser.parse_args()
    if given.out is not None:
        if not given.force and given.out.exists() and any(given.out.iterdir()):
            parser.error(f"{given.out} is not empty; --force replaces what is there")
        record(given.out, given.only)
        return 0
    if not given.check.is_dir():
        parser.error(f"{given.check} is no folder; make it with --out")
    with tempfile.TemporaryDirectory() as after:
        record(Path(after), given.only)
        lines = differences(given.check, Path(after), complete=set(given.only) == set(SECTIONS))
    print("\n".join(line[:300] for line in lines[:SHOWN]) if lines else "no differences")
    if len(lines) > SHOWN:
        print(f"... and {len(lines) - SHOWN} more lines")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
