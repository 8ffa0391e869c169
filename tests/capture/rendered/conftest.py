"""Fixtures that several of these tests share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from active_perceiver.parallel.executor import SerialExecutor
from active_perceiver.parallel.process_pool import ProcessExecutor
from indoor_rooms.renderer import compiled


@pytest.fixture(scope="module")
def small_work() -> Iterator[pytest.MonkeyPatch]:
    """Few triangles and no processes: work is done where it can be watched. Yields what else may patch the module."""

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "MAX_TRIANGLES", 2000)
        patch.setattr(ProcessExecutor, "map", lambda _, *work: SerialExecutor().map(*work))
        yield patch
