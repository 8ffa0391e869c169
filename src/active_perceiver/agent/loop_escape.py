"""Getting out of loops: the more often an agent has looked at the same view in a search, the less it insists.

A memoryless policy that is misled in one state, for example in front of an object the recogniser does not believe
in, comes back to it for ever. The paper names a memory of what was visited as future work; this is the least
of one (`VisitMemory` counts). A search that never comes back is not changed by it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


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
