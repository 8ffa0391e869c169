"""Getting out of loops: the more often an agent has looked at the same view in a search, the less it insists.

A memoryless policy that is misled in one state, for example in front of an object the recogniser does not believe
in, comes back to it for ever. The paper names a memory of what was visited as future work; this is the least
of one. A search that never comes back is not changed by it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

ALIKE = 0.999
"""Cosine similarity of pooled features from which on two views count as the same; about one view in a hundred of the
bundled kitchen has another one that is so like it."""


def is_alike(look: NDArray[np.float32], other: NDArray[np.float32]) -> bool:
    """Whether two looks, (D,) unit vectors, are at the same view."""
    return float(look @ other) > ALIKE


def escape_loop(probabilities: NDArray[np.floating], earlier_looks: NDArray[np.integer] | int) -> NDArray[np.float64]:
    """Flatten a policy's probabilities p to p^(1 / (1 + n)), normalised.

    Args:
        probabilities: (..., A) of actions.
        earlier_looks: (...) how often the view was looked at before in this search, n; 0 changes nothing.

    Returns:
        (..., A) float64, sums to 1.
    """
    exponent = 1.0 / (1.0 + np.asarray(earlier_looks, np.float64))[..., None]
    flattened = np.asarray(probabilities, np.float64) ** exponent
    return flattened / flattened.sum(axis=-1, keepdims=True)
