"""From which similarity on a picture is taken for one of a known target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from active_perceiver.experiments.likeness import known_similarity


@dataclass
class Seen:
    """What `known_similarity` reads of sightings."""

    target_codes: np.ndarray
    trained: int


def codes(*degrees: float) -> np.ndarray:
    """Unit vectors in these directions, as float32."""
    angles = np.radians(degrees)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1).astype(np.float32)


def cosine(degrees: float) -> float:
    return float(np.cos(np.radians(degrees)))


def test_it_lies_between_the_own_and_the_others() -> None:
    seen = Seen(np.stack([codes(0, 10), codes(100, 105)]), 2)
    own, others = cosine(10), cosine(90)  # 10 and 100 degrees
    assert known_similarity([seen], [codes()]) == pytest.approx(others + (own - others) / 3, abs=1e-5)
    stranger = cosine(50)  # 60 and 10 degrees; 40 from 100
    expected = max(stranger, cosine(40))
    assert known_similarity([seen], [codes(60)]) == pytest.approx(expected + (own - expected) / 3, abs=1e-5)


def test_the_pictures_held_out_do_not_count() -> None:
    with_held_out = Seen(np.stack([codes(0, 10, 170), codes(100, 105, 5)]), 2)
    without = Seen(np.stack([codes(0, 10), codes(100, 105)]), 2)
    assert known_similarity([with_held_out], [codes()]) == known_similarity([without], [codes()])


def test_alone_or_not_to_be_told_apart() -> None:
    alone = Seen(codes(0, 20)[None], 2)
    assert known_similarity([alone], [codes()]) == pytest.approx(0.97 * cosine(20), abs=1e-5)
    mixed = Seen(np.stack([codes(0, 40), codes(1, 41)]), 2)
    assert known_similarity([mixed], [codes()]) == pytest.approx(0.97 * cosine(40), abs=1e-5)
    single = Seen(codes(0)[None], 1)
    assert known_similarity([single], [codes()]) == pytest.approx(0.97)
