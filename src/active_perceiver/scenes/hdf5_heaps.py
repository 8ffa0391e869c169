"""Values of varying length in an HDF5 file, which its library would read for ever if they are damaged."""

from __future__ import annotations

import mmap
import struct
from pathlib import Path

from active_perceiver.scenes.scene import SceneError

# A collection of the global heap, which holds values of varying length, begins with its mark, version, three unused
# bytes and size; each value with its number, count, four unused bytes and size. See "Disk Format: Level 1E" of
# https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html.
_COLLECTION = struct.Struct("<4sB3xQ")
_VALUE = struct.Struct("<HH4xQ")
_MARK = b"GCOL\x01"


def check_heaps(path: Path) -> None:
    """Make sure that the values of varying length in a file follow one another.

    Where a size is zero, HDF5's library comes to the same place again and again.

    Raises:
        SceneError: if they do not.
    """
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        start = data.find(_MARK)
        while start >= 0:
            end = start + 1
            if start % 8 == 0:
                end = _end_of_collection(data, start)
            start = data.find(_MARK, end)


def _end_of_collection(data: mmap.mmap, start: int) -> int:
    broken = SceneError(f"the values of varying length at byte {start} do not follow one another; copy it again")
    if start + _COLLECTION.size > len(data):
        raise broken
    size = _COLLECTION.unpack_from(data, start)[2]
    end, place = start + size, start + _COLLECTION.size
    if not place <= end <= len(data):
        raise broken
    while end - place >= _VALUE.size:
        number, _, length = _VALUE.unpack_from(data, place)
        # The number 0 is what is left: its length includes its head.
        place += (length if number == 0 else _VALUE.size + length) + 7 & ~7
        if place > end or (number == 0 and length == 0):
            raise broken
    return end
