"""Fixtures that several test folders share."""

import pytest

from active_perceiver.scenes import Scene
from toy import toy_scene


@pytest.fixture(scope="session")
def scene() -> Scene:
    return toy_scene()
