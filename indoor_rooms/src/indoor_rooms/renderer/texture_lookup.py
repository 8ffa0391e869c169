"""Reading textures at many points at once: all mip levels of all textures lie in one array."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

SMALLEST_LEVEL = 4


class TextureAtlas:
    """Mip-mapped, wrapping, bilinearly filtered textures.

    Args:
        textures: (H, W, 3) linear RGB images, row 0 at v = 1.
    """

    def __init__(self, textures: Sequence[NDArray[np.float32]]) -> None:
        texels: list[NDArray[np.float16]] = []
        starts: list[list[int]] = []
        heights: list[list[int]] = []
        widths: list[list[int]] = []
        levels: list[int] = []
        count = 0
        for texture in textures:
            pyramid = _pyramid(texture)
            levels.append(len(pyramid))
            starts.append([])
            heights.append([])
            widths.append([])
            for level in pyramid:
                starts[-1].append(count)
                heights[-1].append(level.shape[0])
                widths[-1].append(level.shape[1])
                # Half precision: a quarter of a gigabyte instead of half of one for thirty textures.
                texels.append(level[::-1].reshape(-1, 3).astype(np.float16))
                count += level.shape[0] * level.shape[1]
        deepest = max(levels, default=0)
        self._texels = np.concatenate(texels) if texels else np.zeros((0, 3), np.float16)
        # One row for each level of each texture.
        self._start = _table(starts, deepest)
        self._height = _table(heights, deepest)
        self._width = _table(widths, deepest)
        self._longest = np.maximum(self._height, self._width).astype(np.float32)
        self._levels = np.array(levels, np.int32)
        self._deepest = deepest

    def sample(
        self, texture: NDArray[np.int64], uv: NDArray[np.float32], footprint: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Colours at texture coordinates.

        Args:
            texture: (N,) index of the texture.
            uv: (N, 2) coordinates, wrapping at 1.
            footprint: (N,) width of what one sample stands for, in uv units; chooses the mip level, rounded down.

        Returns:
            (N, 3) float32 linear RGB.
        """
        first = texture * self._deepest
        texels_wide = footprint * np.take(self._longest, first)
        # The exponent of a float is its logarithm rounded down.
        level = np.frexp(np.maximum(texels_wide, np.float32(1)))[1] - 1
        row_of_table = first + np.minimum(level, np.take(self._levels, texture) - 1)
        start = np.take(self._start, row_of_table)
        height, width = np.take(self._height, row_of_table), np.take(self._width, row_of_table)
        (left, right), right_share = _neighbours(uv[:, 0], width)
        (low, high), high_share = _neighbours(uv[:, 1], height)
        low, high = start + low * width, start + high * width
        colour = np.zeros((3, len(texture)), np.float32)
        for row, row_share in ((low, 1 - high_share), (high, high_share)):
            for column, column_share in ((left, 1 - right_share), (right, right_share)):
                share = row_share * column_share
                texel = np.take(self._texels, row + column, axis=0).astype(np.float32)
                for channel, value in zip(colour, texel.T, strict=True):
                    channel += value * share
        return colour.T


def _neighbours(
    coordinate: NDArray[np.float32], size: NDArray[np.int32]
) -> tuple[tuple[NDArray[np.int32], NDArray[np.int32]], NDArray[np.float32]]:
    """The two texels on either side of a wrapping coordinate, and the share of the second."""
    place = (coordinate - np.floor(coordinate)) * size.astype(np.float32) + np.float32(0.5)
    # One too large until here, so that casting rounds down.
    after = place.astype(np.int32)
    share = place - after.astype(np.float32)
    before = after - 1
    before[before < 0] += size[before < 0]
    after[after >= size] -= size[after >= size]
    return (before, after), share


def _pyramid(texture: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    levels = [np.asarray(texture, np.float32)]
    while min(levels[-1].shape[:2]) > SMALLEST_LEVEL:
        height, width = (side // 2 for side in levels[-1].shape[:2])
        even = levels[-1][: 2 * height, : 2 * width]
        levels.append(even.reshape(height, 2, width, 2, 3).mean(axis=(1, 3)))
    return levels


def _table(rows: list[list[int]], columns: int) -> NDArray[np.int32]:
    table = np.zeros((len(rows), columns), np.int32)
    for index, row in enumerate(rows):
        table[index, : len(row)] = row
    return table.ravel()
