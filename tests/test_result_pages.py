"""docs/benchmarks/*.md: a page says what it must, the committed result is on it, and its commands can be typed."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

import pytest
import tyro

from active_perceiver import cli
from active_perceiver.cli_benchmarks import BenchmarkCommand

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "docs" / "benchmarks").glob("*.md"))
PROGRAMS = ROOT / "src" / "active_perceiver" / "experiments" / "benchmarks"
SECTIONS = ["Usage", "Metrics", "Implementation details", "Results"]
NO_RESULT = "No quiet run is committed yet; the command above makes one."

FORMATS = {
    "act": "format_act_speed",
    "env": "format_env_speed",
    "export": "format_exported",
    "policies": "format_policies",
    "recogniser": "format_recogniser_ablation",
    "robot": "format_robot",
    "robustness": "format_robustness",
    "scale": "format_scale",
    "train": "format_train_speed",
}
"""What prints the table of each benchmark, somewhere in `experiments/benchmarks`."""
WITHOUT_PAGE = {"render"}


def format_of(name: str) -> Callable[[dict[str, Any]], str]:
    """The function that prints a benchmark's table."""
    (module,) = (path.stem for path in PROGRAMS.glob("*.py") if f"\ndef {FORMATS[name]}(" in path.read_text())
    return getattr(import_module(f"active_perceiver.experiments.benchmarks.{module}"), FORMATS[name])


def sections_of(text: str) -> dict[str, str]:
    """What stands under each heading of the second level; what looks like one in a code block is none."""
    outside = re.sub(r"^```.*?^```", lambda block: block[0].replace("#", "."), text, flags=re.DOTALL | re.MULTILINE)
    heads = [*re.finditer(r"^## (.+)$", outside, re.MULTILINE)]
    ends = [head.start() for head in heads[1:]] + [len(text)]
    return {head[1]: text[head.end() : end].strip() for head, end in zip(heads, ends, strict=True)}


def faults(name: str, text: str, table: str | None, pictures: Path) -> list[str]:
    """What is wrong with a benchmark's page.

    Args:
        name: of the benchmark.
        text: of the page.
        table: what the benchmark printed of the committed result; None if none is committed.
        pictures: the folder of pictures.
    """
    sections = sections_of(text)
    found = []
    if list(sections) != SECTIONS:
        found.append(f"its sections are {', '.join(sections)}")
    found += [f"{title} is empty" for title, content in sections.items() if not content]
    if f"active-perceiver benchmark {name}" not in sections.get("Usage", ""):
        found.append("Usage does not say how to run it")
    results = sections.get("Results", "")
    picture = f"benchmark_{name}.png"
    shown = re.findall(r"!\[[^\]]+\]\(\.\./pictures/([^)]+)\)", results)
    blocks = re.findall(r"^```\n(.*?)\n```$", results, re.DOTALL | re.MULTILINE)
    says_none = NO_RESULT in results.splitlines()
    if table is None:
        if not says_none or blocks or shown:
            found.append("there is no result, and it does not say so, or shows one")
    else:
        if says_none:
            found.append("there is a result, and it says there is none")
        if blocks != [table]:
            found.append("it does not show the table of the result")
        if shown != [picture] or not (pictures / picture).is_file():
            found.append(f"it does not show {picture}, or there is none")
    return found


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_the_page_shows_the_committed_result_or_says_there_is_none(path: Path) -> None:
    committed, table = ROOT / "benchmarks" / f"{path.stem}.json", None
    if committed.exists():
        result = json.loads(committed.read_text())
        assert result["command"].startswith(f"benchmark {path.stem}")
        table = format_of(path.stem)(result)
    assert faults(path.stem, path.read_text(), table, ROOT / "docs" / "pictures") == []


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_the_page_points_to_what_exists(path: Path) -> None:
    for link in re.findall(r"\]\(([^)#]+)[^)]*\)", path.read_text()):
        if not link.startswith(("http:", "https:")):
            assert (path.parent / link).exists(), f"{path.name} points to {link}"


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_the_page_names_existing_modules(path: Path) -> None:
    for name in re.findall(r"`([a-z_0-9]+/[a-z_0-9/]+\.py)\b", path.read_text()):
        assert (ROOT / "src" / "active_perceiver" / name).is_file(), f"{path.name} names {name}"


@pytest.mark.parametrize("name", [path.stem for path in PAGES])
def test_the_table_is_printed_by_one_function(name: str) -> None:
    assert callable(format_of(name))


def test_every_benchmark_has_a_page_and_is_named_in_the_readme() -> None:
    readme = (ROOT / "README.md").read_text()
    (row,) = (line for line in readme.splitlines() if line.startswith("| `benchmark "))
    commands = {get_args(kind)[1].name for kind in get_args(BenchmarkCommand)}
    pages = {path.stem for path in PAGES}
    assert commands - WITHOUT_PAGE <= pages
    for name in commands:
        assert re.search(rf"`(benchmark )?{name}`", row), f"the README does not name `benchmark {name}`"
    for name in pages:
        assert f"(docs/benchmarks/{name}.md)" in readme, f"the README does not point to docs/benchmarks/{name}.md"


def commands_in(path: Path) -> list[list[str]]:
    """Arguments of all commands in a page's code blocks, without comments and what follows in a shell."""
    blocks = re.findall(r"^ *```\w*\n(.*?)^ *```$", path.read_text(), re.DOTALL | re.MULTILINE)
    lines = "".join(blocks).replace("\\\n", " ").splitlines()
    found = [re.match(r"\s*(?:\.venv/bin/)?active-perceiver (.+)", line) for line in lines]
    return [shlex.split(re.split("&&|;", line[1])[0], comments=True) for line in found if line]


@pytest.mark.parametrize(
    "page",
    [
        "README.md",
        "CONTRIBUTING.md",
        "docs/robot.md",
        "docs/scenes.md",
        "docs/exporting.md",
        *(f"docs/benchmarks/{path.name}" for path in PAGES),
    ],
)
def test_every_command_in_it_can_be_typed(page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    parse = tyro.cli
    parsed = []

    class Parsed:
        def run(self) -> int:
            return 0

    def only_parse(*arguments: Any, **options: Any) -> Parsed:
        parsed.append(parse(*arguments, **options))
        return Parsed()

    monkeypatch.setattr(cli.tyro, "cli", only_parse)
    commands = commands_in(ROOT / page)
    assert commands, f"{page} shows no command"
    for command in commands:
        try:
            cli.main(command)
        except SystemExit:
            pytest.fail(f"{page}: active-perceiver {shlex.join(command)} is refused")
    assert len(parsed) == len(commands)


# A page is refused for what is wrong with it, and only for that.

GOOD = """# `benchmark env`: steps

## Usage

```
active-perceiver benchmark env   # comment
# another
## no heading
```

## Metrics

Steps.

## Implementation details

One process.

## Results

{results}

And so on.
"""
PICTURE = "![Steps](../pictures/benchmark_env.png)"


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    (tmp_path / "benchmark_env.png").write_bytes(b"\x89PNG")
    return tmp_path


def with_results(results: str) -> str:
    return GOOD.replace("{results}", results)


def test_a_page_with_its_table_and_one_without_a_result_are_right(pictures: Path) -> None:
    assert faults("env", with_results(f"```\n a  b\n1\n```\n\n{PICTURE}"), " a  b\n1", pictures) == []
    assert faults("env", with_results(NO_RESULT), None, pictures) == []


@pytest.mark.parametrize(
    ("results", "table", "fault"),
    [
        (f"```\n a  b\n2\n```\n\n{PICTURE}", " a  b\n1", "it does not show the table"),
        (f"```\na  b\n1\n```\n\n{PICTURE}", " a  b\n1", "it does not show the table"),
        (f"```\n1\n```\n\n```\n1\n```\n\n{PICTURE}", "1", "it does not show the table"),
        ("```\n1\n```", "1", "it does not show benchmark_env.png"),
        ("```\n1\n```\n\n![Steps](../pictures/other.png)", "1", "it does not show benchmark_env.png"),
        (f"{NO_RESULT}\n\n```\n1\n```\n\n{PICTURE}", "1", "there is a result, and it says there is none"),
        ("RESULTS", None, "there is no result, and it does not say so"),
        ("```\n1\n```", None, "there is no result, and it does not say so, or shows one"),
        (f"{NO_RESULT}\n\n{PICTURE}", None, "there is no result, and it does not say so, or shows one"),
    ],
)
def test_a_page_with_other_results_is_refused(results: str, table: str | None, fault: str, pictures: Path) -> None:
    found = faults("env", with_results(results), table, pictures)
    assert len(found) == 1
    assert fault in found[0]


def test_a_page_whose_picture_is_missing_is_refused(tmp_path: Path) -> None:
    (fault,) = faults("env", with_results(f"```\n1\n```\n\n{PICTURE}"), "1", tmp_path)
    assert "benchmark_env.png" in fault


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("## Metrics\n\nSteps.\n\n", "", "its sections are Usage, Implementation details, Results"),
        ("Steps.", "", "Metrics is empty"),
        ("benchmark env ", "benchmark act ", "Usage does not say how to run it"),
    ],
)
def test_a_page_without_a_section_is_refused(old: str, new: str, fault: str, pictures: Path) -> None:
    assert faults("env", with_results(NO_RESULT).replace(old, new), None, pictures) == [fault]
