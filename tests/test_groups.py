"""Tests in one xdist group run on one worker, or what they share is made by each of them."""

from __future__ import annotations

import pytest


@pytest.mark.xdist_group("groups")
def test_groups_are_kept_together(request: pytest.FixtureRequest) -> None:
    """The scheduler knows groups by the ends of the tests' names; with pytest 9.2 they are silently missing."""
    if not getattr(request.config.option, "loadgroup", False):
        pytest.skip("the tests are not distributed by groups")
    assert request.node.nodeid.endswith("@groups")
