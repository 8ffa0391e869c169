"""The search as a Gymnasium environment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from active_perceiver.envs.config import RENDER_MODES, EnvConfig
from active_perceiver.envs.env_tables import env_tables
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.rewards import reward_named
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError
from active_perceiver.scenes import Scene

DEFAULTS = EnvConfig()


class SearchEnv(gymnasium.Env[dict[str, NDArray[Any]], np.int64]):
    """Look around a scene for the object in a picture, and walk up to it.

    ## Action space
    `Discrete(A)`: the scene's actions in the order of `task.actions`, such as MoveAhead, RotateLeft or LookUp. An
    action that would collide leaves the state as it is.

    ## Observation space
    A `Dict`; what is in it is chosen by `observation`:

    - "image": `view` and `target`, what the robot sees and the picture of what it searches for, (84, 84, 3) uint8.
    - "features": `view` and `target`, what the backbone makes of these, (D,) float32, and `mask` (25,) float32, the
      5 x 5 location mask: where in the view the target is seen, by the recogniser whose `observations` are given,
      else by ground truth.
    - "boxes": `box` (5,) float32, the target's ground-truth box as 1, centre x, centre y, width, height (fractions of
      the image), or five zeros where it is not visible; and `target`, its number.

    None of them says where the robot is.

    ## Rewards
    One of `active_perceiver.envs.REWARDS`.

    ## Starting state
    A random target in a random one of its pictures, and a random state from which one of its goals can be reached.
    `reset(options={"start": 17, "target": "mug", "picture": 0})` chooses any of them.

    ## Episode end
    Terminates at a goal: a state whose ground-truth box is among the five largest of the target. Truncates after
    `max_steps` actions.

    ## Info
    `state`, `target` (index), `shortest` (fewest actions from here).

    Args:
        scene: a scene, the name of a bundled one or a file; may be left out if task and observations are given.
        targets: names of what is searched; None for all of the scene's.
        config: what is shown, paid and allowed.
        task: instead of `targets`, a search task.
        observations: features and masks of the task; None to compute them (features are kept in the cache).
        options: fields of `EnvConfig` by name, instead of those in `config`.

    Raises:
        SearchError: if what was given does not go together.
        SceneError: if there is no such scene or target.
    """

    # An annotation as ClassVar would contradict Gymnasium's own.
    metadata: dict[str, Any] = {"render_modes": [*RENDER_MODES], "render_fps": 4}  # noqa: RUF012

    def __init__(
        self,
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
        self.reward = reward_named(self.config.reward)
        self.render_mode = self.config.render_mode
        self.observation_space: spaces.Space[Any] = self.tables.space
        self.action_space = spaces.Discrete(len(self.task.actions))
        self._state = self._target = self._picture = self._steps = 0
        self._best_area = 0.0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        """Start an episode; see the class for the options."""
        super().reset(seed=seed)
        chosen = self.tables.check_options(options)
        self._target = int(chosen.get("target", self.np_random.integers(len(self.task.targets))))
        self._picture = int(chosen.get("picture", self.np_random.integers(self.tables.pictures)))
        self._state = int(chosen.get("start", self.np_random.choice(self.task.starts(self._target))))
        self.tables.check_starts(self._state, self._target)
        self._steps = 0
        self._best_area = float(self.task.areas[self._state, self._target])
        return self._observe(), self._info()

    def step(self, action: np.int64 | int) -> tuple[dict[str, NDArray[Any]], float, bool, bool, dict[str, Any]]:
        """Take one action: observation, reward, terminated, truncated, info."""
        if not self.action_space.contains(np.int64(action)):
            raise SearchError(f"action {action} is not in 0..{len(self.task.actions) - 1}")
        self._state = int(self.task.transitions[self._state, action])
        self._steps += 1
        area = float(self.task.areas[self._state, self._target])
        arrived = bool(self.task.goals[self._state, self._target])
        goal_area = float(self.task.goal_areas[self._target])
        reward = float(self.reward.function(area, self._best_area, arrived, goal_area))
        self._best_area = max(self._best_area, area)
        truncated = not arrived and self._steps >= self.config.max_steps
        return self._observe(), reward, arrived, truncated, self._info()

    def render(self) -> NDArray[np.uint8] | None:
        """The view with the target's box, (H, W, 3) uint8 RGB, if the render mode is "rgb_array"."""
        if self.render_mode is None:
            return None
        return self.tables.render(self._state, self._target)

    def _observe(self) -> dict[str, NDArray[Any]]:
        return self.tables.look(self._state, self._target, self._picture)

    def _info(self) -> dict[str, Any]:
        shortest = int(self.task.steps[self._state, self._target])
        return {"state": self._state, "target": self._target, "shortest": shortest}
