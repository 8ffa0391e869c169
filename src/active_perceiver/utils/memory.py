"""How much memory this process has needed, as benchmarks report it."""

from __future__ import annotations

import sys
from pathlib import Path


def peak_memory() -> float | None:
    """Most memory this process has had at once, in GiB; None where the system does not tell."""
    try:
        # What getrusage says on Linux includes the process that started this one.
        lines = Path("/proc/self/status").read_text().splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 2**20
    except (OSError, StopIteration):
        pass
    if sys.platform == "win32":
        return None
    import resource

    # Kibibytes, but bytes on macOS.
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**30
