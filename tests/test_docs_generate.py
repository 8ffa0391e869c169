"""`make docs`: blocks are filled, stale ones noticed, wrong markers refused."""

from __future__ import annotations

from itertools import pairwise

import pytest

from docs.generate import __main__ as program
from docs.generate.blocks import BLOCKS
from docs.generate.commands import all_commands, read_help
from docs.generate.layers import draw
from docs.generate.markdown import table
from docs.generate.pages import PageError, fill, fill_pages

PAGE = """# Title

<!-- begin: one -->
old
<!-- end: one -->

prose

<!-- begin: two -->
<!-- end: two -->
end
"""
FILLED = PAGE.replace("old", "1").replace("two -->\n<", "two -->\n| 2 |\n<")


def blocks(**more):
    return {"one": lambda: "1", "two": lambda: "| 2 |\n", **more}


@pytest.fixture
def root(tmp_path):
    (tmp_path / "docs" / "deeper").mkdir(parents=True)
    (tmp_path / "README.md").write_text("no block\n")
    (tmp_path / "docs" / "deeper" / "page.md").write_text(PAGE)
    return tmp_path


def test_blocks_are_filled_once():
    assert fill(PAGE, blocks(), "page.md") == (FILLED, ["one", "two"])
    assert fill(FILLED, blocks(), "page.md") == (FILLED, [])


@pytest.mark.parametrize("content", ["", "one line", "two\n\nparagraphs", "```\n a\n\n\n b\n```", "a \\1 \\g<0>"])
def test_any_content_stays_as_it_is(content):
    text, _ = fill(PAGE, blocks(one=lambda: content), "page.md")
    assert f"<!-- begin: one -->\n{content}{'' if not content else chr(10)}<!-- end: one -->" in text
    assert fill(text, blocks(one=lambda: content), "page.md") == (text, [])


def test_pages_are_written_once_and_stale_ones_named(root):
    page = root / "docs" / "deeper" / "page.md"
    table = {"docs/deeper/page.md": blocks()}
    both = [("docs/deeper/page.md", "one"), ("docs/deeper/page.md", "two")]
    assert fill_pages(root, table, write=False) == both
    assert page.read_text() == PAGE
    assert fill_pages(root, table) == both
    assert page.read_text() == FILLED
    assert fill_pages(root, table) == []
    page.write_text(FILLED.replace("| 2 |", "| 3 |"))
    assert fill_pages(root, table, write=False) == both[1:]


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("<!-- begin: one -->\nold\n<!-- end: one -->\n", "", "the markers of the block 'one' are missing"),
        ("one -->", "three -->", "nothing fills the block 'three'"),
        ("<!-- end: one -->\n", "", "'<!-- begin: two -->' stands where it should not"),
        ("<!-- begin: one -->\n", "", "'<!-- end: one -->' stands where it should not"),
        ("<!-- end: two -->\n", "", "'<!-- end: two -->' is missing"),
        ("two -->", "one -->", "the block 'one' is there twice"),
    ],
)
def test_wrong_markers_are_refused_and_nothing_is_written(root, old, new, fault):
    page = root / "docs" / "deeper" / "page.md"
    (root / "docs" / "a.md").write_text("<!-- begin: one -->\n<!-- end: one -->\n")
    page.write_text(PAGE.replace(old, new))
    with pytest.raises(PageError, match=rf"docs/deeper/page\.md: {fault}"):
        fill_pages(root, {"docs/deeper/page.md": blocks(), "docs/a.md": {"one": lambda: "1"}})
    assert (root / "docs" / "a.md").read_text() == "<!-- begin: one -->\n<!-- end: one -->\n"


def test_a_page_that_is_not_there_is_refused(root):
    with pytest.raises(PageError, match=r"docs/b\.md: there is no such page"):
        fill_pages(root, {"docs/b.md": blocks()})


def test_exit_codes(root, monkeypatch, capsys):
    monkeypatch.setattr(program, "ROOT", root)
    monkeypatch.setattr(program, "BLOCKS", {"docs/deeper/page.md": blocks()})
    assert program.main(["--check"]) == 1
    assert "docs/deeper/page.md: one is stale" in capsys.readouterr().out
    assert program.main([]) == 0
    assert program.main(["--check"]) == 0
    monkeypatch.setattr(program, "BLOCKS", {})
    assert program.main([]) == 2
    assert "docs/deeper/page.md: nothing fills the block 'one'" in capsys.readouterr().err


def test_no_block_of_this_repository_is_stale():
    assert fill_pages(program.ROOT, BLOCKS, write=False) == []


def test_layers_are_drawn_with_their_neighbours_side_by_side():
    assert draw(["a", "b | c", "d : e"], width=11).splitlines() == [
        "┌───────────┐",
        "│     a     │",
        "├─────┬─────┤",
        "│  b  │  c  │",
        "├─────┴─────┤",
        "│   d ↔ e   │",
        "└───────────┘",
    ]


def test_walls_of_any_layers_meet():
    lines = draw(["a | b | c", "d | e", "f | g | h | i"], width=40).splitlines()
    assert {len(line) for line in lines} == {42}
    for upper, lower in pairwise(lines):
        for above, below in zip(upper, lower, strict=True):
            assert (above in "│┌┐├┤┬┼") == (below in "│└┘├┤┴┼")


def test_tables_escape_bars():
    assert table(("a", "b"), [("1|2", "3")]) == "| a | b |\n| --- | --- |\n| 1\\|2 | 3 |"


HELP = """usage: active-perceiver walk [-h] [WALK OPTIONS] PATH

Walk, slowly (each has its own --help).

Examples:
  active-perceiver walk a
  active-perceiver walk b --far

╭─ positional arguments ─────╮
│ PATH          Where to.  (required) │
╰────────────────────────────╯
╭─ settings options ─────────╮
│ How it walks.              │
│ ────────────────────────── │
│ -h, --help    show this    │
│ --steps {None}|INT         │
│               How many;    │
│               many. (default: None) │
│ --far         Far. (default: False) │
│ --kind {a,b}  Kind. (default: a) │
╰────────────────────────────╯
"""


def test_help_is_read():
    found = read_help(("walk",), HELP)
    assert found.summary == "Walk, slowly."
    assert found.examples == ["active-perceiver walk a", "active-perceiver walk b --far"]
    assert found.arguments == [
        ("PATH", "Where to.  (required)"),
        ("--steps INT", "How many; many."),
        ("--far", "Far."),
        ("--kind {a,b}", "Kind. (default: a)"),
    ]
    assert found.commands == []


def test_every_command_is_found_with_its_help():
    commands = {command.name: command for command in all_commands()}
    assert {"demo", "scenes import photos", "benchmark train", "info"} <= commands.keys()
    assert commands["scenes"].commands[:2] == ["list", "info"]
    assert ("--max-minutes FLOAT", "Give up after so many minutes. (default: 10.0)") in commands["search"].arguments
    for command in commands.values():
        if not command.commands and command.name != "":
            assert command.summary
            assert all(meaning for _, meaning in command.arguments), command.name
