"""A small backbone for tests of vision and recognition: 96 pixels give maps of 6 x 6 cells, quick to compute."""

from __future__ import annotations

import numpy as np
import pytest

from active_perceiver.vision import Backbone, load_backbone

SIZE = 96


@pytest.fixture(scope="session")
def backbone(cache: object) -> Backbone:
    """EfficientNet-Lite0 for 96 pixels, in the tests' own cache."""
    return load_backbone(image_size=SIZE, threads=1)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)
