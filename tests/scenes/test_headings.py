"""Headings in steps other than 90 degrees, scenes without tilt or side moves: environments, figures, training."""

import dataclasses
import warnings

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env

from active_perceiver.envs import Observations, SearchTask, SearchVectorEnv
from active_perceiver.figures.contact_sheet import contact_sheet
from active_perceiver.figures.entropy_map import entropy_maps, lattice_spacing
from active_perceiver.figures.floor import figure_image, trajectory_figure
from active_perceiver.policies.config import DistilConfig
from active_perceiver.policies.evaluation import exact_evaluation
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.reports.scene_report import describe
from active_perceiver.robots.recorded import RecordedRobot
from active_perceiver.scenes import Action, Scene, load_scene, save_scene
from active_perceiver.scenes.checking import scene_issues
from active_perceiver.scenes.lattice import shortest_path, steps_to_goal
from helpers.foreign import AVD_ACTIONS, ZHU_ORDER, savn_scene
from helpers.toy import toy_scene

KINDS = {
    "as in Zhu: four actions, no tilt": {"actions": ZHU_ORDER, "tilts": (0.0,)},
    "as in AVD: 30 degrees, six actions, no tilt": {
        "actions": tuple(AVD_ACTIONS.values()), "tilts": (0.0,), "headings": tuple(range(0, 360, 30)),
    },
    "as in SAVN: 45 degrees, five actions, diagonal moves": None,
    "120 degrees from 17, one tilt downwards": {
        "actions": (Action.MOVE_AHEAD, Action.MOVE_BACK, Action.ROTATE_LEFT), "tilts": (-20.0,),
        "headings": (17.0, 137.0, 257.0),
    },
}  # fmt: skip


@pytest.fixture(scope="module", params=KINDS)
def scene(request) -> Scene:
    options = KINDS[request.param]
    if options is None:
        return savn_scene(side=3, image_size=32)
    return toy_scene(**{"side": 3, "image_size": 32, **options})


@pytest.fixture(scope="module")
def task(scene) -> SearchTask:
    return SearchTask.from_scene(scene)


def test_it_is_sound_and_is_read_as_it_was_written(scene, tmp_path):
    save_scene(scene, tmp_path / "scene.h5")
    again = load_scene(tmp_path / "scene.h5")
    assert again.actions == scene.actions
    np.testing.assert_array_equal(again.transitions, scene.transitions)
    assert not [training_task for training_task in scene_issues(again) if training_task.fatal]


def test_what_is_said_of_it_counts_its_own_headings(scene):
    views = len(scene) // 9
    tilts = len(np.unique(scene.poses[:, 3]))
    assert f"9 places, {views} views at each, {tilts} tilt(s)" in describe(scene)


def test_turning_all_the_way_round_comes_back(scene):
    headings = len(np.unique(scene.poses[:, 2]))
    left = scene.transitions[:, scene.actions.index(Action.ROTATE_LEFT)]
    state = np.arange(len(scene))
    for turn in range(1, headings + 1):
        state = left[state]
        assert (state == np.arange(len(scene))).all() == (turn == headings)
    step = (scene.poses[:, 2] - scene.poses[left, 2]) % 360
    np.testing.assert_allclose(step, 360 / headings, atol=1e-3)


def test_environments_pass_gymnasiums_checks(scene, task):
    env = gymnasium.make("ActivePerceiver/Search-v0", scene=scene, image_size=32, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
    assert env.action_space.n == len(scene.actions)
    rng = np.random.default_rng(0)
    many = SearchVectorEnv(3, task=task, observations=_observations(scene))
    seen, _ = many.reset(seed=0)
    for _ in range(20):
        seen, *_ = many.step(rng.integers(len(scene.actions), size=3))
    assert len(seen["mask"]) == 3


def test_a_recorded_robot_walks_a_shortest_path(scene, task):
    start = int(task.starts(0)[0])
    robot = RecordedRobot(scene, start)
    assert robot.actions == scene.actions
    path = shortest_path(scene.transitions, task.goals[:, 0], start)
    for after in path[1:]:
        robot.execute(scene.actions[int(np.flatnonzero(scene.transitions[robot.state] == after)[0])])
    assert task.goals[robot.state, 0]
    assert len(path) - 1 == steps_to_goal(scene.transitions, task.goals[:, 0])[start]


def test_figures_show_it(scene, task):
    sheet = contact_sheet(scene)
    assert sheet.std() > 10
    start = int(task.starts(0)[-1])
    path = scene.poses[shortest_path(scene.transitions, task.goals[:, 0], start)]
    assert figure_image(trajectory_figure(scene, [path], task.goals[:, 0])).std() > 5
    bare = dataclasses.replace(scene, floor_plan=None)
    entropy = np.random.default_rng(0).uniform(0, np.log(len(scene.actions)), len(scene))
    most = float(np.log(len(scene.actions)))
    assert figure_image(entropy_maps(bare, {"policy": [entropy]}, ["end"], most)).std() > 5


def test_arrows_at_the_edge_of_a_scene_without_a_plan_are_whole(scene):
    """Imported scenes have no floor plan: the places alone do not make room for what is drawn at them."""
    bare = dataclasses.replace(scene, floor_plan=None)
    (axes,) = trajectory_figure(bare, [], np.ones(len(bare), bool)).axes
    for low, high, column in ((*axes.get_xlim(), 0), (*axes.get_ylim(), 1)):
        assert low <= bare.poses[:, column].min() - 0.2
        assert high >= bare.poses[:, column].max() + 0.2


def test_a_policy_is_trained_in_it(scene, task):
    torch.set_num_threads(1)
    config = DistilConfig(seed=0, iterations=60, seconds=8.0)
    _, history = LEARNERS["distil"].train([TrainingTask(task, _observations(scene))], config)
    assert history[-1]["success"] > 0.95


def test_an_exact_evaluation_of_shortest_paths_is_what_the_graph_says(scene, task):
    better = task.steps[task.transitions] == task.steps[:, None] - 1  # (S, A, T)
    table = np.where(better.any(1, keepdims=True), better, 1.0).transpose(0, 2, 1).astype(np.float32)
    table /= table.sum(-1, keepdims=True)
    for index, result in enumerate(exact_evaluation(table, task, 500).per_target):
        starts = task.starts(index)
        assert result.success == pytest.approx(1.0)
        assert result.mean_steps == pytest.approx(task.steps[starts, index].mean(), rel=1e-4)


def test_places_that_were_measured_keep_visible_squares():
    """Two that lie 1 cm apart must not make all squares a centimetre wide."""
    grid = np.stack(np.meshgrid(np.arange(4) * 0.3, np.arange(4) * 0.3), -1).reshape(-1, 2)
    assert lattice_spacing(grid) == pytest.approx(0.3)
    assert lattice_spacing(np.vstack([grid, grid[:1] + 0.01])) == pytest.approx(0.15)


def _observations(scene: Scene) -> Observations:
    """Features that say where a view is, in waves, and exact masks."""
    rng = np.random.default_rng(0)
    heading = np.radians(scene.poses[:, 2])
    pose = np.column_stack([scene.poses[:, :2], np.cos(heading), np.sin(heading), scene.poses[:, 3] / 30])
    views = np.maximum(0, np.cos(pose @ rng.normal(size=(5, 64)) * 2 + rng.uniform(0, 6, 64))).astype(np.float32)
    pictures = rng.random((len(scene.targets), 2, 64), np.float32)
    return Observations.from_boxes(views, pictures, scene.boxes)
