"""Which page has which blocks, and what fills them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from docs.generate import commands, layers, paper, results, rooms
from docs.generate.package import BENCHMARK_TABLES
from docs.generate.pages import Blocks

BLOCKS: Mapping[str, Blocks] = {
    "README.md": {"results": results.beside_the_paper},
    "docs/architecture.md": {
        "layers": layers.software,
        "without_torch": layers.without_torch,
        "rooms": layers.rooms,
    },
    "docs/commands.md": {"list": commands.list_of_commands, "commands": commands.sections},
    "docs/results.md": {
        "paper": results.beside_the_paper,
        "demo": results.demo,
        "recognisers": results.demo_recognisers,
        "policies": results.policies,
        "action": results.one_action,
        "robot": results.robot,
        "robustness": results.robustness,
    },
    "docs/scenes.md": {
        "bundled": rooms.bundled,
        "agents": results.agents,
        "kinds": rooms.kinds,
        "sound": results.sound_rooms,
        "elsewhere": results.elsewhere,
    },
    "docs/your-own-room.md": {"results": results.own_room},
    "docs/gymnasium.md": {"ids": rooms.gymnasium_ids},
    "docs/robot.md": {"runs": results.robot_runs},
    "docs/exporting.md": {"int8": results.int8},
    "docs/reproduction.md": {
        "table1": paper.table_1,
        "table2": paper.table_2,
        "recogniser": paper.recogniser,
        "choices": paper.choices,
        "views": paper.views,
    },
    **{f"docs/benchmarks/{name}.md": {"table": partial(results.benchmark_table, name)} for name in BENCHMARK_TABLES},
    "docs/benchmarks/robot.md": {"table": partial(results.benchmark_table, "robot"), "compared": results.robot},
}
"""Path of a page -> its blocks."""
