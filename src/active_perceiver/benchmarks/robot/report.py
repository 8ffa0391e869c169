"""What `benchmark robot` says: the table."""

from __future__ import annotations

from typing import Any

from active_perceiver.utils.result import format_number


def format_robot(body: dict[str, Any]) -> str:
    """A table of what `robot_command` measured."""
    protocol = body["protocol"]
    lines = [
        f"{protocol['room']}: {', '.join(protocol['targets'])}; at most {protocol['max_steps']} actions",
        f"{'':40}{'searches':>8}{'by its own word, %':>33}{'true':>8}{'at the end off by':>28}{'bumps':>7}",
        f"{'what is different':40}{'':>8}{'true (95 % interval)':>21}{'false':>6}{'none':>6}{'actions':>8}"
        f"{'cm (most)':>12}{'degrees (most)':>16}",
    ]
    for row in body["rows"]:
        low, high = row["interval"]
        true = f"{100 * row['true_found']:.1f} ({100 * low:.1f}-{100 * high:.1f})"
        (metres, most_metres), (degrees, most_degrees) = row["metres_off"], row["degrees_off"]
        lines.append(
            f"{row['label']:40}{row['searches']:>8}{true:>21}{100 * row['false_found']:6.1f}"
            f"{100 * row['not_found']:6.1f}{format_number(row['actions'], '.1f'):>8}"
            f"{f'{100 * metres:.0f} ({100 * most_metres:.0f})':>12}{f'{degrees:.0f} ({most_degrees:.0f})':>16}"
            f"{row['collisions']:7.1f}"
        )
    lines += [
        f"off the lattice: starts within {protocol['centimetres']:g} cm and {protocol['degrees']:g} degrees of it, "
        "wheels that slip; all changes: also another hour, a webcam's faults,",
        f"things moved by up to {100 * protocol['nudge']:g} cm. true: its box on the target (IoU at least "
        f"{protocol['true_iou']:g}); false: elsewhere; none: not within the actions.",
    ]
    return "\n".join(lines)
