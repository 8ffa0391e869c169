"""`reproduce`: run the cells that an experiment needs, then write its table or figure and the numbers behind it."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from active_perceiver.reproduction.cells import Cell, Cells, cells_of
from active_perceiver.reproduction.config import Experiment, MethodName, ReproduceConfig
from active_perceiver.reproduction.paper_figures import curves, entropy, trajectories
from active_perceiver.reproduction.policy_inputs import PolicyInputs
from active_perceiver.reproduction.setups import CHOICES, FULL, METHODS, QUICK, BudgetConfig
from active_perceiver.reproduction.tables import (
    format_choices,
    format_recogniser,
    format_table_1,
    format_table_2,
    table_1,
    table_2,
    table_of_choices,
)
from active_perceiver.utils.files import replacing
from active_perceiver.utils.progress import console
from active_perceiver.utils.result import write_result
from active_perceiver.vision.backbone import load_backbone

LOG = logging.getLogger(__name__)

LEARNED: tuple[MethodName, ...] = tuple(name for name, method in METHODS.items() if method.reward)
RECORD: tuple[MethodName, ...] = ("record_high", "record_low")


def reproduce(what: Experiment, settings: ReproduceConfig, out: Path) -> list[str] | None:
    """Run an experiment, or go on with it.

    Results of single trainings are kept in `out`/cells; what is there is not run again.

    Args:
        what: which, or "all".
        settings: how much of it.
        out: folder for everything.

    Returns:
        For each experiment its table, if it has one, and the files that were written; None if time was up before all
        was done: the same call goes on.
    """
    scale = QUICK if settings.quick else FULL
    with console.status(f"backbone {settings.backbone}; the first time it is converted, which takes half a minute"):
        backbone = load_backbone(settings.backbone, image_size=scale.image_size)
    goal_observations = PolicyInputs(out / "recognisers", backbone, scale.recogniser, scale.folds, settings.boxes)
    cells = Cells(out / "cells", scale, goal_observations)
    chosen = list(EXPERIMENTS) if what == "all" else [what]
    wanted = list(dict.fromkeys(cell for name in chosen for cell in EXPERIMENTS[name][0](settings, scale)))
    if not _run(cells, wanted, settings.minutes):
        return None
    written = []
    for name in chosen:
        needed, write = EXPERIMENTS[name]
        written.append(write(needed(settings, scale), cells, goal_observations, scale, out))
    return written


def _run(cells: Cells, wanted: Sequence[Cell], minutes: float | None) -> bool:
    """Run what is missing; False if time is up before all is done."""
    started = time.monotonic()
    missing = [cell for cell in wanted if not cells.done(cell)]
    for number, cell in enumerate(missing):
        if minutes is not None and time.monotonic() - started > 60 * minutes:
            done = len(wanted) - len(missing) + number
            LOG.warning("time is up: %d of %d trainings are done; the same command goes on", done, len(wanted))
            return False
        cells.result(cell)
        done = len(wanted) - len(missing) + number + 1
        minute = (time.monotonic() - started) / 60
        LOG.info("%d of %d: %s (%.1f min)", done, len(wanted), cell.name, minute)
    return True


def _table_1_cells(settings: ReproduceConfig, scale: BudgetConfig) -> list[Cell]:
    seeds = settings.seeds or scale.seeds
    return cells_of(
        settings.setups or tuple(scale.setups), settings.methods or tuple(METHODS), settings.learners, seeds
    )


def _table_2_cells(settings: ReproduceConfig, scale: BudgetConfig) -> list[Cell]:
    return cells_of(("four_objects",), RECORD, settings.learners, settings.seeds or scale.seeds)


def _curve_cells(settings: ReproduceConfig, scale: BudgetConfig) -> list[Cell]:
    methods: tuple[MethodName, ...] = ("random", *LEARNED)
    return cells_of(("four_objects",), methods, settings.learners, settings.seeds or scale.seeds)


def _picture_cells(settings: ReproduceConfig, scale: BudgetConfig) -> list[Cell]:
    return cells_of(("four_objects",), RECORD, settings.learners, 1)


def _choice_cells(settings: ReproduceConfig, scale: BudgetConfig) -> list[Cell]:
    return [Cell("one_object", "record_low", "a3c", 0, choice) for choice in ("", *CHOICES)]


def _write_table_1(
    needed: Sequence[Cell], cells: Cells, goal_observations: PolicyInputs, scale: BudgetConfig, out: Path
) -> str:
    results = {cell: cells.result(cell) for cell in needed}
    rows = table_1(results)
    scenes = {scene for cell in needed for scene in scale.setups[cell.setup].searches}
    recogniser = _recogniser(goal_observations, sorted(scenes))
    text = format_table_1(rows, scale)
    if recogniser is not None:
        text += f"\n\n{format_recogniser(recogniser)}"
    return _write(
        out, "table1", {"protocol": _protocol(goal_observations, scale), "recogniser": recogniser, "rows": rows}, text
    )


def _write_table_2(
    needed: Sequence[Cell], cells: Cells, goal_observations: PolicyInputs, scale: BudgetConfig, out: Path
) -> str:
    rows = table_2({cell: cells.result(cell) for cell in needed})
    return _write(
        out, "table2", {"protocol": _protocol(goal_observations, scale), "rows": rows}, format_table_2(rows)
    )


def _write_choices(
    needed: Sequence[Cell], cells: Cells, goal_observations: PolicyInputs, scale: BudgetConfig, out: Path
) -> str:
    rows = table_of_choices({cell: cells.result(cell) for cell in needed})
    return _write(
        out, "choices", {"protocol": _protocol(goal_observations, scale), "rows": rows}, format_choices(rows)
    )


def _write(out: Path, name: str, body: dict[str, Any], text: str) -> str:
    write_result(out / f"{name}.json", f"reproduce {name}", body)
    with replacing(out / f"{name}.md") as temporary:
        temporary.write_text(text + "\n")
    return f"{text}\n\n{out / name}.json, {out / name}.md"


def _protocol(goal_observations: PolicyInputs, scale: BudgetConfig) -> dict[str, Any]:
    """How everything was measured and trained."""
    return {
        "episodes": scale.episodes,
        "limit": scale.limit,
        "boxes": goal_observations.boxes,
        "image_size": scale.image_size,
        "setups": {name: asdict(setup) for name, setup in scale.setups.items()},
        "a3c": asdict(scale.a3c),
        "ppo": asdict(scale.ppo),
    }


def _recogniser(goal_observations: PolicyInputs, scenes: Sequence[str]) -> dict[str, Any] | None:
    """Figures of the cross-validated recognisers, over the views of all places; None if the truth was shown."""
    if goal_observations.boxes == "ground-truth":
        return None
    return {
        scene: {
            "metrics": {
                name: metrics.as_dict() for name, metrics in goal_observations.detections(scene).metrics.items()
            },
            "seconds": goal_observations.detections(scene).seconds,
        }
        for scene in scenes
    }


Needs = Callable[[ReproduceConfig, BudgetConfig], list[Cell]]
Writes = Callable[[Sequence[Cell], Cells, PolicyInputs, BudgetConfig, Path], str]

EXPERIMENTS: dict[Experiment, tuple[Needs, Writes]] = {
    "table1": (_table_1_cells, _write_table_1),
    "table2": (_table_2_cells, _write_table_2),
    "curves": (_curve_cells, curves),
    "entropy": (_picture_cells, entropy),
    "trajectories": (_picture_cells, trajectories),
    "choices": (_choice_cells, _write_choices),
}
"""Each experiment's cells, and what writes its result."""
