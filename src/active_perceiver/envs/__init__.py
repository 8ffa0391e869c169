"""The search for targets in a scene: tasks, observations, rewards and Gymnasium environments.

Importing this registers `ActivePerceiver/Search-v0` and an id for each bundled scene with Gymnasium; without an
import, make one as `gymnasium.make("active_perceiver.envs:ActivePerceiver/Search-v0", scene=...)`. See
`registration`.
"""

from active_perceiver.envs.batched_search import Searches
from active_perceiver.envs.config import EnvConfig
from active_perceiver.envs.env import SearchEnv
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.registration import register_environments
from active_perceiver.envs.rewards import REWARDS, Reward, reward_named
from active_perceiver.envs.task import SearchTask
from active_perceiver.envs.vector_env import SearchVectorEnv
from active_perceiver.envs.view_task import view_observations, view_task
from active_perceiver.errors import SearchError
from active_perceiver.vision.location import location_mask

__all__ = [
    "REWARDS",
    "EnvConfig",
    "Observations",
    "Reward",
    "SearchEnv",
    "SearchError",
    "SearchTask",
    "SearchVectorEnv",
    "Searches",
    "location_mask",
    "reward_named",
    "view_observations",
    "view_task",
]

register_environments()
