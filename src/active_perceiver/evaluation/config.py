"""Settings of evaluation; the docstring under a field is its help on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class EvaluateConfig:
    """How to measure an agent."""

    protocol: Literal["exact", "paper"] = "exact"
    """"exact" takes every start into account, without sampling; "paper" runs episodes from random starts."""
    episodes: int = 10
    """Episodes per target for the paper's protocol."""
    limit: int = 5000
    """Actions after which a search has failed."""
    searches: int = 100
    """Searches per target by the agent's own word, from random starts."""
    confirm: bool = False
    """By its own word the agent takes two views in a row, from different poses, to say found."""
    explore: bool = True
    """Whether by its own word the agent looks round the room when its policy leads in circles; with --no-explore it
    follows the policy all the same."""
    seed: int = 0
    """Draws of starts, pictures and actions follow from it."""
