"""What a user of Gymnasium gets: ids for the bundled scenes and three observation modes."""

import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env as check_env_for_sb3

from active_perceiver.envs import SearchEnv, SearchError, SearchTask, SearchVectorEnv, location_mask
from active_perceiver.envs.observation_modes import MODES
from active_perceiver.envs.registration import register_environments, scene_id
from active_perceiver.scenes import TURTLEBOT_ACTIONS, Action, bundled_names
from active_perceiver.scenes.bundled import TARGETS_OF_RECORD
from active_perceiver.vision import BackboneError, load_backbone
from active_perceiver.vision.cache import scene_features
from helpers.toy import toy_scene

IDS = [name for name in gymnasium.registry if name.startswith("ActivePerceiver/")]
SIZE = {"image": 40, "features": 96, "boxes": None}
FOUR_ACTIONS = (Action.MOVE_AHEAD, Action.MOVE_BACK, Action.ROTATE_LEFT, Action.ROTATE_RIGHT)


def arguments(mode, scene):
    return {"scene": scene, "observation": mode, "image_size": SIZE[mode], "max_steps": 30}


def test_there_is_an_id_for_each_bundled_scene():
    assert sorted(IDS) == sorted(["ActivePerceiver/Search-v0", *map(scene_id, bundled_names())])
    assert "ActivePerceiver/LivingRoom2-v0" in IDS
    before = dict(gymnasium.registry)
    register_environments()  # once more does nothing
    assert gymnasium.registry == before


@pytest.mark.parametrize("name", bundled_names())
def test_a_bundled_scene_is_searched_for_its_targets_of_record(name):
    env = gymnasium.make(scene_id(name), observation="boxes")
    assert env.unwrapped.task.scene == name
    assert env.unwrapped.task.targets == TARGETS_OF_RECORD[name]
    assert env.action_space.n == (6 if name == "conference_room" else 8)
    env.reset(seed=0)
    assert env.step(env.action_space.sample())[0] in env.observation_space


def test_other_targets_can_be_searched_in_it():
    assert gymnasium.make("ActivePerceiver/Kitchen1-v0", targets=["bread"]).unwrapped.task.targets == ("bread",)
    every = gymnasium.make("ActivePerceiver/Kitchen1-v0", targets=None, observation="boxes")
    assert len(every.unwrapped.task.targets) == 24


def test_many_at_once_are_the_vector_environment():
    several = gymnasium.make_vec(
        "ActivePerceiver/Kitchen1-v0", num_envs=64, vectorization_mode="vector_entry_point", observation="boxes"
    )
    assert isinstance(several, SearchVectorEnv)
    observations, _ = several.reset(seed=0)
    assert observations in several.observation_space
    assert observations["box"].shape == (64, 5)
    assert isinstance(
        gymnasium.make_vec("ActivePerceiver/Kitchen1-v0", num_envs=2, observation="boxes"), SearchVectorEnv
    )


LIGHT = """
import sys
import h5py
def opened(self, name, *rest, **more):
    sys.exit(f"opened {name}")
h5py.File.__init__ = opened
import MODULE
import gymnasium
heavy = [name for name in ("torch", "matplotlib", "stable_baselines3") if name in sys.modules]
assert not heavy, heavy
print(len([name for name in gymnasium.registry if name.startswith("ActivePerceiver/")]))
"""


@pytest.mark.parametrize("module", ["active_perceiver.envs", "active_perceiver.envs.registration"])
def test_ids_are_there_without_torch_and_without_opening_a_scene(module):
    script = LIGHT.replace("MODULE", module)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(1 + len(bundled_names()))


def test_an_id_with_a_module_needs_no_import():
    script = (
        "import gymnasium; print(gymnasium.make('active_perceiver.envs:ActivePerceiver/Kitchen1-v0', "
        "observation='boxes').unwrapped.task.scene)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.strip() == "kitchen_1", done.stderr


@pytest.mark.parametrize("actions", [None, TURTLEBOT_ACTIONS, FOUR_ACTIONS], ids=["8", "6", "4"])
@pytest.mark.parametrize("mode", MODES)
def test_every_mode_passes_the_checkers_without_a_warning(mode, actions, scene):
    if actions is not None:
        scene = toy_scene(side=3, tilts=(0.0,) if len(actions) == 4 else (-30.0, 0.0), actions=actions)
    env = gymnasium.make("ActivePerceiver/Search-v0", **arguments(mode, scene), render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
        check_env_for_sb3(env.unwrapped)
    assert env.action_space.n == len(scene.actions)


def test_images_are_what_the_robot_sees_and_the_picture(scene):
    env = SearchEnv(scene, observation="image", image_size=scene.image_size)
    observation, info = env.reset(seed=3, options={"picture": 1})
    assert observation.keys() == {"view", "target"}
    np.testing.assert_array_equal(observation["view"], scene.view(info["state"]))
    np.testing.assert_array_equal(observation["target"], scene.targets[info["target"]].picture(1))


def test_features_are_the_backbones_and_the_mask_is_that_of_the_box(scene):
    env = SearchEnv(scene, ["ball2", "ball0"], observation="features", image_size=96)
    features = scene_features(scene, load_backbone(image_size=96))
    for seed in range(20):
        observation, info = env.reset(seed=seed, options={"target": seed % 2, "picture": seed % 2})
        of_scene = [2, 0][info["target"]]
        np.testing.assert_array_equal(observation["view"], features.view_features[info["state"]])
        np.testing.assert_array_equal(observation["target"], features.target_features[of_scene, seed % 2])
        np.testing.assert_array_equal(observation["mask"], location_mask(scene.boxes[info["state"], of_scene]))
    # The pictures held out are not shown.
    with pytest.raises(SearchError, match=r"'picture' must be in 0\.\.1"):
        env.reset(options={"picture": 2})


def test_boxes_are_zeros_where_nothing_is_seen_and_never_nan(scene):
    env = SearchEnv(scene, ["ball1", "ball2"], observation="boxes")
    seen = 0
    for seed in range(60):
        observation, info = env.reset(seed=seed)
        assert observation.keys() == {"box", "target"}
        assert observation["target"] == info["target"]
        truth = scene.boxes[info["state"], 1 + info["target"]]
        seen += not np.isnan(truth).any()
        expected = [0.0] * 5 if np.isnan(truth).any() else [1.0, *truth]
        np.testing.assert_allclose(observation["box"], expected, atol=1e-6)
    assert 0 < seen < 60


def test_a_vector_of_boxes_does_not_change_when_the_next_episode_begins(scene):
    several = SearchVectorEnv(20, scene, observation="boxes", max_steps=1)
    first, _ = several.reset(seed=0)
    before = first["target"].copy()
    for _ in range(3):
        several.step(np.zeros(20, int))
    np.testing.assert_array_equal(first["target"], before)


def test_refuses_modes_that_there_are_not(scene):
    with pytest.raises(SearchError, match="no observation mode 'sound'; choose one of image, features, boxes"):
        SearchEnv(scene, observation="sound")
    with pytest.raises(SearchError, match="needs the scene"):
        SearchVectorEnv(2, task=SearchTask.from_scene(scene), observation="boxes")
    with pytest.raises(SearchError, match="at least 1 pixel"):
        SearchEnv(scene, observation="image", image_size=-3)
    with pytest.raises(BackboneError, match="multiple of 32"):
        SearchEnv(scene, observation="features", image_size=50)
    with pytest.raises(SearchError, match=r"write \['ball0'\]"):
        SearchEnv(scene, "ball0")
    task = SearchTask.from_scene(scene)
    observations = SearchEnv(scene, observation="features", image_size=96).tables.shown._observations
    with pytest.raises(SearchError, match="leave them out to be shown 'boxes'"):
        SearchEnv(scene, task=task, observations=observations, observation="boxes")


@pytest.mark.parametrize("mode", MODES)
def test_stable_baselines3_trains_on_it(mode, scene):
    env = gymnasium.make("ActivePerceiver/Search-v0", **arguments(mode, scene))
    model = PPO("MultiInputPolicy", env, n_steps=32, batch_size=16, n_epochs=1, seed=0, device="cpu")
    before = [weights.detach().clone() for weights in model.policy.parameters()]
    model.learn(64)
    assert model.num_timesteps == 64
    after = list(model.policy.parameters())
    assert any((old != new).any() for old, new in zip(before, after, strict=True))
    assert all(weights.isfinite().all() for weights in after)
