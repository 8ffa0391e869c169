"""Named sections: heard while somebody listens, and not otherwise."""

from __future__ import annotations

import time

import pytest

from active_perceiver.utils.sections import listening, section


def test_a_section_is_heard_by_all_who_listen_and_by_nobody_else() -> None:
    first: list[tuple[str, float]] = []
    second: list[str] = []
    with section("before"):
        pass
    with listening(lambda name, seconds: first.append((name, seconds))):
        with section("slow"):
            time.sleep(0.01)
        with listening(lambda name, seconds: second.append(name)), section("outer"), section("inner"):
            pass
    with section("after"):
        pass
    assert [name for name, _ in first] == ["slow", "inner", "outer"]
    assert first[0][1] >= 0.01
    assert second == ["inner", "outer"]


def test_a_section_that_fails_is_heard_and_its_error_goes_on() -> None:
    heard: list[str] = []
    hear = listening(lambda name, seconds: heard.append(name))
    with pytest.raises(ValueError, match="the floor"), hear, section("walking"):
        raise ValueError("the floor gave way")
    assert heard == ["walking"]
    with section("afterwards"):  # the listener is gone
        pass
    assert heard == ["walking"]
