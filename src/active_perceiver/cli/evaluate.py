"""The command `active-perceiver evaluate`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from tyro.conf import OmitArgPrefixes, Positional, subcommand

from active_perceiver.cli.help import help_text
from active_perceiver.evaluation.config import EvaluateConfig


@dataclass
class Evaluate:
    """Measure an agent."""

    agent: Positional[Path]
    """Folder of the agent."""
    settings: OmitArgPrefixes[EvaluateConfig] = field(default_factory=EvaluateConfig)
    out: Path | None = None
    """Write the result here as well, as JSON."""
    force: bool = False
    """Replace an existing file."""

    def run(self) -> int:
        from active_perceiver.agent.perceiver import ActivePerceiver
        from active_perceiver.evaluation.evaluate import evaluate, format_measures
        from active_perceiver.utils.files import check_output
        from active_perceiver.utils.result import write_result

        if self.out is not None:
            check_output(self.out, self.force)
        config = self.settings
        agent = ActivePerceiver.from_pretrained(self.agent, confirm=config.confirm, explore=config.explore)
        body = evaluate(agent, config).to_json()
        print(format_measures(body))
        if self.out is not None:
            write_result(self.out, "evaluate", body)
        return 0


EvaluateCommand = Annotated[
    Evaluate,
    subcommand(
        "evaluate",
        description=help_text(
            "Measure an agent: success, steps, ratio to the shortest path, SPL, and its own word.",
            "evaluate kitchen_agent",
            "evaluate kitchen_agent --protocol paper --out paper.json",
        ),
    ),
]
