"""The error a user can act on."""

from __future__ import annotations


class UserError(Exception):
    """Something the user gave is missing, broken or contradictory.

    The message is a sentence that says what is wrong and what to do; commands print it without a traceback.
    """
