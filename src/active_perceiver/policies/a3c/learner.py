"""Asynchronous advantage actor-critic (Mnih et al. 2016), as Zhu and the paper train: a worker per scene and target.

Each worker is a process that lives episodes of its own search with its own copy of the weights and updates the shared
ones without waiting for others. In serial mode the same workers take turns in one process.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing
from pathlib import Path

from active_perceiver.policies.a3c.checkpoint import Checkpoint
from active_perceiver.policies.a3c.processes import run_workers
from active_perceiver.policies.a3c.worker import EpisodeWorker, SharedWeights
from active_perceiver.policies.config import A3cConfig
from active_perceiver.policies.monitor import Monitor
from active_perceiver.policies.network import PolicyNetwork, seeded_network
from active_perceiver.policies.training_task import TrainingTask


def train_a3c(
    training_tasks: Sequence[TrainingTask],
    config: A3cConfig,
    monitor: Monitor,
    checkpoint: Path | None = None,
) -> PolicyNetwork:
    """Train a policy by A3C; an iteration is an update, a sample a step of an episode. See `Learner.train`.

    Args:
        training_tasks: one per scene, with features of one backbone.
        config: see `A3cConfig`.
        monitor: watches the training, and says when it is over.
        checkpoint: a file that keeps the state of the training, written at every measurement and whatever ends it;
            a training that finds it goes on from there.

    Raises:
        SearchError: if there are no problems, they do not go together, or the checkpoint is of another training.
        WorkerCrashError: if a worker failed or was killed.
    """
    shared = SharedWeights.of(seeded_network(training_tasks, config))
    searches = [
        (training_task, target)
        for training_task in training_tasks
        for target in range(len(training_task.task.targets))
    ]
    state = Checkpoint.start(config, len(searches))
    if checkpoint is not None and checkpoint.exists():
        state = Checkpoint.load(checkpoint, config, shared)
    monitor.start(state.history)
    state.history = monitor.history
    workers = [
        EpisodeWorker(training_task, target, shared.network, config, number, state.episodes[number])
        for number, (training_task, target) in enumerate(searches)
    ]
    live = _take_turns if config.serial else run_workers
    try:
        with closing(live(workers, shared, state.updates, config.iterations)) as worker_result:
            for number, steps, state.updates in worker_result:
                state.episodes[number] += 1
                state.samples += steps
                before = len(monitor.history)
                finished = monitor.finished(shared.network, state.updates, state.samples)
                if checkpoint is not None and len(monitor.history) > before:
                    state.save(checkpoint, shared)
                if finished:
                    break
    finally:
        if checkpoint is not None:
            state.save(checkpoint, shared)
    return shared.network


def _take_turns(
    workers: Sequence[EpisodeWorker], shared: SharedWeights, done: int, most: int
) -> Generator[tuple[int, int, int]]:
    """Let one worker after the other live an episode; the same interface as `run_workers`."""
    updates = done

    def next_update() -> int | None:
        nonlocal updates
        updates += 1
        return updates - 1 if updates <= most else None

    while updates < most:
        for worker in workers:
            if updates < most:
                yield worker.number, worker.episode(shared, next_update), min(updates, most)
