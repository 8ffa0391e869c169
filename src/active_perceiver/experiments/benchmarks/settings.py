"""Settings of benchmarks; the docstring under a field is its help on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class ActSpeedSettings:
    """What to measure, and how often."""

    agent: Path | None = None
    """Folder of the agent; if not given, agents with random weights are measured, which are as fast."""
    backbones: tuple[str, ...] = ()
    """Without --agent: backbones to measure, all if not given. Published weights are used if they are in the cache,
    else random ones, which are as fast."""
    threads: tuple[int, ...] = (1, 2)
    """Numbers of CPU threads to measure."""
    repeats: int = 100
    """Actions to measure in each process."""
    starts: int = 3
    """Processes to start for each backbone and number of threads."""
    scene: str = "kitchen_1"
    """Where the pictures come from, a bundled name or a file."""
    frame: tuple[int, int] = (640, 480)
    """Width and height of the camera's pictures in pixels: views of the scene scaled to this, as JPEG."""
    image_size: int = 320
    """Without --agent: side in pixels to which pictures are scaled for the backbone; a multiple of 32."""
