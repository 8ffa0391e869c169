"""A small backbone for tests of vision and recognition: 96 pixels give maps of 6 x 6 cells, quick to compute."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from active_perceiver.vision import Backbone, load_backbone
from helpers.workers import one_at_a_time

SIZE = 96


@pytest.fixture(scope="session")
def backbone(cache: Path) -> Backbone:
    """EfficientNet-Lite0 for 96 pixels, in the tests' own cache.

    A fixture or test that trains or loads an agent asks for it, so that no two workers convert it at the same time.
    """
    with one_at_a_time(cache / "backbones"):
        return load_backbone(image_size=SIZE, threads=1)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)
