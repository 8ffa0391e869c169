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
        self._start = _table(starts, deepest)
        self._height = _table(heights, deepest)
        self._width = _table(widths, deepest)
        self._levels = np.array(levels, np.int64)

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
        texels_wide = footprint * np.maximum(self._height[texture, 0], self._width[texture, 0])
        level = np.floor(np.log2(np.maximum(texels_wide, 1.0))).astype(np.int64)
        level = np.minimum(level, self._levels[texture] - 1)
        start = self._start[texture, level]
        height, width = self._height[texture, level], self._width[texture, level]
        x = (uv[:, 0] - np.floor(uv[:, 0])) * width - 0.5
        y = (uv[:, 1] - np.floor(uv[:, 1])) * height - 0.5
        left, low = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        right_share, high_share = (x - left).astype(np.float32), (y - low).astype(np.float32)
        right, high = (left + 1) % width, (low + 1) % height
        left, low = left % width, low % height
        colour = np.zeros((len(texture), 3), np.float32)
        for row, row_share in ((low, 1 - high_share), (high, high_share)):
            for column, column_share in ((left, 1 - right_share), (right, right_share)):
                texel = np.take(self._texels, start + row * width + column, axis=0).astype(np.float32)
                colour += texel * (row_share * column_share)[:, None]
        return colour


def _pyramid(texture: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    levels = [np.asarray(texture, np.float32)]
    while min(levels[-1].shape[:2]) > SMALLEST_LEVEL:
        height, width = (side // 2 for side in levels[-1].shape[:2])
        even = levels[-1][: 2 * height, : 2 * width]
        levels.append(even.reshape(height, 2, width, 2, 3).mean(axis=(1, 3)))
    return levels


def _table(rows: list[list[int]], columns: int) -> NDArray[np.int64]:
    table = np.zeros((len(rows), columns), np.int64)
    for index, row in enumerate(rows):
        table[index, : len(row)] = row
    return table
