"""Policy tables: checked, as the Markov chain they make of a search, and how undecided they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError


def checked_table(table: NDArray[np.floating], task: SearchTask) -> NDArray[np.float64]:
    """A policy table for a task, with sums of 1 to the precision of float64.

    Args:
        table: (S, T, A), sums to 1 over actions up to rounding.
        task: of S states, T targets and A actions.

    Raises:
        SearchError: if it has another shape or holds anything but probabilities.
    """
    expected = (*task.goals.shape, len(task.actions))
    if table.shape != expected:
        raise SearchError(f"the policy table has shape {table.shape}, expected {expected} for '{task.scene}'")
    sums = table.sum(axis=-1, dtype=np.float64, keepdims=True)
    if not np.isfinite(table).all() or table.min() < 0 or np.abs(sums - 1).max() > 1e-3:
        raise SearchError("the policy table must hold probabilities that sum to 1 over actions")
    # Rounding errors of float32 would add up over thousands of steps.
    return table / sums


def markov_chain(task: SearchTask, probabilities: NDArray[np.floating], among: NDArray[np.bool_]) -> sparse.csr_array:
    """Transition matrix of the search for one target, restricted to some states.

    Args:
        task: whose transitions to take.
        probabilities: (S, A) of the actions, for that target.
        among: (S,) bool, the n states to keep; probability of leaving them is missing from the rows.

    Returns:
        (n, n), rows and columns in the order of `np.flatnonzero(among)`.
    """
    kept = np.flatnonzero(among)
    position = np.full(len(task), -1)
    position[kept] = np.arange(len(kept))
    columns = position[task.transitions[kept]]
    stays = columns >= 0
    rows = np.broadcast_to(np.arange(len(kept))[:, None], columns.shape)
    # Going through COO sums the actions that lead to the same state.
    entries = (probabilities[kept][stays].astype(np.float64), (rows[stays], columns[stays]))
    return sparse.coo_array(entries, shape=(len(kept), len(kept))).tocsr()


def entropies(table: NDArray[np.floating]) -> NDArray[np.floating]:
    """Entropy of a policy, in nats: (..., A) probabilities -> (...)."""
    return -(table * np.log(np.maximum(table, 1e-30))).sum(axis=-1)
