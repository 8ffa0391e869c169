"""The command `active-perceiver reproduce`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from tyro.conf import OmitArgPrefixes, Positional, subcommand

from active_perceiver.cli.help import help_text
from active_perceiver.reproduction.config import Experiment, ReproduceConfig


@dataclass
class Reproduce:
    """The paper's tables and figures."""

    what: Positional[Experiment]
    """Which: a table, a figure, or all."""
    out: Path = Path("reproduction")
    """Folder for tables, figures and the results of single trainings; what is there is not run again."""
    settings: OmitArgPrefixes[ReproduceConfig] = field(default_factory=ReproduceConfig)

    def run(self) -> int:
        from active_perceiver.reproduction.reproduce import reproduce

        written = reproduce(self.what, self.settings, self.out)
        if written is None:
            return 1
        print("\n".join(written))
        return 0


ReproduceCommand = Annotated[
    Reproduce,
    subcommand(
        "reproduce",
        description=help_text(
            "Reproduce the paper's tables and figures; interrupted, the same command goes on.",
            "reproduce all --quick",
            "reproduce table1 --setups one_object --learners ppo",
            "reproduce table1 --minutes 110 --out reproduction",
        ),
    ),
]
