"""Angles as turns, the shorter way round."""

import math

import numpy as np
import pytest

from active_perceiver.scenes.angles import signed_angle


@pytest.mark.parametrize(
    ("degrees", "same"), [(0, 0), (179, 179), (180, -180), (181, -179), (-180, -180), (359, -1), (-725, -5)]
)
def test_the_same_angle_the_shorter_way_round(degrees, same):
    assert signed_angle(degrees) == same
    np.testing.assert_array_equal(signed_angle(np.array([[degrees, degrees + 360.0]])), [[same, same]])


def test_what_is_no_angle_stays_none():
    assert math.isnan(signed_angle(math.nan))
    assert np.isnan(signed_angle(np.array([1.0, np.nan]))).tolist() == [False, True]
