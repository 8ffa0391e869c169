"""Searches that nobody made, to be recorded and reported: each has all that a look can have."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.agent.perceiver import Step
from active_perceiver.live import SearchRecord, StepRecord
from active_perceiver.live.recorder import Recorder
from active_perceiver.live.recording_header import Floor, RecordingHeader
from active_perceiver.recognition.recogniser import Detection
from active_perceiver.scenes import EIGHT_ACTIONS, Scene
from active_perceiver.scenes.images import encode_image


def setup_in(scene: Scene, **changes: Any) -> RecordingHeader:
    """What such a search was asked to do."""
    setup = RecordingHeader(
        picture="ball.png", agent="agent", robot="scene:toy", place="toy_0", start="state 7", scene=None,
        actions=EIGHT_ACTIONS, max_steps=20, max_minutes=5.0, seed=3, confirm=False, explore=True, dry_run=False,
        started="2026-01-02T03:04:05+00:00", software="0.1.0", floor=Floor.of(scene),
    )  # fmt: skip
    return dataclasses.replace(setup, **changes)


def step_records_in(scene: Scene, count: int = 4, encoded: bool = False) -> tuple[StepRecord, ...]:
    """Looks at views of the scene; one has no detection, one no pose."""
    rng = np.random.default_rng(0)
    made = []
    for look in range(count):
        probabilities = rng.dirichlet(np.ones(8))
        detection = None if look == 1 else Detection(rng.uniform(), rng.uniform(0.2, 0.4, 4))
        step = Step(EIGHT_ACTIONS[look % 8], detection, probabilities, found=False)
        view = scene.view(11 * look)
        pose = None if look == 2 else tuple(scene.poses[11 * look].tolist())
        frame = encode_image(view, "png") if encoded else view
        made.append(StepRecord(frame, pose, step, (None, True, False, np.bool_(True))[look % 4], 0.5 * look))
    return tuple(made)


def record_of(scene: Scene, folder: Path, encoded: bool = False, **changes: Any) -> SearchRecord:
    """A finished recording, and what it is of."""
    picture, step_records = scene.targets[0].picture(0), step_records_in(scene, encoded=encoded)
    record = SearchRecord(picture, step_records, False, 2.5, "max steps", bool(changes.get("dry_run")))
    with Recorder(folder, setup_in(scene, **changes), picture) as recorder:
        for step_record in step_records:
            recorder.keep(step_record)
        recorder.end(record)
    return record
