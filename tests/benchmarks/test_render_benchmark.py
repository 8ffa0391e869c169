"""The timing of the renderer: complete, plausible, and naming functions that are there."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from typing import Any

import pytest

from active_perceiver.benchmarks.render.measure import STAGES, measure_rendering
from active_perceiver.benchmarks.render.report import format_timing
from active_perceiver.capture.rendered.config import CaptureConfig
from box_room import box_room
from indoor_rooms.renderer import compiled
from indoor_rooms.room import Room

LIGHT = CaptureConfig(bake_rays=4, bounces=1)


def slow_room() -> Room:
    time.sleep(0.05)
    return box_room()


@pytest.fixture(scope="module")
def measured() -> tuple[dict[str, Any], list[tuple[int, int]]]:
    robot_moved = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "MAX_TRIANGLES", 3000)
        result = measure_rendering(
            slow_room,
            views=3,
            image_size=32,
            settings=LIGHT,
            progress=lambda done, total, note="": robot_moved.append((done, total)),
        )
    return result, robot_moved


def test_all_that_was_asked_is_measured(measured: tuple[dict[str, Any], list[tuple[int, int]]]) -> None:
    result, robot_moved = measured
    assert json.loads(json.dumps(result)) == result
    assert (result["name"], result["views"], result["image_size"], result["lamps"]) == ("test-1", 3, 32, 1)
    # Sleeping takes time, but not the processor's.
    assert result["room"]["wall"] >= 0.05 > result["room"]["cpu"]
    assert result["light"]["cpu"] > 0
    view = result["view"]
    assert 0 < view["median"] <= view["worst"]
    assert view["per_second"] == pytest.approx(1 / view["median"])
    assert result["target picture"]["cpu"] > 0
    assert result["peak_memory_gib"] is None or 0.01 < result["peak_memory_gib"] < 100
    assert robot_moved[-1] == (len(robot_moved), len(robot_moved))


def test_stages_are_functions_of_the_renderer_and_fill_the_view(
    measured: tuple[dict[str, Any], list[tuple[int, int]]],
) -> None:
    for functions in STAGES.values():
        for module, name in functions:
            assert callable(getattr(module, name))
    stages = measured[0]["view"]["stages"]
    assert sum(stages.values()) == pytest.approx(1)
    assert set(STAGES) < set(stages)
    # Tone mapping 32 x 32 pixels takes less than the clock's tick on some machines.
    assert all(share > 0 for stage, share in stages.items() if stage != "tone mapping")


def test_table_shows_the_figures(measured: tuple[dict[str, Any], list[tuple[int, int]]]) -> None:
    result, _ = measured
    table = format_timing(result)
    assert f"{result['view']['median']:.3f}" in table
    assert "denoising" in table
    assert "target picture" in table
    without = format_timing({**result, "target picture": None, "peak_memory_gib": None})
    assert "target picture" not in without
    assert "memory" not in without


def test_a_room_without_targets_and_no_views_at_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "MAX_TRIANGLES", 3000)
    bare = measure_rendering(lambda: replace(box_room(), targets={}), views=1, image_size=16, settings=LIGHT)
    assert bare["target picture"] is None
    with pytest.raises(ValueError, match="at least one view"):
        measure_rendering(box_room, views=0)
