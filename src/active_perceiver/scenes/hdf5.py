"""The one place that opens HDF5 files: what could reach outside the file, crash or fill the memory is refused first.

A file may come from anybody. HDF5 lets it name other files to read from (external storage, external links, virtual
datasets), and its library trusts sizes and layouts that crash it. So every object is looked at before data is read.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from active_perceiver.errors import UserError
from active_perceiver.scenes.hdf5_heaps import check_heaps
from active_perceiver.scenes.scene import SceneError

if TYPE_CHECKING:
    import h5py

MAX_OBJECTS = 200_000
"""Groups, datasets and links of a file; offline AI2-THOR data has a dataset for each of some 20 000 views."""
MAX_CHUNK = 256_000_000
"""Bytes of a chunk, which is unpacked whole whatever is asked of it. h5py makes chunks of at most 1 MB."""
MAX_RATIO, HARMLESS_TOTAL = 100, 4_000_000_000
"""How many times its size a file may unpack to, once that is more than so many bytes, which take some ten seconds.
Pictures pack to a tenth. How much of it is in memory at a time is limited where values are read."""
FILTERS = {1: "gzip", 2: "shuffle", 3: "fletcher32", 4: "szip", 5: "nbit", 6: "scaleoffset", 32000: "lzf"}
"""What h5py unpacks by itself. Others are plug-ins, code that HDF5 would look for on this computer and run."""


def h5py_module() -> Any:
    """The library of scene files, imported when the first one is: a robot needs none, and is not asked to have it.

    Raises:
        SceneError: if it is not installed.
    """
    try:
        import h5py
    except ImportError:
        raise SceneError("scene files are read and written with h5py, which is not here: pip install h5py") from None
    return h5py


@contextmanager
def open_hdf5(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file to read from, none of whose objects leads out of it; whatever is broken ends in a sentence.

    It is not locked: some network disks cannot, and files of this software are replaced whole, never changed.

    Raises:
        SceneError: if the file is missing, is not HDF5, is refused (see `check_contents`) or cannot be read to the
            end, or if h5py is not installed.
    """
    h5py = h5py_module()
    if not path.is_file():
        raise SceneError(f"there is no file {path}")
    try:
        with h5py.File(path, "r", locking=False) as file:
            try:
                check_heaps(path)
                check_contents(file, path.stat().st_size)
            except SceneError as error:
                raise SceneError(f"{path}: {error}") from None
            yield file
    except UserError:
        raise
    # What h5py raises where a file is damaged depends on the place of the damage.
    except (OSError, RuntimeError, MemoryError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise SceneError(
            f"{path} is not a readable HDF5 file ({reason}); it may be truncated, copy it again"
        ) from None
    except (KeyError, ValueError, TypeError, AttributeError) as error:
        reason = " ".join(str(error).split())
        raise SceneError(f"{path} is damaged or not of this format: {reason:.200}") from None


@contextmanager
def create_hdf5(path: Path) -> Iterator[h5py.File]:
    """A new HDF5 file to write to, not locked either: it is a temporary one that nobody else knows."""
    with h5py_module().File(path, "w", locking=False) as file:
        yield file


@dataclass
class _Contents:
    """What was looked at of a file so far."""

    objects: int = 0
    unpacked: int = 0

    def count(self, objects: int) -> None:
        self.objects += objects
        if self.objects > MAX_OBJECTS:
            raise SceneError(f"it holds more than {MAX_OBJECTS} objects, which no scene needs; split it")


def check_contents(file: h5py.File, size: int) -> None:
    """Look at all links and datasets of a file, without reading data or following what leads out.

    Args:
        file: just opened.
        size: of the file in bytes.

    Raises:
        SceneError: if there is an external or broken link, external storage, a virtual dataset, a filter that h5py
            does not bring, a huge chunk, too many objects, or data packed so tightly that no picture can be.
    """
    h5py = h5py_module()
    contents, soft = _Contents(), []
    groups, seen = [("", file["/"].id)], {h5py.h5o.get_info(file["/"].id).addr}
    while groups:
        place, group = groups.pop()
        contents.count(len(group))
        for name in group:
            label = f"{place}/{name.decode('utf-8', 'replace')}"
            kind = group.links.get_info(name).type
            if kind == h5py.h5l.TYPE_SOFT:
                soft.append((label, group, name))
                continue
            if kind != h5py.h5l.TYPE_HARD:
                raise SceneError(
                    f"'{label.lstrip('/')}' is a link to another file, and nothing but the file itself is read; copy "
                    "what it leads to into the file (h5py: copy(..., expand_external=True))"
                )
            found = h5py.h5o.get_info(group, name)
            if found.addr in seen:
                continue
            seen.add(found.addr)
            if found.type == h5py.h5o.TYPE_GROUP:
                groups.append((label, h5py.h5g.open(group, name)))
            elif found.type == h5py.h5o.TYPE_DATASET:
                contents.unpacked += _checked_dataset(h5py.h5d.open(group, name), label.lstrip("/"))
    if contents.unpacked > max(HARMLESS_TOTAL, MAX_RATIO * size):
        raise SceneError(
            f"it unpacks to {contents.unpacked / 1e9:.1f} GB, more than {MAX_RATIO} times its size; write it again "
            "without what is empty"
        )
    # Only now, when no link leads to another file, may HDF5 follow those that name a place.
    for label, group, name in soft:
        try:
            h5py.h5o.get_info(group, name)
        except (KeyError, RuntimeError, OSError, ValueError):
            raise SceneError(
                f"'{label.lstrip('/')}' is a link that leads nowhere; remove it, or copy the file again"
            ) from None


def _checked_dataset(dataset: h5py.h5d.DatasetID, label: str) -> int:
    """Look at how a dataset is stored, before anything that lets HDF5 touch it; returns its bytes unpacked."""
    h5py = h5py_module()
    stored = dataset.get_create_plist()
    if stored.get_layout() == h5py.h5d.VIRTUAL:
        raise SceneError(
            f"'{label}' is a virtual dataset, made of other datasets or files, and nothing but the file itself is "
            "read; write its data into the file"
        )
    if stored.get_external_count():
        other = stored.get_external(0)[0].decode("utf-8", "replace")
        raise SceneError(
            f"'{label}' keeps its data in another file, {other!r:.100}, and nothing but the file itself is read; "
            "write the data into the file (h5repack -l CONTI)"
        )
    for number in range(stored.get_nfilters()):
        code = stored.get_filter(number)[0]
        if code not in FILTERS:
            raise SceneError(
                f"'{label}' is packed by filter {code}, which is code from elsewhere; unpack it where it was made: "
                "h5repack -f NONE"
            )
    length = dataset.get_type().get_size()
    if stored.get_layout() == h5py.h5d.CHUNKED:
        chunk = length
        for side in stored.get_chunk():
            chunk *= side
        if chunk > MAX_CHUNK:
            raise SceneError(
                f"'{label}' is stored in chunks of {chunk / 1e6:.0f} MB, more than {MAX_CHUNK / 1e6:.0f}; write it "
                "in smaller ones (h5repack -l CHUNK=...)"
            )
    for side in dataset.shape or ():
        length *= side
    return int(length)
