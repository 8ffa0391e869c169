"""A cheap camera's faults: none is none, each does what it says, all follow from the seed."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from indoor_rooms.renderer.camera_faults import LARGEST, CameraFaultError, CameraFaults, view_rng, with_faults

NONE = {field.name: 0.0 for field in fields(CameraFaults)}
SHAPE = st.tuples(st.integers(1, 12), st.integers(1, 12), st.just(3))
ANY_FAULTS = st.fixed_dictionaries({name: st.floats(0, largest) for name, largest in LARGEST.items()})
GREY = np.full((60, 60, 3), 128, np.uint8)


@given(arrays(np.uint8, SHAPE), st.integers(0, 9))
def test_a_perfect_camera_changes_nothing(image: np.ndarray, seed: int) -> None:
    np.testing.assert_array_equal(with_faults(image, CameraFaults(**NONE), np.random.default_rng(seed)), image)


@given(
    arrays(np.uint8, SHAPE),
    st.integers(0, 9),
    st.fixed_dictionaries({k: st.floats(0, v) for k, v in LARGEST.items()}),
)
def test_whatever_the_faults_it_stays_a_picture(image: np.ndarray, seed: int, values: dict[str, float]) -> None:
    before = image.copy()
    one, two = (with_faults(image, CameraFaults(**values), np.random.default_rng(seed)) for _ in range(2))
    assert (one.shape, one.dtype) == (image.shape, np.uint8)
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(image, before)


@given(st.integers(0, 10_000))
def test_the_mean_stays_in_the_range_of_the_exposure(seed: int) -> None:
    faults = CameraFaults()
    mean = with_faults(GREY, faults, np.random.default_rng(seed)).mean()
    # sRGB is nearly a power of 2.2: a stop is a factor of 2 ** (1 / 2.2); white balance and vignette do the rest.
    low, high = (128 * 2 ** (stops / 2.2) for stops in (-faults.exposure - 0.25, faults.exposure + 0.15))
    assert low < mean < high


def test_each_fault_does_what_it_says() -> None:
    def one(**fault: float) -> np.ndarray:
        return with_faults(GREY, CameraFaults(**{**NONE, **fault}), np.random.default_rng(3)).astype(float)

    assert np.ptp(one(exposure=1.0)) == 0
    assert one(exposure=1.0)[0, 0, 0] != 128
    tinted = one(white_balance=0.3)
    assert len(set(tinted[0, 0])) == 3
    assert tinted[0, 0, 1] == 128
    dark = one(vignette=0.5)
    assert dark[0, 0, 0] < dark[30, 30, 0] - 20
    assert one(noise=0.05).std() == pytest.approx(6.5, rel=0.3)
    assert abs(one(noise=0.05).mean() - 128) < 1
    edge = np.zeros((20, 20, 3), np.uint8)
    edge[:, 10:] = 255
    blurred = with_faults(edge, CameraFaults(**{**NONE, "blur": 1.0}), np.random.default_rng(0))
    assert 0 < blurred[5, 9, 0] < blurred[5, 10, 0] < 255
    assert blurred[5, 2, 0] == 0


def test_views_differ_and_follow_from_seed_and_pose() -> None:
    def view(seed: int, *pose: float) -> np.ndarray:
        return with_faults(GREY, CameraFaults(), view_rng(seed, pose))

    np.testing.assert_array_equal(view(1, 0.5, 1.0, 90.0, -25.0), view(1, 0.5, 1.0, 90.0, -25.0))
    others = [view(2, 0.5, 1.0, 90.0, -25.0), view(1, 1.0, 1.0, 90.0, -25.0), view(1, 0.5, 1.0, 90.0, 0.0)]
    assert all((other != view(1, 0.5, 1.0, 90.0, -25.0)).any() for other in others)


@pytest.mark.parametrize("name", LARGEST)
@pytest.mark.parametrize("value", [-0.01, float("nan"), float("inf")])
def test_impossible_faults_are_named(name: str, value: float) -> None:
    with pytest.raises(CameraFaultError, match=f"the camera's {name} must be"):
        CameraFaults(**{name: value})
