"""When found is said: the rules one by one, and that the page that lists them lists what is."""

import importlib
import itertools
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.agent import found_criterion
from active_perceiver.agent.found_criterion import AREA_MARGIN, FoundCriterion, says_found, stop_area_threshold

HOLDERS = (
    "agent.found_criterion",
    "agent.controller",
    "agent.exploration.explorer",
    "agent.exploration.triangulation",
    "evaluation.view_selection",
)


def test_the_constants_in_its_docstring_are_those_of_the_code():
    values = {}
    for name in HOLDERS:
        values |= vars(importlib.import_module(f"active_perceiver.{name}"))
    listed = re.findall(r"([A-Z_]{4,}) =\s+([0-9]+(?:[.][0-9]+)?)", found_criterion.__doc__)
    assert {name for name, _ in listed} >= {"OPEN_SET_SCORE", "AREA_MARGIN", "REVISIT_LIMIT", "SURE", "FOUND_MARGIN"}
    assert {name: float(value) for name, value in listed} == {name: values[name] for name, _ in listed}


def test_one_view_is_enough_unless_told_to_confirm_or_exploring():
    for confirm, exploring, nearly_before in itertools.product((False, True), repeat=3):
        rules = {"confirm": confirm, "exploring": exploring, "settled": False}
        assert says_found(True, nearly_before, **rules) == (nearly_before or not (confirm or exploring))
        assert not says_found(False, nearly_before, **rules)


@pytest.mark.parametrize("exploring", [False, True])
def test_a_search_that_has_settled_ends_if_it_explores(exploring):
    assert says_found(False, False, confirm=True, exploring=exploring, settled=True) == exploring


@given(score=st.floats(0, 1), area=st.floats(0, 1), least=st.floats(0, 1), smallest=st.floats(0, 1))
def test_what_is_enough_is_nearly_enough_and_more_is_enough_too(score, area, least, smallest):
    criterion = FoundCriterion(least, smallest)
    assert criterion.met(score, area) == (score >= least and area >= smallest)
    assert criterion.nearly_met(score, area) or not criterion.met(score, area)
    assert criterion.nearly_met(score, area) == criterion.met(score, 2 * area)


@pytest.mark.parametrize(
    ("own", "expected"),
    [([0.3, 0.25, 0.4], 0.2), ([0.19, 0.15, 0.4], 0.15), ([0.01, 0.3, 0.3], 0.12), ([0.0, 0.0, 0.0], 0.12)],
)
def test_found_area_is_the_smallest_own_box_at_a_goal_within_limits(own, expected):
    areas = np.array([0.2, 0.3, 0.25, 0.05])
    goals = np.array([True, True, True, False])
    side = np.sqrt(np.array([*own, 0.9]))
    boxes = np.stack([np.full(4, 0.5), np.full(4, 0.5), side, side], 1)[:, None]
    scores = (side > 0).astype(float)[:, None]
    assert stop_area_threshold(scores, boxes, areas, goals, 0.5) == pytest.approx(AREA_MARGIN * expected)
