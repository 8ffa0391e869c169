from __future__ import annotations

import numpy as np
import pytest

from active_perceiver.vision.image_changes import (
    blurred,
    compressed,
    exposed,
    motion_blurred,
    photometric,
    pixel_noise,
)

RNG = np.random.default_rng(0)
PICTURE = np.kron(RNG.integers(30, 220, (12, 12, 3)), np.ones((8, 8, 1))).astype(np.uint8)


def test_noise_has_its_strength():
    flat = np.full((200, 200, 3), 128, np.uint8)
    noisy = pixel_noise(flat, np.random.default_rng(0), 10.0).astype(float)
    assert noisy.std() == pytest.approx(10.0, rel=0.03)
    assert noisy.mean() == pytest.approx(128.0, abs=0.2)


def test_blurs_keep_the_mean_and_take_the_edges_away():
    def edges(image):
        return np.abs(np.diff(image.astype(float), axis=1)).max()

    for change in (lambda image: blurred(image, RNG, 2.0), lambda image: motion_blurred(image, RNG, 9)):
        changed = change(PICTURE)
        assert changed.astype(float).mean() == pytest.approx(PICTURE.astype(float).mean(), rel=0.02)
        assert edges(changed) < 0.6 * edges(PICTURE)


def test_exposure_multiplies_light():
    grey = np.full((4, 4, 3), 100, np.uint8)
    brighter = exposed(grey, RNG, (2.0, 1.0, 0.5))[0, 0]
    assert ((brighter / 100.0) ** 2.2).tolist() == pytest.approx([2.0, 1.0, 0.5], rel=0.03)
    assert exposed(np.full((1, 1, 3), 250, np.uint8), RNG, (4.0, 4.0, 4.0)).max() == 255


def test_jpeg_changes_a_little():
    difference = np.abs(compressed(PICTURE, RNG, 20).astype(int) - PICTURE)
    assert 0 < difference.mean() < 15


def test_photometric_changes_by_chance_and_gives_images():
    images = [photometric(PICTURE, np.random.default_rng(seed)) for seed in range(40)]
    assert all(image.shape == PICTURE.shape and image.dtype == np.uint8 for image in images)
    assert (photometric(PICTURE, np.random.default_rng(7)) == images[7]).all()
    differences = [np.abs(image.astype(int) - PICTURE).mean() for image in images]
    assert min(differences) < 3.0  # some are nearly as they were
    assert max(differences) > 25.0
