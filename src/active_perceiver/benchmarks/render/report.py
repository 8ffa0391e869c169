"""What `benchmark render` prints."""

from __future__ import annotations

from typing import Any


def format_timing(result: dict[str, Any]) -> str:
    """A table of what `measure_rendering` found."""
    view = result["view"]
    lines = [
        f"{result['name']}: {result['triangles']} triangles, {result['vertices']} vertices, {result['lamps']} lamps",
        f"{'':34}{'CPU s':>9}{'wall s':>9}",
    ]
    named = (("room and textures", "room"), ("compiling", "compile"), ("light, compiling included", "light"))
    for label, key in (*named, ("target picture", "target picture")):
        if result[key] is not None:
            lines.append(f"{label:34}{result[key]['cpu']:9.2f}{result[key]['wall']:9.2f}")
    lines += [
        f"{'view, median':34}{view['median']:9.3f}{view['wall_median']:9.3f}",
        f"{'view, worst':34}{view['worst']:9.3f}",
        *(f"{'  ' + stage:34}{share:9.0%}" for stage, share in view["stages"].items()),
        f"{view['per_second']:.1f} views of {result['image_size']} x {result['image_size']} pixels at"
        f" {result['samples']} rays each, per second and core ({result['views']} measured)",
    ]
    if result["peak_memory_gib"] is not None:
        lines.append(f"peak memory {result['peak_memory_gib']:.2f} GiB")
    return "\n".join(lines)
