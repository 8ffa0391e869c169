from __future__ import annotations

import threading

import pytest

from active_perceiver.utils.prefetch import prefetch_batches


@pytest.mark.parametrize(("count", "sizes"), [(0, []), (1, [1]), (4, [4]), (9, [4, 4, 1])])
def test_all_items_come_in_order(count, sizes):
    batches = list(prefetch_batches(range(count), 4))
    assert [len(batch) for batch in batches] == sizes
    assert [item for batch in batches for item in batch] == list(range(count))


def test_the_next_batch_is_made_while_one_is_used():
    made = threading.Event()

    def items():
        yield "first"
        made.set()
        yield "second"

    for batch in prefetch_batches(items(), 1):
        assert made.wait(timeout=10)
        assert batch in (["first"], ["second"])


def test_what_goes_wrong_is_said():
    def items():
        yield 1
        raise ValueError("the camera is broken")

    with pytest.raises(ValueError, match="camera is broken"):
        list(prefetch_batches(items(), 4))


def test_it_may_be_left_early():
    for _ in prefetch_batches(iter(range(1000)), 2):
        break
    assert threading.active_count() < 50
