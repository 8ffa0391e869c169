"""What can be chosen of a search; what a field's text says is the help of the option of that name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from active_perceiver.errors import UserError


class SearchLimitError(UserError, ValueError):
    """A limit of a search that no search can keep to."""


@dataclass(frozen=True)
class SearchConfig:
    """How an agent searches with a robot, see `search`."""

    scene: str | None = None
    """Policy branch, the name of a scene the agent was trained in; needed if it has several."""
    max_steps: int = 200
    """Give up after so many actions; of a dry run, after so many looks."""
    max_minutes: float = 10.0
    """Give up after so many minutes."""
    seed: int | None = None
    """The start and the agent's draws follow from it."""
    dry_run: bool = False
    """Only look, and show what would be done: nothing moves. It looks --max-steps times, or until Ctrl-C."""
    dry_pause: float = 0.5
    """Seconds between two looks of a dry run; nothing that a camera is held at changes faster than by default."""

    def check_limits(self) -> None:
        """Refuse limits that no search can keep to.

        Raises:
            SearchLimitError: if fewer than 1 action, or no time, is allowed.
        """
        if self.max_steps < 1:
            raise SearchLimitError(
                f"a search needs at least 1 action, got max_steps {self.max_steps}; give 1 or more"
            )
        if not self.max_minutes > 0:  # NaN neither
            raise SearchLimitError(f"a search needs some time, got max_minutes {self.max_minutes}; give more than 0")
        if not 0 <= self.dry_pause < float("inf"):
            raise SearchLimitError(f"a dry run's pause is 0 seconds or longer, got dry_pause {self.dry_pause}")


@dataclass(frozen=True, kw_only=True)
class SessionConfig(SearchConfig):
    """A search from its names: also the robot, how the agent is loaded, and where a recording is kept."""

    robot: str
    """Where to search: scene:NAME for a bundled scene, scene:FILE for a scene file; thor:FloorPlan1 for a room of
    AI2-THOR, thor:FILE for one captured with other than the usual settings; room:NAME for a simulated TurtleBot in a
    rendered room; ros:ws://HOST:PORT for a robot behind rosbridge."""
    robot_config: str | None = None
    """What a ros robot is like: turtlebot2, turtlebot3, turtlebot4, or a YAML file."""
    start: int | None = None
    """State to start in; a random one if not given."""
    threads: int | None = None
    """CPU threads of the agent; one per core if not given."""
    confirm: bool = False
    """Take two views in a row, from different poses, to say found: fewer false ones, a step or so more."""
    explore: bool = True
    """Whether to look round the room when the policy leads in circles, because the target is not where it was; with
    --no-explore the policy is followed all the same."""
    record: Path | None = None
    """Keep everything that is seen and decided in this folder as the search goes on; `report` makes a page of it."""
