"""Reading the Active Vision Dataset's `image_structs.mat` in a process of its own.

SciPy's reader takes the whole process with it where some bytes of a file are damaged
(`python -m active_perceiver.datasets.avd.matlab_records FILE` is what runs, and prints JSON).
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes.scene import SceneError

# Seconds that reading some thousand records may take; what takes longer is damaged.
_LIMIT = 120
_REFUSED = 3


@dataclass(frozen=True, eq=False)
class Records:
    """What the file says of each photograph.

    Attributes:
        names: (N,) of the photographs.
        places: (N, 3) `world_pos`, NaN where it is empty.
        directions: (N, 3) where the camera looks, NaN where nothing says so.
        scale: millimetres per unit of `world_pos`, 0 if the file does not say.
    """

    names: tuple[str, ...]
    places: NDArray[np.float64]
    directions: NDArray[np.float64]
    scale: float


def read_records(path: Path) -> Records:
    """Read the file.

    Raises:
        SceneError: if it is missing, cannot be read, or a record is malformed.
    """
    if not path.is_file():
        raise SceneError(f"there is no {path.name} in {path.parent}; it holds the poses")
    command = [sys.executable, "-m", "active_perceiver.datasets.avd.matlab_records", str(path)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=_LIMIT, check=False)
    except subprocess.TimeoutExpired:
        raise SceneError(f"{path} takes too long to read; it is damaged, copy it again") from None
    if done.returncode == _REFUSED:
        raise SceneError(done.stderr.decode("utf-8", "replace").strip())
    if done.returncode:
        raise SceneError(f"{path} is not a readable MATLAB file; it is damaged, copy it again")
    return as_records(json.loads(done.stdout))


def as_records(found: dict[str, Any]) -> Records:
    """What `records_as_json` says, as arrays."""
    return Records(
        names=tuple(found["names"]),
        places=np.array(found["places"], np.float64).reshape(-1, 3),
        directions=np.array(found["directions"], np.float64).reshape(-1, 3),
        scale=float(found["scale"]),
    )


def records_as_json(path: Path) -> dict[str, Any]:
    """The content of the file, as JSON can say it; see `Records`.

    Raises:
        SceneError: if it cannot be read, or a record is malformed.
    """
    content = _loaded(path)
    records = content["image_structs"]
    records = records if isinstance(records, list) else [records]
    names, places, directions = [], [], []
    for number, record in enumerate(records):
        if not isinstance(record, dict) or not isinstance(record.get("image_name"), str):
            raise SceneError(f"{path}: record {number} of 'image_structs' has no 'image_name'")
        where = f"{path}, {record['image_name']:.60}"
        names.append(str(record["image_name"]))
        places.append(_array(record, "world_pos", (3,), where).tolist())
        directions.append(_direction(record, where).tolist())
    scale = content.get("scale")
    scale = float(scale) if isinstance(scale, (int, float)) and 0 < scale < 1e9 else 0.0
    return {"names": names, "places": places, "directions": directions, "scale": scale}


def _loaded(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        content: dict[str, Any] = loadmat(path, simplify_cells=True)
    except NotImplementedError:
        raise SceneError(
            f"{path} is a MATLAB file of version 7.3, which cannot be read here; load it in MATLAB and save it with "
            "save(..., '-v7')"
        ) from None
    except Exception as error:  # what SciPy raises where a file is damaged depends on the place of the damage
        reason = " ".join(str(error).split())
        raise SceneError(f"{path} is not a readable MATLAB file ({reason:.80}); copy it again") from None
    if "image_structs" not in content:
        raise SceneError(f"{path} has no variable 'image_structs'")
    return content


def _array(record: dict[str, Any], key: str, shape: tuple[int, ...], where: str) -> NDArray[np.float64]:
    """Numbers of a record, NaN if it has none."""
    value = np.asarray(record.get(key, []))
    if value.size == 0:
        return np.full(shape, np.nan)
    if value.shape != shape or value.dtype.kind not in "iuf":
        wanted = " x ".join(map(str, shape))
        raise SceneError(f"{where}: '{key}' should be {wanted} numbers, got {value.dtype} of shape {value.shape}")
    numbers = value.astype(np.float64)
    return np.where(np.abs(numbers) < 1e9, numbers, np.nan)


def _direction(record: dict[str, Any], where: str) -> NDArray[np.float64]:
    """Where the camera looks: as said, or else the camera's third axis."""
    said = _array(record, "direction", (3,), where)
    return said if np.isfinite(said).all() else _array(record, "R", (3, 3), where)[2]


def _main() -> int:
    try:
        print(json.dumps(records_as_json(Path(sys.argv[1]))))
    except SceneError as error:
        print(error, file=sys.stderr)
        return _REFUSED
    return 0


if __name__ == "__main__":
    sys.exit(_main())
