"""What can be chosen of an environment: the same for one search and for many."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from active_perceiver.envs.rewards import reward_named
from active_perceiver.errors import SearchError

ObservationMode = Literal["image", "features", "boxes"]
RENDER_MODES = ("rgb_array",)


@dataclass(frozen=True)
class EnvConfig:
    """What an environment shows, pays and allows; each field is a keyword of `gymnasium.make` as well."""

    observation: ObservationMode | None = None
    """What is seen, see `SearchEnv`; None for "features" if observations are given, else "image"."""
    reward: str = "gain"
    """A name in `active_perceiver.envs.REWARDS`."""
    max_steps: int = 5000
    """Actions until an episode is truncated; 5000 in the paper."""
    image_size: int | None = None
    """Side in pixels of the images shown, 84 if None; with "features" of those the backbone gets, 320 if None."""
    backbone: str = "efficientnet_lite0"
    """Whose features, if they are computed."""
    render_mode: str | None = None
    """"rgb_array" for the view with the target's ground-truth box."""

    def __post_init__(self) -> None:
        reward_named(self.reward)
        if self.max_steps < 1:
            raise SearchError(f"an episode needs at least 1 step, got {self.max_steps}")
        if self.render_mode not in (None, *RENDER_MODES):
            raise SearchError(f"render_mode must be None or 'rgb_array', got {self.render_mode!r}")
