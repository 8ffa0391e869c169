"""README and docs can be followed: code runs, commands parse, links lead somewhere."""

from __future__ import annotations

import ast
import re
import shlex
import shutil
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
import tyro

from active_perceiver.cli import main as cli
from active_perceiver.robots.ros.config_file import load_config
from active_perceiver.scenes import open_scene, save_scene
from helpers.toy import toy_scene

ROOT = Path(__file__).parents[1]
PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text()
    for path in [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
}


def fenced(page: str, language: str) -> list[str]:
    """The code blocks of a page in a language, "" for those that name none."""
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGES[page], re.DOTALL | re.MULTILINE)


CODE = [(page, number) for page in PAGES for number in range(len(fenced(page, "python")))]


# Code. What a block needs beside it is put into an empty folder.


def for_the_readme(agent: Path) -> None:
    shutil.copytree(agent, "demo/agent")
    Path("mug.jpg").write_bytes(open_scene("kitchen_1").targets[0].pictures[0])


def for_a_robot(agent: Path) -> None:
    scene = toy_scene()
    shutil.copytree(agent, "agent")
    Path("mug.jpg").write_bytes(scene.targets[1].pictures[0])
    # Another object, at which the search does not end.
    Path("frame.jpg").write_bytes(scene.targets[0].pictures[0])


def for_gymnasium(_: Path) -> None:
    save_scene(toy_scene(side=3), Path("my_room.h5"))


NEEDS: dict[str, Callable[[Path], None]] = {
    "README.md": for_the_readme,
    "docs/robot.md": for_a_robot,
    "docs/gymnasium.md": for_gymnasium,
}
CANNOT_RUN = {"docs/ai2thor.md"}  # it needs the simulator


@pytest.mark.parametrize(("page", "number"), [one for one in CODE if one[0] not in CANNOT_RUN])
def test_code_runs(page, number, agent_folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("builtins.input", lambda text: "")
    NEEDS[page](agent_folder)
    # The toy agent has eight actions.
    code = fenced(page, "python")[number].replace("TURTLEBOT_ACTIONS", "EIGHT_ACTIONS")
    exec(compile(code, f"{page}, block {number}", "exec"), {"__name__": "page"})
    assert capsys.readouterr().out or "print(" not in code


@pytest.mark.parametrize(("page", "number"), CODE)
def test_code_imports_what_exists(page, number):
    for node in ast.walk(ast.parse(fenced(page, "python")[number])):
        if isinstance(node, ast.ImportFrom):
            assert all(hasattr(import_module(node.module), alias.name) for alias in node.names)


@pytest.mark.parametrize(("answer", "moved"), [("", True), ("blocked", False)])
def test_the_robot_of_its_page_says_whether_it_moved(answer, moved, agent_folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    asked = []
    monkeypatch.setattr("builtins.input", lambda text: asked.append(text) or answer)
    for_a_robot(agent_folder)
    (code,) = fenced("docs/robot.md", "python")
    page: dict[str, Any] = {"__name__": "page"}
    exec(code.replace("TURTLEBOT_ACTIONS", "EIGHT_ACTIONS"), page)
    record = page["record"]
    assert len(asked) == record.actions > 0
    assert all(step_record.robot_moved is moved for step_record in record.step_records[1:])
    assert capsys.readouterr().out.count("stand still") == 2  # the search's end, and the robot's


def test_the_settings_of_a_robot_can_be_read(tmp_path):
    (text,) = fenced("docs/robot.md", "yaml")
    (tmp_path / "robot.yaml").write_text(text)
    settings = load_config(tmp_path / "robot.yaml")
    assert settings.tilts == (-25.0, 0.0)
    assert settings.limits.speed == 0.1


# Commands.


def commands_in(text: str) -> list[list[str]]:
    """Arguments of all commands in a page's code, without comments and what follows in a shell."""
    found = re.findall(r"^ *(?:\.venv/bin/|taskset -c 0 \.venv/bin/)?active-perceiver (.+)$", code_in(text), re.M)
    return [shlex.split(re.split("&&|;", line)[0], comments=True) for line in found]


def code_in(text: str) -> str:
    """The code of a page, fenced or indented; lines that go on after a backslash are one."""
    inside, found = False, []
    for line in text.splitlines(keepends=True):
        if line.lstrip().startswith("```"):
            inside = not inside
        elif inside or line.startswith("    "):
            found.append(line)
    return "".join(found).replace("\\\n", " ")


class Parsed:
    def run(self) -> int:
        return 0


@pytest.fixture
def parses(monkeypatch) -> Callable[[list[str]], bool]:
    """Whether a command is one; it is not run."""
    parse = tyro.cli

    def only_parse(*arguments: Any, **options: Any) -> Parsed:
        parse(*arguments, **options)
        return Parsed()

    monkeypatch.setattr(cli.tyro, "cli", only_parse)

    def parses(command: list[str]) -> bool:
        try:
            return cli.main(command) == 0
        except SystemExit:
            return False

    return parses


COMMANDS = {page: commands_in(text) for page, text in PAGES.items() if commands_in(text)}


@pytest.mark.parametrize("page", COMMANDS)
def test_commands_parse(page, parses):
    refused = [shlex.join(command) for command in COMMANDS[page] if not parses(command)]
    assert not refused


def test_commands_are_found_and_wrong_ones_refused(parses):
    code = "active-perceiver info  # why\n.venv/bin/active-perceiver train \\\n  --out a && b\n"
    assert commands_in(f"active-perceiver prose\n```\n{code}```\n") == [["info"], ["train", "--out", "a"]]
    assert commands_in("    active-perceiver scenes list; ls\n") == [["scenes", "list"]]
    assert len(COMMANDS) >= 15
    assert parses(["info"])
    assert not parses(["train", "--ou", "a"])
    assert not parses(["prose"])


# Links.


def broken_links(folder: Path, text: str) -> list[str]:
    """What a page in a folder points to and is not there: files, and headings of Markdown files."""
    broken = []
    for link in re.findall(r"\]\(([^)]+)\)", text) + re.findall(r'src="([^"]+)"', text):
        path, _, heading = link.partition("#")
        if link.startswith(("http:", "https:", "data:")):
            continue
        target = folder / path
        if not target.exists() or (heading and heading not in anchors(target.read_text() if path else text)):
            broken.append(link)
    return broken


def anchors(text: str) -> set[str]:
    """What GitHub calls the headings of a page."""
    heads = re.findall(r"^#+ (.+)$", re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_to_what_exists(page):
    assert broken_links((ROOT / page).parent, PAGES[page]) == []


def test_broken_links_are_seen(tmp_path):
    (tmp_path / "a.md").write_text("# It's 1. here\n")
    assert broken_links(tmp_path, "[x](a.md) [x](a.md#its-1-here) [x](https://x.y/z) [x](#b)\n## b\n") == []
    assert broken_links(tmp_path, "[x](b.md) [x](a.md#there) [x](#c)") == ["b.md", "a.md#there", "#c"]


OF_OTHERS = {"datasets/offline_controller_with_small_rotation.py"}  # SAVN's


@pytest.mark.parametrize("page", PAGES)
def test_modules_that_are_named_exist(page):
    for name in re.findall(r"`([a-z_0-9]+/[a-z_0-9/]+\.py)\b", PAGES[page]):
        homes = (ROOT, ROOT / "src" / "active_perceiver", ROOT / "indoor_rooms" / "src" / "indoor_rooms")
        assert name in OF_OTHERS or any((home / name).is_file() for home in homes), name


def test_every_page_can_be_reached_from_the_readme():
    todo, seen = ["README.md"], set()
    while todo:
        page = todo.pop()
        seen.add(page)
        links = re.findall(r"\]\(([^)#:]+\.md)", PAGES[page])
        linked = {((ROOT / page).parent / link).resolve().relative_to(ROOT).as_posix() for link in links}
        todo += (linked & PAGES.keys()) - seen
    assert seen == PAGES.keys()


# The map: architecture and words.


def paragraphs(text: str) -> list[str]:
    """What the paragraphs of a page that begin in bold are about."""
    return re.findall(r"^\*\*(\w+)\*\* ", text, re.MULTILINE)


def test_every_folder_has_its_paragraph():
    package = ROOT / "src" / "active_perceiver"
    folders = {path.parent.name for path in package.glob("*/__init__.py")} | {"errors"}
    assert sorted(paragraphs(PAGES["docs/architecture.md"])) == sorted(folders)
    assert paragraphs("**a** is.\n**b**: is\nnot **c** either.\n") == ["a"]


def words_in_code(text: str) -> list[str]:
    """The names in the last column of a page's tables."""
    rows = [line.strip("| ").split("|") for line in text.splitlines() if line.startswith("| ")]
    return [name for row in rows for name in re.findall(r"`(\w+)`", row[-1])]


def test_words_of_the_glossary_are_in_the_code():
    code = "\n".join(path.read_text() for path in (ROOT / "src").rglob("*.py"))
    names = set(re.findall(r"\w+", code))
    words = words_in_code(PAGES["docs/glossary.md"])
    assert len(words) > 50
    assert [word for word in words if word not in names] == []
    assert words_in_code("| `a` | `b` is | `C`, `d_e` |\n`f`\n") == ["C", "d_e"]
