"""From which similarity on a picture is taken for one of a known target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from active_perceiver.training.match_threshold import match_threshold


@dataclass
class Seen:
    """What `match_threshold` reads of sightings."""

    target_embeddings: np.ndarray
    trained: int


def embeddings(*degrees: float) -> np.ndarray:
    """Unit vectors in these directions, as float32."""
    angles = np.radians(degrees)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1).astype(np.float32)


def cosine(degrees: float) -> float:
    return float(np.cos(np.radians(degrees)))


def test_it_lies_between_the_own_and_the_others() -> None:
    seen = Seen(np.stack([embeddings(0, 10), embeddings(100, 105)]), 2)
    own, others = cosine(10), cosine(90)  # 10 and 100 degrees
    assert match_threshold([seen], [embeddings()]) == pytest.approx(others + (own - others) / 3, abs=1e-5)
    stranger = cosine(50)  # 60 and 10 degrees; 40 from 100
    expected = max(stranger, cosine(40))
    assert match_threshold([seen], [embeddings(60)]) == pytest.approx(expected + (own - expected) / 3, abs=1e-5)


def test_the_pictures_held_out_do_not_count() -> None:
    with_held_out = Seen(np.stack([embeddings(0, 10, 170), embeddings(100, 105, 5)]), 2)
    without = Seen(np.stack([embeddings(0, 10), embeddings(100, 105)]), 2)
    assert match_threshold([with_held_out], [embeddings()]) == match_threshold([without], [embeddings()])


def test_alone_or_not_to_be_told_apart() -> None:
    alone = Seen(embeddings(0, 20)[None], 2)
    assert match_threshold([alone], [embeddings()]) == pytest.approx(0.97 * cosine(20), abs=1e-5)
    mixed = Seen(np.stack([embeddings(0, 40), embeddings(1, 41)]), 2)
    assert match_threshold([mixed], [embeddings()]) == pytest.approx(0.97 * cosine(40), abs=1e-5)
    single = Seen(embeddings(0)[None], 1)
    assert match_threshold([single], [embeddings()]) == pytest.approx(0.97)
