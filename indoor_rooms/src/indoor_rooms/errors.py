"""What a caller can act on."""

from __future__ import annotations


class RoomError(Exception):
    """Something that was asked for is missing, broken or contradictory; the message says what to do."""
