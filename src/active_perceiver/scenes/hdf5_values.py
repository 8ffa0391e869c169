"""Reading values from an HDF5 file that was opened by `open_hdf5`, no more than fits into memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from active_perceiver.scenes.hdf5 import MAX_OBJECTS
from active_perceiver.scenes.scene import SceneError

if TYPE_CHECKING:
    import h5py

MAX_WHOLE = 256_000_000
"""Bytes of a dataset that is read at once: boxes of 16 targets in a million views. Larger ones are read in parts."""
MAX_ATTRIBUTE = 1_000_000
"""Bytes of an attribute."""
# No filter of HDF5 makes data smaller than by this, deflate's limit; smaller datasets than so many bytes do no harm.
_LARGEST_RATIO, _HARMLESS = 1100, 1_000_000


@dataclass
class MemoryBudget:
    """What may still be read of a file that is kept in memory, which could name the same data many times.

    Attributes:
        size: of the file in bytes.
        left: bytes.
    """

    size: int
    left: int

    @classmethod
    def of(cls, size: int) -> MemoryBudget:
        """What a file of so many bytes may fill: its size, and a little for what is packed."""
        return cls(size, size + 2 * MAX_WHOLE)

    def take(self, count: int) -> None:
        """Note that so many bytes were read, or will be.

        Raises:
            SceneError: if they are too many.
        """
        self.left -= count
        if self.left < 0:
            raise SceneError(f"it unpacks to far more than its {self.size / 1e6:.1f} MB; copy it again")


def read_whole(dataset: h5py.Dataset, before: str = "", budget: MemoryBudget | None = None) -> Any:
    """All of a dataset, as h5py gives it.

    Args:
        dataset: what to read.
        before: what the error begins with.
        budget: of what is kept.

    Raises:
        SceneError: if that is more than `MAX_WHOLE` or the budget allows, or not in the file.
    """
    check_stored(dataset, before)
    if dataset.nbytes > MAX_WHOLE:
        raise SceneError(
            f"{before}'{_name(dataset)}' has {dataset.nbytes / 1e6:.0f} MB, more than {MAX_WHOLE / 1e6:.0f} that are "
            "read at once; split the scene"
        )
    if budget is not None:
        budget.take(dataset.nbytes)
    return dataset[()]


def read_blobs(dataset: h5py.Dataset, budget: MemoryBudget) -> tuple[bytes, ...]:
    """All values of a dataset of bytes of varying length, (N,) of uint8.

    Raises:
        SceneError: if they are more than the budget allows.
    """
    if len(dataset) > MAX_OBJECTS:
        raise SceneError(f"'{_name(dataset)}' has more than {MAX_OBJECTS} values; split the scene")
    # How long a value is, is known only when it is read; a few at a time then need no more than that.
    rows = max(1, MAX_WHOLE // max(1, budget.size))
    blobs: list[bytes] = []
    for start in range(0, len(dataset), rows):
        blobs += [blob.tobytes() for blob in dataset[start : start + rows]]
        budget.take(sum(len(blob) for blob in blobs[start:]))
    return tuple(blobs)


def read_attribute(holder: h5py.HLObject, name: str) -> Any:
    """The value of an attribute: a text or a number.

    Raises:
        KeyError: if it is not there.
        SceneError: if it is a list, or too long.
    """
    stored = holder.attrs.get_id(name)
    count = 1
    for side in stored.shape or ():
        count *= side
    if count > 16 or stored.get_storage_size() > MAX_ATTRIBUTE:
        raise SceneError(f"attribute '{name}' is a list of {stored.shape}, expected a single value")
    return holder.attrs[name]


def check_stored(dataset: h5py.Dataset, before: str = "") -> None:
    """Make sure that a dataset is not said to be far larger than what the file has of it.

    Args:
        dataset: what will be read.
        before: what the error begins with.

    Raises:
        SceneError: if it is.
    """
    if dataset.nbytes > _HARMLESS and dataset.nbytes > _LARGEST_RATIO * dataset.id.get_storage_size():
        raise SceneError(
            f"{before}'{_name(dataset)}' should have shape {dataset.shape}, but most of it is not in the file; "
            "copy it again"
        )


def _name(dataset: h5py.Dataset) -> str:
    return str(dataset.name).lstrip("/")
