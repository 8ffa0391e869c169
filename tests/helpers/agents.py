"""An agent that was never trained: it wanders about and never says found. Made in a second."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from active_perceiver.benchmarks.act.untrained_agent import save_untrained_agent
from active_perceiver.evaluation import stop_evaluation
from active_perceiver.scenes import Scene
from active_perceiver.vision import Backbone
from helpers.workers import one_at_a_time, shared_folder


@pytest.fixture(scope="session")
def wanderer(scene: Scene, backbone: Backbone, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the agent, which all workers share."""
    folder = shared_folder(tmp_path_factory) / "wanderer" / "agent"
    with one_at_a_time(folder):
        if not folder.exists():
            save_untrained_agent(folder, backbone, scene, ["ball0"])
    return folder


@pytest.fixture(scope="session")
def ball(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A picture of what it is to search for."""
    path = tmp_path_factory.mktemp("pictures") / "ball.png"
    Image.fromarray(scene.targets[0].picture(0)).save(path)
    return path


@pytest.fixture
def short_searches(monkeypatch: pytest.MonkeyPatch) -> None:
    """An agent that has hardly been trained finds nothing, and would search to the limit again and again."""
    monkeypatch.setattr(stop_evaluation, "LIMIT", 50)
