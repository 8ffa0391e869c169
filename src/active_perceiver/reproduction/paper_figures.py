"""The paper's figures from the results of cells: each a picture and the numbers in it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from active_perceiver.envs.task import SearchTask
from active_perceiver.figures.entropy_map import entropy_maps
from active_perceiver.figures.floor import SearchPanel, figure_png, trajectory_panels
from active_perceiver.figures.learning_curves import Curve, learning_curves
from active_perceiver.policies.markov_chain import checked_table, entropies, markov_chain
from active_perceiver.policies.sampling import Episode, run_episode
from active_perceiver.reproduction.cells import MOMENTS, Cell, Cells
from active_perceiver.reproduction.policy_inputs import PolicyInputs
from active_perceiver.reproduction.setups import METHODS, BudgetConfig
from active_perceiver.reproduction.tables import LEARNER_LABELS
from active_perceiver.utils.files import replacing
from active_perceiver.utils.result import write_result

# Searches drawn for each target, and the actions after which one is given up in the picture.
PATHS = 4
PATH_LIMIT = 1000


def curves(
    needed: Sequence[Cell], cells: Cells, goal_observations: PolicyInputs, scale: BudgetConfig, out: Path
) -> str:
    """Expected number of actions of a search during training, for each reward (the paper's figure of curves)."""
    results = {cell: cells.result(cell) for cell in needed}
    setup = needed[0].setup
    learned = list(dict.fromkeys((cell.learner, cell.method) for cell in needed if cell.learner))
    walk = [result["exact"]["overall"] for cell, result in results.items() if cell.learner is None]
    panels: dict[str, list[Curve]] = {}
    for learner, method in learned:
        histories = [results[cell]["history"] for cell in needed if (cell.learner, cell.method) == (learner, method)]
        # Workers side by side do not stop for a measurement, so its iteration differs a little between seeds.
        iterations = np.array([record["iteration"] for record in histories[0]])
        lengths = [
            np.interp(
                iterations,
                [record["iteration"] for record in history],
                [expected_length(record, scale.limit) for record in history],
            )
            for history in histories
        ]
        curve = Curve(METHODS[method].label, iterations, np.array(lengths))
        panels.setdefault(LEARNER_LABELS[learner], []).append(curve)
    least = _shortest(cells, needed[0])
    random = expected_length(walk[0], scale.limit)
    figure = learning_curves(panels, dict.fromkeys(panels, random), dict.fromkeys(panels, least))
    body = {
        "setup": setup,
        "limit": scale.limit,
        "boxes": goal_observations.boxes,
        "random_walk": random,
        "shortest": least,
        "curves": [
            {"learner": learner, "label": curve.label, "iterations": curve.iterations.tolist(),
             "lengths": curve.lengths.tolist()}
            for learner, some in panels.items() for curve in some
        ],
    }  # fmt: skip
    return _write(out, "curves", body, figure)


def expected_length(record: dict[str, Any], limit: int) -> float:
    """Expected number of actions of a search, of which those that fail take `limit`."""
    success = record["success"]
    return float((success * record["mean_steps"] if success > 0 else 0.0) + (1 - success) * limit)


def _shortest(cells: Cells, cell: Cell) -> float:
    """Mean over targets of the fewest actions, over all starts."""
    means = [
        task.steps[task.starts(target), target].mean()
        for task in (training_task.task for training_task in cells.training_tasks(cell))
        for target in range(len(task.targets))
    ]
    return float(np.mean(means))


def entropy(
    needed: Sequence[Cell], cells: Cells, goal_observations: PolicyInputs, scale: BudgetConfig, out: Path
) -> str:
    """Mean entropy of the policy per place at the start, in the middle and at the end of training."""
    rows: dict[str, list[NDArray[np.floating]]] = {}
    body: dict[str, Any] = {"boxes": goal_observations.boxes, "rows": []}
    for cell in needed:
        tables = cells.tables(cell)
        [scene] = tables["start"]
        most = float(np.log(tables["start"][scene].shape[-1]))
        # Rounding must not push a random walk above the most that is possible.
        by_moment = [np.minimum(entropies(tables[moment][scene]).mean(axis=1), most) for moment in MOMENTS]
        label = f"{LEARNER_LABELS[cell.learner]}, weight {METHODS[cell.method].entropy_weight:g}"
        rows[label] = by_moment
        means = {moment: float(some.mean()) for moment, some in zip(MOMENTS, by_moment, strict=True)}
        iterations = [record["iteration"] for record in cells.result(cell)["history"]]
        body["rows"].append({"cell": cell.name, "iterations": iterations[-1], "mean_entropy": means})
    return _write(
        out, "entropy", body | {"most": most}, entropy_maps(goal_observations.scene(scene), rows, MOMENTS, most)
    )


def trajectories(
    needed: Sequence[Cell], cells: Cells, goal_observations: PolicyInputs, scale: BudgetConfig, out: Path
) -> str:
    """Searches from above for each target, by the policies that explore least."""
    panels, searches, stuck = [], [], []
    for cell in (cell for cell in needed if cell.method == "record_low"):
        [(scene_name, table)] = cells.tables(cell)["end"].items()
        [training_task] = cells.training_tasks(cell)
        scene, task = goal_observations.scene(scene_name), training_task.task
        rng = np.random.default_rng(cell.seed)
        for target, name in enumerate(task.targets):
            starts = _far_apart(scene.poses, task.starts(target), rng)
            found = [run_episode(table, task, target, int(start), rng, PATH_LIMIT) for start in starts]
            searches += [_search(cell, name, episode, task.steps[episode.states[0], target]) for episode in found]
            stuck.append({"cell": cell.name, "target": name, **where_stuck(table, task, target, scale.limit)})
            lengths = ", ".join(str(len(episode)) if episode.success else "-" for episode in found)
            paths = [scene.poses[episode.states] for episode in found]
            title = f"{LEARNER_LABELS[cell.learner]}, {name}: {lengths}"
            panels.append(SearchPanel(title, paths, task.goals[:, target]))
    body = {"boxes": goal_observations.boxes, "limit": PATH_LIMIT, "searches": searches, "stuck": stuck}
    return _write(out, "trajectories", body, trajectory_panels(scene, panels))


def where_stuck(table: NDArray[np.floating], task: SearchTask, target: int, limit: int) -> dict[str, float | None]:
    """What searches that have not arrived after `limit` actions are looking at.

    Args:
        table: (S, T, A) probabilities of actions.
        task: the search.
        target: index of the target.
        limit: actions.

    Returns:
        `share` of all starts that are still searching, and the `area` of the target in their views then, as a
        fraction of the smallest that makes a goal (mean; None if the share is 0).
    """
    among = task.steps[:, target] > 0
    chain = markov_chain(task, checked_table(table, task)[:, target], among)
    still = np.full(chain.shape[0], 1 / chain.shape[0])
    for _ in range(limit):
        still = still @ chain
    share = float(still.sum())
    if share < 1e-6:
        return {"share": 0.0, "area": None}
    seen = task.areas[among, target] / task.goal_areas[target]
    return {"share": share, "area": float(still @ seen) / share}


def _search(cell: Cell, target: str, episode: Episode, shortest: Any) -> dict[str, Any]:
    return {
        "cell": cell.name, "target": target, "start": int(episode.states[0]), "actions": len(episode),
        "success": episode.success, "shortest": int(shortest),
    }  # fmt: skip


def _far_apart(poses: NDArray[np.floating], starts: NDArray[np.int64], rng: np.random.Generator) -> list[int]:
    """Starts in different parts of the room: each as far as can be from those before."""
    chosen = [int(rng.choice(starts))]
    while len(chosen) < min(PATHS, len(starts)):
        gaps = np.linalg.norm(poses[starts, None, :2] - poses[chosen, :2], axis=-1).min(axis=1)
        chosen.append(int(starts[gaps.argmax()]))
    return chosen


def _write(out: Path, name: str, body: dict[str, Any], figure: Figure) -> str:
    write_result(out / f"{name}.json", f"reproduce {name}", body)
    with replacing(out / f"{name}.png") as temporary:
        temporary.write_bytes(figure_png(figure))
    return f"{out / name}.json, {out / name}.png"
