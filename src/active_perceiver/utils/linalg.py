"""Linear algebra that several parts share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def unit_vectors(features: NDArray[np.float32]) -> NDArray[np.float32]:
    """Scale the last axis to length 1."""
    return features / np.maximum(np.linalg.norm(features, axis=-1, keepdims=True), 1e-12)
