"""What of the files that the commands write is the same in every run, as plain data."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

# When, how fast, where and by which version: all that may differ between two runs of the same behaviour.
VARYING = {"date", "machine", "version", "software", "started", "seconds", "measuring"}
HIDDEN = "..."


def digest(*parts: bytes) -> str:
    """A short SHA-256 of some bytes, each told apart from the next."""
    total = hashlib.sha256()
    for part in parts:
        total.update(len(part).to_bytes(8, "little") + part)
    return total.hexdigest()[:32]


def steady(value: Any, folder: Path) -> Any:
    """JSON without what varies from run to run, and without the folder that the commands ran in."""
    if isinstance(value, dict):
        return {key: HIDDEN if key in VARYING else steady(item, folder) for key, item in value.items()}
    if isinstance(value, list):
        return [steady(item, folder) for item in value]
    return value.replace(str(folder), HIDDEN) if isinstance(value, str) else value


def json_facts(path: Path, folder: Path) -> Any:
    """A result file, or another JSON file."""
    return steady(json.loads(path.read_text()), folder)


def log_facts(path: Path, folder: Path) -> list[Any]:
    """A file with a JSON object on each line."""
    return [steady(json.loads(line), folder) for line in path.read_text().splitlines()]


def onnx_digest(path: Path) -> str:
    """Of all that a network computes and says of itself, without the names of the code that exported it.

    Those are in the backbone's file too, so the fingerprint of that file, which a recogniser notes, is left out.
    """
    import onnx

    model = onnx.load(path)
    model.doc_string = model.producer_version = ""
    noted = {prop.key: prop.value for prop in model.metadata_props if prop.key != "backbone"}
    model.ClearField("metadata_props")
    graph = model.graph
    graph.ClearField("metadata_props")
    for part in (*graph.node, *graph.initializer, *graph.value_info, *graph.input, *graph.output):
        part.ClearField("metadata_props")
        part.ClearField("doc_string")
    return digest(model.SerializeToString(deterministic=True), json.dumps(noted, sort_keys=True).encode())


def weights_digest(path: Path) -> str:
    """Of a safetensors file, whose metadata come in an order that changes; without the backbone's fingerprint."""
    data = path.read_bytes()
    end = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:end])
    header.get("__metadata__", {}).pop("backbone", None)
    return digest(json.dumps(header, sort_keys=True).encode(), data[end:])


def arrays_digest(path: Path) -> dict[str, str]:
    """Of each array in an .npz file; those named by a fingerprint, which has the backbone's in it, are numbered."""
    with np.load(path, allow_pickle=False) as file:
        return {
            str(number) if re.fullmatch(r"[0-9a-f]{16}", name) else name: _array_digest(file[name])
            for number, name in enumerate(file.files)
        }


def _array_digest(array: np.ndarray) -> str:
    return digest(f"{array.dtype}{array.shape}".encode(), np.ascontiguousarray(array).tobytes())


def hdf5_facts(path: Path) -> dict[str, Any]:
    """Attributes and digests of the arrays in a scene file."""
    import h5py

    facts: dict[str, Any] = {}

    def note(name: str, item: h5py.Group | h5py.Dataset) -> None:
        facts[f"{name} attributes"] = {key: str(value) for key, value in sorted(item.attrs.items())}
        if isinstance(item, h5py.Dataset):
            held = item[()]
            whole = not item.dtype.hasobject
            facts[name] = _array_digest(np.asarray(held)) if whole else digest(*_texts(np.ravel(held)))

    with h5py.File(path) as file:
        note("", file)
        file.visititems(note)
    return facts


def _texts(items: Iterable[Any]) -> Iterable[bytes]:
    return (item.encode() if isinstance(item, str) else bytes(item) for item in items)


def page_text(path: Path, folder: Path) -> str:
    """A page: its video only that it is there, of its pictures a digest."""
    text = path.read_text().replace(str(folder), HIDDEN)
    text = re.sub(r"data:video/mp4;base64,[A-Za-z0-9+/=]+", "VIDEO", text)
    embedded = r"data:(image/\w+);base64,([A-Za-z0-9+/=]+)"
    return re.sub(embedded, lambda match: f"{match[1]} {digest(match[2].encode())}", text)


def card_text(path: Path, folder: Path) -> str:
    """An agent's README; which module its example imports may change."""
    return re.sub(r"from [\w.]+ import", f"from {HIDDEN} import", path.read_text().replace(str(folder), HIDDEN))


def agent_facts(agent: Path, folder: Path) -> dict[str, Any]:
    """Every file of an agent's folder."""
    readers = {
        ".onnx": onnx_digest,
        ".npz": arrays_digest,
        ".safetensors": weights_digest,
        ".json": lambda path: json_facts(path, folder),
        ".md": lambda path: card_text(path, folder).splitlines(),
    }
    return {
        path.relative_to(agent).as_posix(): readers.get(path.suffix, lambda path: digest(path.read_bytes()))(path)
        for path in sorted(agent.rglob("*"))
        if path.is_file()
    }
