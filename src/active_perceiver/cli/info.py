"""The command `active-perceiver info`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated

from tyro.conf import subcommand

from active_perceiver.cli.help import help_text


@dataclass
class Info:
    """Versions and machine, for a bug report."""

    def run(self) -> int:
        from active_perceiver.scenes import bundled_names
        from active_perceiver.utils.result import machine
        from active_perceiver.version import __version__
        from active_perceiver.vision.backbone import cache_folder

        facts = {"version": __version__, **machine(), "cache": str(cache_folder()), "scenes": bundled_names()}
        print(json.dumps(facts, indent=2))
        return 0


InfoCommand = Annotated[
    Info, subcommand("info", description=help_text("Versions and machine, for a bug report.", "info"))
]
