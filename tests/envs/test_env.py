"""The environments: Gymnasium's own checks, every registered id, and the vector one against the scalar one."""

import pickle
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from active_perceiver.envs import REWARDS, Observations, SearchEnv, SearchError, SearchTask, SearchVectorEnv
from active_perceiver.envs.config import EnvConfig
from active_perceiver.scenes import SceneError, save_scene

IDS = ["ActivePerceiver/Search-v0"]  # those of the bundled scenes: test_registration.py


@pytest.fixture(scope="module")
def tables(scene):
    """A task and features for it."""
    rng = np.random.default_rng(0)
    task = SearchTask.from_scene(scene)
    views, pictures = rng.random((len(scene), 8), np.float32), rng.random((3, 2, 8), np.float32)
    return {"task": task, "observations": Observations.from_boxes(views, pictures, scene.boxes)}


def equal(first, second):
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(equal(first[key], second[key]) for key in first)
    return np.array_equal(first, second)


def play(env, seed, steps=60):
    """Everything an environment says over some random steps."""
    said = [env.reset(seed=seed)]
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        said.append(env.step(int(rng.integers(env.action_space.n))))
        if said[-1][2] or said[-1][3]:
            said.append(env.reset())
    return said


def same(first, second):
    return len(first) == len(second) and all(
        equal(one, other)
        for said, again in zip(first, second, strict=True)
        for one, other in zip(said, again, strict=True)
    )


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("kind", ["pixels", "features"])
def test_passes_gymnasiums_checks_without_a_warning(name, kind, scene, tables):
    arguments = {"scene": scene} if kind == "pixels" else {**tables, "scene": scene}
    env = gymnasium.make(name, **arguments, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


@pytest.mark.parametrize("name", IDS)
def test_is_deterministic_and_survives_pickling(name, scene):
    first = gymnasium.make(name, scene=scene, max_steps=20)
    second = pickle.loads(pickle.dumps(gymnasium.make(name, scene=scene, max_steps=20)))
    said = play(first, seed=3)
    assert same(said, play(second, seed=3))
    assert same(said, play(pickle.loads(pickle.dumps(first)), seed=3))
    assert not same(said, play(second, seed=4))


@pytest.mark.parametrize("name", IDS)
def test_renders_the_view_with_the_box(name, scene):
    several = gymnasium.make_vec(name, num_envs=40, scene=scene, render_mode="rgb_array")
    _, infos = several.reset(seed=0)
    env = gymnasium.make(name, scene=scene, render_mode="rgb_array")
    drawn = 0
    for image, state, target in zip(several.render(), infos["state"], infos["target"], strict=True):
        changed = (image != scene.view(state)).any(-1)
        box = scene.boxes[state, target] * scene.image_size
        assert changed.any() == (not np.isnan(box).any())
        if changed.any():
            drawn += 1
            rows, columns = np.flatnonzero(changed.any(1)), np.flatnonzero(changed.any(0))
            edges = [columns[0], rows[0], columns[-1] + 1, rows[-1] + 1]
            np.testing.assert_allclose(edges, [*(box[:2] - box[2:] / 2), *(box[:2] + box[2:] / 2)], atol=0.51)
        env.reset(options={"start": state, "target": target})
        np.testing.assert_array_equal(env.render(), image)
    assert drawn > 3


def test_opens_a_scene_file(scene, tmp_path):
    save_scene(scene, tmp_path / "room.h5")
    env = gymnasium.make(
        "active_perceiver.envs:ActivePerceiver/Search-v0",
        scene=tmp_path / "room.h5",
        targets=["ball1"],
        image_size=32,
    )
    observation, _ = env.reset(seed=0)
    assert observation["view"].shape == (32, 32, 3)
    assert env.unwrapped.task.targets == ("ball1",)


def test_start_target_and_picture_can_be_chosen(scene, tables):
    env = SearchEnv(**tables)
    start = int(tables["task"].starts(2)[5])
    observation, info = env.reset(options={"start": start, "target": "ball2", "picture": 1})
    assert (info["state"], info["target"]) == (start, 2)
    assert info["shortest"] == tables["task"].steps[start, 2]
    np.testing.assert_array_equal(observation["target"], tables["observations"].target_features[2, 1])
    np.testing.assert_array_equal(observation["view"], tables["observations"].view_features[start])
    np.testing.assert_array_equal(observation["mask"], tables["observations"].masks[start, 2, 1])


def test_a_shortest_path_ends_at_a_goal_in_time(scene, tables):
    task = tables["task"]
    for target in range(3):
        env = SearchEnv(**tables, reward="goal")
        start = int(task.steps[:, target].argmax())
        _, info = env.reset(options={"start": start, "target": target})
        for left in range(int(task.steps[start, target]), 0, -1):
            assert info["shortest"] == left
            action = int(task.steps[task.transitions[info["state"]], target].argmin())
            _, reward, terminated, truncated, info = env.step(action)
            assert not truncated
            assert terminated == (left == 1)
            assert reward == (10 if terminated else -0.01)


def test_truncates_after_the_last_step(tables):
    env = SearchEnv(**tables, max_steps=2)
    task = tables["task"]
    far = int(task.steps[:, 0].argmax())
    env.reset(options={"start": far, "target": 0})
    assert env.step(0)[2:4] == (False, False)
    assert env.step(0)[2:4] == (False, True)


@pytest.mark.parametrize("reward", REWARDS)
def test_the_vector_environment_does_what_scalar_ones_do(tables, reward):
    """Same starts and actions: same observations, rewards and ends, over autoresets too."""
    count, rng = 5, np.random.default_rng(1)
    several = SearchVectorEnv(count, **tables, reward=reward, max_steps=30)
    single = [SearchEnv(**tables, reward=reward, max_steps=30) for _ in range(count)]
    starts = {
        "start": tables["task"].starts(0)[:count],
        "target": np.zeros(count, int),
        "picture": np.arange(count) % 2,
    }
    observations, infos = several.reset(seed=0, options=starts)
    ended, resets, actions = np.ones(count, bool), 0, np.zeros(count, int)
    rewards, terminated, truncated = np.zeros(count), np.zeros(count, bool), np.zeros(count, bool)
    for _ in range(200):
        for index, env in enumerate(single):
            if ended[index]:  # an episode began: begin the same one
                resets += 1
                # The chosen picture is not in the info; it is found by its features.
                target = infos["target"][index]
                shown = tables["observations"].target_features[target]
                picture = int((shown == observations["target"][index]).all(-1).argmax())
                options = {"start": infos["state"][index], "target": target, "picture": picture}
                said = (*env.reset(options=options), 0.0, False, False)
            else:
                observation, paid, arrived, late, info = env.step(actions[index])
                said = (observation, info, paid, arrived, late)
            assert equal({key: value[index] for key, value in observations.items()}, said[0])
            assert {key: infos[key][index] for key in said[1]} == said[1]
            assert rewards[index] == pytest.approx(said[2], abs=1e-6)
            assert (terminated[index], truncated[index]) == said[3:]
        ended = terminated | truncated
        actions = rng.integers(0, several.single_action_space.n, count)
        observations, rewards, terminated, truncated, infos = several.step(actions)
    assert resets > 3 * count


def test_the_vector_environment_keeps_to_its_spaces_and_seed(scene, tables):
    several = SearchVectorEnv(4, **tables, max_steps=10)
    assert several.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    observations, _ = several.reset(seed=5)
    assert observations in several.observation_space
    again = pickle.loads(pickle.dumps(several))
    for _ in range(30):
        actions = np.random.default_rng(0).integers(0, 8, 4)
        first, second = several.step(actions), again.step(actions)
        assert first[0] in several.observation_space
        assert all(equal(one, other) for one, other in zip(first, second, strict=True))
    assert equal(several.reset(seed=5)[0], observations)


@pytest.mark.parametrize("make", [SearchEnv, lambda **arguments: SearchVectorEnv(2, **arguments)])
def test_refuses_what_does_not_go_together(make, scene, tables):
    with pytest.raises(SearchError, match="needs a scene"):
        make()
    with pytest.raises(SearchError, match="needs the scene"):
        make(task=tables["task"])
    with pytest.raises(SearchError, match="give only one"):
        make(**tables, targets=["ball0"])
    with pytest.raises(SearchError, match="do not fit"):
        make(scene=scene, targets=["ball0"], observations=tables["observations"])
    with pytest.raises(SearchError, match="no reward 'fun'"):
        make(scene=scene, reward="fun")
    with pytest.raises(SearchError, match="at least 1"):
        make(scene=scene, max_steps=0)
    with pytest.raises(SearchError, match="render_mode"):
        make(scene=scene, render_mode="human")
    with pytest.raises(SceneError, match="no target 'sofa'"):
        make(scene=scene, targets=["sofa"])
    with pytest.raises(SceneError, match="neither a bundled scene"):
        make(scene="nowhere")
    env = make(**tables, render_mode="rgb_array")
    env.reset(seed=0)
    with pytest.raises(SearchError, match="rendering needs the scene"):
        env.render()


@pytest.mark.parametrize("make", [SearchEnv, lambda **arguments: SearchVectorEnv(2, **arguments)])
def test_options_come_as_a_config_or_by_name(make, tables):
    config = EnvConfig(reward="goal", max_steps=7)
    assert make(**tables, config=config).config == config
    assert make(**tables, reward="goal", max_steps=7).config == config
    assert make(**tables, config=config, max_steps=9).config == EnvConfig(reward="goal", max_steps=9)
    with pytest.raises(TypeError, match="unexpected keyword argument 'speed'"):
        make(**tables, speed=3)


@pytest.mark.parametrize("make", [SearchEnv, lambda **arguments: SearchVectorEnv(2, **arguments)])
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"begin": 3}, "unknown reset options"),
        ({"target": "sofa"}, "no target 'sofa'"),
        ({"target": 3}, "'target' must be in 0..2"),
        ({"picture": -1}, "'picture' must be in 0..1"),
        ({"start": 10**6}, "'start' must be in"),
    ],
)
def test_refuses_reset_options(make, tables, options, message):
    with pytest.raises(SearchError, match=message):
        make(**tables).reset(options=options)


def test_refuses_a_start_at_a_goal_and_unknown_actions(tables):
    goal = int(np.flatnonzero(tables["task"].goals[:, 0])[0])
    env, several = SearchEnv(**tables), SearchVectorEnv(2, **tables)
    for some in (env, several):
        with pytest.raises(SearchError, match="cannot start at a goal"):
            some.reset(options={"start": goal, "target": 0})
        some.reset(seed=0)
    with pytest.raises(SearchError, match="action 8 is not in"):
        env.step(8)
    with pytest.raises(SearchError, match="actions must be 2 numbers"):
        several.step(np.array([0, 8]))


@pytest.mark.parametrize("kind", ["pixels", "features"])
@pytest.mark.parametrize("make", [SearchEnv, lambda **arguments: SearchVectorEnv(2, **arguments)])
def test_whoever_changes_an_observation_changes_no_other(make, kind, scene, tables):
    env = make(**({"scene": scene, "image_size": 16} if kind == "pixels" else tables))
    env.reset(seed=1)
    still = np.zeros_like(env.action_space.sample())
    first = env.step(still)[0]
    before = {name: array.copy() for name, array in first.items()}
    for array in first.values():
        array[...] = 7
    env.reset(seed=1)
    assert equal(env.step(still)[0], before)
