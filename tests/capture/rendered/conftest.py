"""Fixtures that several of these tests share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from active_perceiver.capture.rendered import kept_work
from indoor_rooms.renderer import compiled


@pytest.fixture(scope="module")
def small_work() -> Iterator[pytest.MonkeyPatch]:
    """Few triangles and no processes: work is done where it can be watched. Yields what else may patch the module."""

    def run_here(work, shared, jobs, workers, progress):  # type: ignore[no-untyped-def]
        for number, job in enumerate(jobs, 1):
            work(shared, job)
            progress(number, len(jobs))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "MAX_TRIANGLES", 2000)
        patch.setattr(kept_work, "run_parallel", run_here)
        yield patch
