"""Flattening a policy where a search has been before."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.agent.loop_escape import escape_loop
from active_perceiver.utils.linalg import unit_vectors

weights = st.lists(st.floats(1e-6, 1), min_size=2, max_size=8)


@given(weights, st.integers(0, 50))
def test_it_stays_a_distribution_in_the_same_order_but_flatter(raw, looks):
    before = np.array(raw) / np.sum(raw)
    after = escape_loop(before, looks)
    assert after.sum() == pytest.approx(1)
    assert (np.diff(after[np.argsort(before)]) >= -1e-12).all()
    assert after.max() <= before.max() + 1e-12


@given(weights)
def test_the_first_look_changes_nothing(raw):
    before = np.array(raw) / np.sum(raw)
    np.testing.assert_allclose(escape_loop(before, 0), before)


def test_it_works_on_batches():
    table = np.array([[0.9, 0.1], [0.9, 0.1]])
    np.testing.assert_allclose(escape_loop(table, np.array([0, 1])), [[0.9, 0.1], [0.75, 0.25]])


def test_unit_vectors_survive_zeros():
    assert np.isfinite(unit_vectors(np.zeros((2, 3), np.float32))).all()
