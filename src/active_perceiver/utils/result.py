"""Result files: what every command that measures writes, and the machine it was measured on."""

from __future__ import annotations

import json
import math
import os
import platform
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from active_perceiver.utils.files import replacing
from active_perceiver.version import __version__

PACKAGES = ("numpy", "scipy", "h5py", "pillow", "onnxruntime", "gymnasium", "torch", "embreex", "mitsuba-oidn")


def machine() -> dict[str, Any]:
    """Processor, cores, memory in GiB, system and versions of what matters for speed and results."""
    versions: dict[str, str | None] = {}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = None
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "memory_gib": _memory_gib(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "packages": versions,
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def _memory_gib() -> float | None:
    try:
        return round(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30, 1)
    except (AttributeError, ValueError, OSError):
        return None


def write_result(path: Path, command: str, body: dict[str, Any]) -> dict[str, Any]:
    """Write a `result.json`, atomically: command, version, date and machine, then the body.

    Numbers are rounded to six digits; what is not a finite number becomes null, which JSON can say.

    Returns:
        What was written.
    """
    head = {
        "command": command,
        "version": __version__,
        "date": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "machine": machine(),
    }
    result = to_jsonable({**head, **body})
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(result, indent=2) + "\n")
    return result


def to_jsonable(value: Any) -> Any:
    """A body as a result file holds it, see `write_result`: a table that is made of it says what the file does."""
    if isinstance(value, dict):
        return {str(key): to_jsonable(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_jsonable(item) for item in value]
    if isinstance(value, float) or hasattr(value, "dtype"):
        number = float(value)
        if not math.isfinite(number):
            return None
        return int(number) if hasattr(value, "dtype") and value.dtype.kind in "iub" else float(f"{number:.6g}")
    if isinstance(value, Path):
        return str(value)
    return value


def format_number(value: float | None, form: str = ".3f") -> str:
    """A figure for people: formatted, or a dash where there is none (None or NaN)."""
    return "-" if value is None or math.isnan(value) else format(value, form)
