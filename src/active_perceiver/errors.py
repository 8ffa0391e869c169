"""The errors a user can act on that belong to no single module."""

from __future__ import annotations


class UserError(Exception):
    """Something the user gave is missing, broken or contradictory.

    The message is a sentence that says what is wrong and what to do; commands print it without a traceback.
    """


class SearchError(UserError, ValueError):
    """A search task, observation, policy or setting that is not sound; the message says what to do."""
