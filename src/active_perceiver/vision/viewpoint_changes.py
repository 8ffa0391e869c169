"""What a camera near by would have seen: an image as from a pose that is a little off. Pure functions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

# For each degree that a robot is turned away it is also so much nearer or farther, as a share of the distance of what
# it sees, and its camera tilted and rolled by so many degrees: 8 degrees go with a hand's breadth in a room.
NEARER, TILTED, ROLLED = 0.012, 0.3, 0.15


def from_nearby(image: NDArray[np.uint8], rng: np.random.Generator, degrees: float, fov: float) -> NDArray[np.uint8]:
    """An image as from another pose near by.

    Turning is exact. Standing elsewhere is not, for nothing is known of how far things are: the image grows or
    shrinks. What the camera did not see is what it saw, mirrored at the edge.

    Args:
        image: (H, W, 3) uint8 RGB, square.
        rng: draws the pose.
        degrees: it looks up to so much aside, 0..45.
        fov: field of view in degrees.
    """
    turn, tilt, roll = rng.uniform(-1, 1, 3) * degrees * (1.0, TILTED, ROLLED)
    return turned(image, float(turn), float(tilt), float(roll), float(1 + NEARER * degrees * rng.uniform(-1, 1)), fov)


def turned(
    image: NDArray[np.uint8], turn: float, tilt: float, roll: float, zoom: float, fov: float
) -> NDArray[np.uint8]:
    """An image as from a camera that is turned where it is.

    Args:
        image: (H, W, 3) uint8 RGB, square.
        turn: degrees to the right.
        tilt: degrees up.
        roll: degrees clockwise.
        zoom: how much larger everything is.
        fov: field of view in degrees.
    """
    height, width = image.shape[:2]
    reach = math.tan(math.radians(fov) / 2)
    across = (np.arange(width) + 0.5) / width * 2 - 1
    down = (np.arange(height) + 0.5) / height * 2 - 1
    rays = np.stack([*np.meshgrid(across * reach / zoom, down * reach / zoom), np.ones((height, width))])
    x, y, ahead = np.tensordot(_rotation(turn, tilt, roll), rays, axes=1)
    places = [(y / ahead / reach + 1) / 2 * height - 0.5, (x / ahead / reach + 1) / 2 * width - 0.5]
    layers = [map_coordinates(image[..., layer], places, np.float32, order=1, mode="mirror") for layer in range(3)]
    return np.clip(np.rint(np.stack(layers, axis=-1)), 0, 255).astype(np.uint8)


def _rotation(turn: float, tilt: float, roll: float) -> NDArray[np.float64]:
    """From a camera's rays (x right, y down, z ahead) to those of the one that it was."""
    (ct, st), (cu, su), (cr, sr) = (
        (math.cos(angle), math.sin(angle)) for angle in (math.radians(turn), math.radians(tilt), math.radians(roll))
    )
    about_y = np.array([[ct, 0, st], [0, 1, 0], [-st, 0, ct]])
    about_x = np.array([[1, 0, 0], [0, cu, -su], [0, su, cu]])
    about_z = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return about_y @ about_x @ about_z
