"""Many searches at once as a native Gymnasium vector environment: a step is a few table look-ups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from active_perceiver.envs.batched_search import Searches
from active_perceiver.envs.config import EnvConfig
from active_perceiver.envs.env import DEFAULTS, SearchEnv
from active_perceiver.envs.env_tables import env_tables
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.rewards import reward_named
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError
from active_perceiver.scenes import Scene


class SearchVectorEnv(VectorEnv[dict[str, NDArray[Any]], NDArray[np.int64], NDArray[Any]]):
    """`num_envs` searches in one scene; see `SearchEnv` for spaces, rewards, starts, ends and arguments.

    Autoreset is Gymnasium's next-step mode: the step after an episode's last ignores the action, starts the next
    episode and pays nothing. The options of `reset` may be arrays, one entry per search; they hold for the episodes
    that `reset` starts, not for those that follow.
    """

    # An annotation as ClassVar would contradict Gymnasium's own.
    metadata: dict[str, Any] = {**SearchEnv.metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        scene: Scene | str | Path | None = None,
        targets: Sequence[str] | None = None,
        config: EnvConfig = DEFAULTS,
        *,
        task: SearchTask | None = None,
        observations: Observations | None = None,
        **options: Any,
    ) -> None:
        self.config = replace(config, **options)
        self.tables = env_tables(scene, targets, task, observations, self.config)
        self.task = self.tables.task
        self.searches = Searches(self.task, num_envs, reward_named(self.config.reward), self.config.max_steps)
        self.num_envs = num_envs
        self.render_mode = self.config.render_mode
        self.single_observation_space = self.tables.space
        self.single_action_space = spaces.Discrete(len(self.task.actions))
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._pictures = np.zeros(num_envs, np.int64)
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        """Start an episode in every search."""
        super().reset(seed=seed)
        self._begin(np.arange(self.num_envs), self.tables.check_options(options))
        self._ended[:] = False
        return self._observe(), self._info()

    def step(
        self, actions: NDArray[np.int64]
    ) -> tuple[dict[str, NDArray[Any]], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Take one action in every search: observations, rewards, terminated, truncated, infos."""
        actions = np.asarray(actions)
        if actions.shape != (self.num_envs,) or actions.min() < 0 or actions.max() >= len(self.task.actions):
            raise SearchError(f"actions must be {self.num_envs} numbers in 0..{len(self.task.actions) - 1}")
        begins = self._ended
        rewards, terminated, truncated = self.searches.step(actions)
        if begins.any():
            # What a step would have done in a search that had ended is undone by the start of its next episode.
            self._begin(np.flatnonzero(begins), {})
            rewards = np.where(begins, 0.0, rewards)
            terminated, truncated = terminated & ~begins, truncated & ~begins
        self._ended = terminated | truncated
        return self._observe(), rewards, terminated, truncated, self._info()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Each search's view with its target's box, if the render mode is "rgb_array"."""
        if self.render_mode is None:
            return None
        searches = zip(self.searches.states.tolist(), self.searches.targets.tolist(), strict=True)
        return tuple(self.tables.render(state, target) for state, target in searches)

    def _begin(self, which: NDArray[np.int64], options: dict[str, Any]) -> None:
        count = len(which)
        targets = _option(options, "target", self.np_random.integers(len(self.task.targets), size=count))
        self._pictures[which] = _option(options, "picture", self.np_random.integers(self.tables.pictures, size=count))
        states = _option(options, "start", self.searches.random_starts(targets, self.np_random))
        self.tables.check_starts(states, targets)
        self.searches.begin(which, states, targets)

    def _observe(self) -> dict[str, NDArray[Any]]:
        return self.tables.look(self.searches.states, self.searches.targets, self._pictures)

    def _info(self) -> dict[str, Any]:
        states, targets = self.searches.states, self.searches.targets
        info = {"state": states.copy(), "target": targets.copy(), "shortest": self.task.steps[states, targets]}
        return info | {f"_{key}": np.ones(self.num_envs, bool) for key in info}


def _option(options: dict[str, Any], name: str, default: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.broadcast_to(np.asarray(options.get(name, default), np.int64), default.shape)
