"""docs/commands.md: what every command says with `--help`, as Markdown."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from unittest import mock

from docs.generate.markdown import table
from docs.generate.package import main

_BOX = re.compile(r"^╭─ (.+?) ─+╮\n(.*?)^╰─+╯$", re.DOTALL | re.MULTILINE)
_RULE = re.compile(r"^─+$")


@dataclass
class CommandHelp:
    """What one command says of itself.

    Attributes:
        words: of the command, without the program's name.
        summary: what it does.
        examples: command lines.
        arguments: name and meaning of each argument and option, but for --help.
        commands: names of the commands below it; a command that has some does nothing itself.
    """

    words: tuple[str, ...]
    summary: str
    examples: list[str] = field(default_factory=list)
    arguments: list[tuple[str, str]] = field(default_factory=list)
    commands: list[str] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The words, as they are typed."""
        return " ".join(self.words)


def help_text(words: tuple[str, ...]) -> str:
    """What a command prints with `--help`, on a terminal so wide that nothing is wrapped."""
    printed = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")  # of a StringIO nobody knows that it can show boxes
    with mock.patch.dict(os.environ, {"COLUMNS": "2000", "NO_COLOR": "1"}), redirect_stdout(printed):
        try:
            main([*words, "--help"])
        except SystemExit as end:
            if end.code:
                raise
    printed.seek(0)
    return printed.read()


def read_help(words: tuple[str, ...], text: str) -> CommandHelp:
    """Take the help of a command apart."""
    described = text[: text.index("╭")].partition("\n\n")[2]
    summary, _, examples = described.partition("Examples:")
    # "(each has its own --help)" is no news on a page that shows it.
    summary = re.sub(r" \((each has its )?own --help( each)?\)", "", " ".join(summary.split()))
    found = CommandHelp(words, summary, [line.strip() for line in examples.splitlines() if line.strip()])
    for title, content in _BOX.findall(text):
        lines = [line.removeprefix("│ ").removesuffix("│").rstrip() for line in content.splitlines()]
        if title == "subcommands":
            found.commands = [line.split()[1] for line in lines if line.startswith("  • ")]
        else:
            found.arguments += [pair for pair in _arguments(lines) if not pair[0].startswith("-h,")]
    return found


def _arguments(lines: list[str]) -> list[tuple[str, str]]:
    """Name and meaning of each argument of a box; what describes the box stands above a rule and is left out."""
    rules = [number for number, line in enumerate(lines) if _RULE.match(line)]
    found: list[tuple[str, str]] = []
    for line in lines[rules[-1] + 1 :] if rules else lines:
        name, meaning = "", line
        if not line.startswith(" "):
            name, *rest = re.split(r" {2,}", line, maxsplit=1)
            meaning = " ".join(rest)
            found.append((name.replace("{None}|", ""), ""))
        name, before = found[-1]
        found[-1] = (name, f"{before} {meaning.strip()}".strip())
    return [(name, re.sub(r" \(default: (None|False)?\)$", "", meaning)) for name, meaning in found]


def all_commands(words: tuple[str, ...] = ()) -> Iterator[CommandHelp]:
    """A command and all below it, in the order of the help."""
    found = read_help(words, help_text(words))
    yield found
    for name in found.commands:
        yield from all_commands((*words, name))


def list_of_commands() -> str:
    """A table of all commands that do something, each with what it does."""
    rows = [
        (f"[`{command.name}`](#{'-'.join(command.words)})", _escaped(_first_sentence(command.summary)))
        for command in all_commands()
        if not command.commands
    ]
    return table(("command", "does"), rows)


def sections() -> str:
    """A section for each command that does something."""
    return "\n\n".join(_section(command) for command in all_commands() if not command.commands)


def _section(command: CommandHelp) -> str:
    parts = [f"## {command.name}", _escaped(command.summary)]
    if command.examples:
        parts.append("\n".join(["```", *command.examples, "```"]))
    if command.arguments:
        rows = [(f"`{name}`", _escaped(meaning)) for name, meaning in command.arguments]
        parts.append(table(("argument", "meaning"), rows))
    return "\n\n".join(parts)


def _first_sentence(text: str) -> str:
    return re.split(r"; |\.(?= [A-Z])", text)[0].removesuffix(".")


def _escaped(text: str) -> str:
    """Prose of a help in which stars and angle brackets are no markup; code in back quotes stays as it is."""
    pieces = re.split(r"(`[^`]*`)", text)
    return "".join(piece if piece.startswith("`") else re.sub(r"([*<])", r"\\\1", piece) for piece in pieces)
