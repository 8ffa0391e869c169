"""Fixtures that several test folders share."""

import signal
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

from active_perceiver.scenes import Scene, save_scene
from active_perceiver.training.config import TrainConfig
from active_perceiver.vision import Backbone
from helpers import toy_agent
from helpers.agents import ball, short_searches, wanderer
from helpers.small import backbone
from helpers.toy import toy_scene
from helpers.workers import shared_folder

__all__ = ["backbone", "ball", "short_searches", "wanderer"]

# Tests do not measure time: on a busy machine a deadline is only a way to fail.
hypothesis.settings.register_profile("untimed", deadline=None)
hypothesis.settings.load_profile("untimed")

# A shell that runs the tests in the background makes them, and the programs that they start, deaf to Ctrl-C; nohup to
# the end of the terminal. What is handled here, and not ignored, those programs hear.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, lambda *_: None)


@pytest.fixture(scope="session")
def scene() -> Scene:
    """A small scene that takes a quarter of a second."""
    return toy_scene()


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Tests neither use nor fill the user's cache; all workers share one."""
    folder = shared_folder(tmp_path_factory) / "cache"
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ACTIVE_PERCEIVER_CACHE", str(folder))
        yield folder


@pytest.fixture(scope="session")
def scene_file(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small scene as a file."""
    path = tmp_path_factory.mktemp("scenes") / "toy_0.h5"
    save_scene(scene, path)
    return path


@pytest.fixture(scope="session")
def settings(scene_file: Path, backbone: Backbone) -> TrainConfig:
    """A training of seconds."""
    return toy_agent.train_config(scene_file)


@pytest.fixture(scope="session")
def agent_folder(scene_file: Path, backbone: Backbone, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An agent trained on the small scene; it is committed, so that having it takes no time."""
    return toy_agent.copy(tmp_path_factory.mktemp("agents") / "toy", scene_file)


@pytest.fixture(scope="session")
def trained_folder(settings: TrainConfig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, trained now: for tests of training, all in the xdist group "training", so that it runs once."""
    from active_perceiver.training.train import train

    folder = tmp_path_factory.mktemp("agents") / "toy"
    train(settings, folder)
    return folder
