"""HDF5 from anybody: what leads out of the file, crashes its library or fills the memory is refused unread."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from active_perceiver.datasets.savn.reader import import_savn
from active_perceiver.datasets.zhu.reader import import_zhu
from active_perceiver.scenes import Scene, SceneError, hdf5, hdf5_values, load_scene, save_scene
from active_perceiver.scenes.hdf5 import open_hdf5

SECRET = b"root:x:0:0:a secret of the user's\n" * 200


@pytest.fixture
def room(scene: Scene, tmp_path: Path) -> Path:
    path = tmp_path / "room.h5"
    save_scene(scene, path)
    return path


def external_storage(file: h5py.File, folder: Path) -> None:
    (folder / "secret").write_bytes(SECRET)
    shape = file["poses"].shape
    del file["poses"]
    file.create_dataset("poses", shape, "f4", external=[(str(folder / "secret"), 0, h5py.h5f.UNLIMITED)])


def external_link(file: h5py.File, folder: Path) -> None:
    with h5py.File(folder / "other.h5", "w") as other:
        other["poses"] = file["poses"][()]
    del file["poses"]
    file["poses"] = h5py.ExternalLink(str(folder / "other.h5"), "/poses")


def external_link_behind_a_soft_one(file: h5py.File, folder: Path) -> None:
    external_link(file, folder)
    file["far"] = file.get("poses", getlink=True)
    del file["poses"]
    file["poses"] = h5py.SoftLink("/far")


def external_link_to_a_group(file: h5py.File, folder: Path) -> None:
    del file["targets"]
    file["targets"] = h5py.ExternalLink("/etc/hosts", "/")


def soft_link_to_nowhere(file: h5py.File, folder: Path) -> None:
    file["more"] = h5py.SoftLink("/not/there")


def soft_link_to_itself(file: h5py.File, folder: Path) -> None:
    file["more"] = h5py.SoftLink("/more")


def virtual(file: h5py.File, folder: Path, source: str = ".") -> None:
    shape = file["poses"].shape
    del file["poses"]
    layout = h5py.VirtualLayout(shape, "f4")
    layout[:] = h5py.VirtualSource(source, "poses", shape)
    file.create_virtual_dataset("poses", layout)


def virtual_elsewhere(file: h5py.File, folder: Path) -> None:
    virtual(file, folder, str(folder / "other.h5"))


def unknown_filter(file: h5py.File, folder: Path) -> None:
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_chunk((4, 4))
    plist.set_filter(32001, h5py.h5z.FLAG_OPTIONAL, ())
    space = h5py.h5s.create_simple((4, 4))
    h5py.h5d.create(file.id, b"packed", h5py.h5t.NATIVE_FLOAT, space, plist)


def one_huge_chunk(file: h5py.File, folder: Path) -> None:
    file.create_dataset("more", (20_000, 20_000), "u1", chunks=(20_000, 20_000), compression="gzip")


REFUSED: dict[str, tuple[Callable[[h5py.File, Path], None], str]] = {
    "external storage": (external_storage, "'poses' keeps its data in another file, '.*secret'.*h5repack"),
    "external link": (external_link, "'poses' is a link to another file"),
    "external link behind a soft one": (external_link_behind_a_soft_one, "'far' is a link to another file"),
    "external link to a group": (external_link_to_a_group, "'targets' is a link to another file"),
    "soft link to nowhere": (soft_link_to_nowhere, "'more' is a link that leads nowhere"),
    "soft link to itself": (soft_link_to_itself, "'more' is a link that leads nowhere"),
    "virtual dataset of itself": (virtual, "'poses' is a virtual dataset"),
    "virtual dataset of another file": (virtual_elsewhere, "'poses' is a virtual dataset"),
    "unknown filter": (unknown_filter, "'packed' is packed by filter 32001.*h5repack -f NONE"),
    "one huge chunk": (one_huge_chunk, "'more' is stored in chunks of 400 MB"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_by_every_reader(name: str, room: Path, tmp_path: Path) -> None:
    change, message = REFUSED[name]
    with h5py.File(room, "r+") as file:
        change(file, tmp_path)
    folder = tmp_path / "FloorPlan1"
    folder.mkdir()
    (folder / "graph.json").write_text('{"nodes": [{"id": "0|0|0|0"}], "links": []}')
    (folder / "images.hdf5").write_bytes(room.read_bytes())
    for read, path in ((load_scene, room), (import_zhu, room), (import_savn, folder)):
        with pytest.raises(SceneError, match=message) as caught:
            read(path)
        assert str(path) in str(caught.value)


def test_links_that_stay_in_the_file_are_followed(scene: Scene, room: Path) -> None:
    """Also a group that holds itself, which is looked into once."""
    with h5py.File(room, "r+") as file:
        file["kept/poses"] = file["poses"]
        del file["poses"]
        file["poses"] = h5py.SoftLink("/kept/poses")
        file["kept/again"] = file["kept"]
    assert load_scene(room).content_hash == scene.content_hash


def test_the_objects_of_a_file_are_counted(room: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hdf5, "MAX_OBJECTS", 10)
    with pytest.raises(SceneError, match="more than 10 objects"):
        load_scene(room)


def test_what_unpacks_to_far_more_than_the_file_is_refused(room: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with h5py.File(room, "r+") as file:
        file.create_dataset("zeros", (60, 1_000_000), "u1", chunks=(1, 1_000_000), compression="gzip")[...] = 0
    assert load_scene(room)
    monkeypatch.setattr(hdf5, "HARMLESS_TOTAL", 1_000_000)
    monkeypatch.setattr(hdf5, "MAX_RATIO", 10)
    with pytest.raises(SceneError, match=r"unpacks to 0\.1 GB, more than 10 times its size"):
        load_scene(room)


def test_a_dataset_is_read_whole_only_if_it_fits(room: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hdf5_values, "MAX_WHOLE", 1000)
    with pytest.raises(SceneError, match="'poses' has 0 MB, more than"):
        load_scene(room)


def test_many_views_that_are_one_value_of_the_file_do_not_fill_the_memory(
    room: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """HDF5 keeps where each value is: 16 bytes in a row, which can be the same for all."""
    with h5py.File(room, "r+") as file:
        offset, count = file["views"].id.get_offset(), len(file["views"])
        file["views"][0] = np.zeros(100_000, np.uint8)
    data = bytearray(room.read_bytes())
    data[offset : offset + 16 * count] = data[offset : offset + 16] * count
    room.write_bytes(data)
    monkeypatch.setattr(hdf5_values, "MAX_WHOLE", 5_000_000)
    with pytest.raises(SceneError, match="unpacks to far more than its"):
        load_scene(room)


def test_an_attribute_is_one_value(room: Path) -> None:
    with h5py.File(room, "r+") as file:
        file.attrs["fov"] = np.zeros(5000)
    with pytest.raises(SceneError, match=r"attribute 'fov' is a list of \(5000,\)"):
        load_scene(room)


def test_h5py_is_opened_at_one_place_only() -> None:
    source = Path(hdf5.__file__).parents[1]
    opening = [
        path for path in source.rglob("*.py") if "h5py.File(" in path.read_text() or "().File(" in path.read_text()
    ]
    assert opening == [Path(hdf5.__file__)]


NO_LOCKS = "#include <errno.h>\nint flock(int fd, int op) { errno = ENOLCK; return -1; }\n"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="LD_PRELOAD is Linux's")
def test_disks_that_cannot_lock_files_will_do(scene: Scene, room: Path, tmp_path: Path) -> None:
    (tmp_path / "locks.c").write_text(NO_LOCKS)
    compiled = tmp_path / "locks.so"
    try:
        subprocess.run(["cc", "-shared", "-fPIC", "-o", compiled, tmp_path / "locks.c"], check=True)
    except FileNotFoundError:
        pytest.skip("there is no C compiler")
    assert ctypes.CDLL(str(compiled)).flock(0, 0) == -1
    code = (
        "import sys, h5py\n"
        "from active_perceiver.scenes import load_scene, save_scene\n"
        "scene = load_scene(sys.argv[1])\n"
        "save_scene(scene, sys.argv[1] + '.again.h5')\n"
        "try:\n"
        "    h5py.File(sys.argv[1])\n"
        "except OSError:\n"
        "    print('no locks', scene.content_hash)\n"
    )
    environment = {key: value for key, value in os.environ.items() if key != "HDF5_USE_FILE_LOCKING"}
    done = subprocess.run(
        [sys.executable, "-c", code, room],
        env={**environment, "LD_PRELOAD": str(compiled)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["no", "locks", scene.content_hash]
    assert load_scene(f"{room}.again.h5").content_hash == scene.content_hash


def test_errors_of_the_one_who_reads_stay_what_they_are(room: Path) -> None:
    with pytest.raises(SceneError, match=r"^mine$"), open_hdf5(room):
        raise SceneError("mine")
