"""Angles that begin again after a whole turn."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Degrees = TypeVar("Degrees", float, NDArray[np.float64], NDArray[np.floating])


def signed_angle(degrees: Degrees) -> Degrees:
    """The same angles, of a number or an array, from -180 to below 180: as a turn, the shorter way round."""
    return (degrees + 180.0) % 360.0 - 180.0
