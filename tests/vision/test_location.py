"""The location mask, against a loop over cells."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from active_perceiver.envs import location_mask

boxes = hnp.arrays(np.float64, st.tuples(st.integers(0, 4), st.just(4)), elements=st.floats(-0.2, 1.2))


def slow_mask(box):
    mask = np.zeros((5, 5), np.float32)
    x, y, width, height = box
    for row in range(5):
        for column in range(5):
            across = min(x + width / 2, (column + 1) / 5) - max(x - width / 2, column / 5)
            down = min(y + height / 2, (row + 1) / 5) - max(y - height / 2, row / 5)
            mask[row, column] = across > 0 and down > 0
    return mask.ravel()


@settings(max_examples=200, deadline=None)
@given(boxes)
def test_equals_a_loop_over_cells(some):
    expected = np.array([slow_mask(box) for box in some]).reshape(-1, 25)
    np.testing.assert_array_equal(location_mask(some), expected)


@pytest.mark.parametrize(
    ("box", "cells"),
    [
        ((0.5, 0.5, 1.0, 1.0), list(range(25))),
        ((0.1, 0.1, 0.2, 0.2), [0]),
        ((0.5, 0.1, 0.1, 0.1), [2]),
        ((0.1, 0.9, 0.1, 0.1), [20]),
        ((0.4, 0.1, 0.1, 0.1), [1, 2]),
        ((0.5, 0.5, 0.0, 0.0), []),
        ((np.nan, np.nan, np.nan, np.nan), []),
    ],
)
def test_cells_of_known_boxes(box, cells):
    assert np.flatnonzero(location_mask(box)).tolist() == cells


def test_any_leading_shape():
    some = np.random.default_rng(0).random((2, 3, 4, 4))
    some[0, 0] = np.nan
    mask = location_mask(some)
    assert mask.shape == (2, 3, 4, 25)
    assert mask.dtype == np.float32
    np.testing.assert_array_equal(mask[1, 2, 3], slow_mask(some[1, 2, 3]))


def test_refuses_other_shapes():
    with pytest.raises(ValueError, match="last axis of 4"):
        location_mask(np.zeros((3, 5)))
