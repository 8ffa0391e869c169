"""`benchmark robot`: what its rows say, on searches that are made up; the searches themselves in a small room."""

from __future__ import annotations

from pathlib import Path

import pytest

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import RobotBenchmarkConfig
from active_perceiver.benchmarks.robot import measure as benchmark
from active_perceiver.benchmarks.robot.measure import RobotBenchmark
from active_perceiver.benchmarks.robot.report import format_robot
from active_perceiver.benchmarks.robot.worker import Conditions, Lab, _astray, search_once, targets_in
from active_perceiver.benchmarks.runner import OutputFiles, run_benchmark
from active_perceiver.errors import UserError
from active_perceiver.parallel.process_pool import ProcessExecutor
from active_perceiver.scenes import Action
from active_perceiver.simulation.diff_drive import OdometryNoise
from active_perceiver.simulation.simulated_robot import nearest_pose
from active_perceiver.utils.files import OutputExistsError
from helpers.simulated_place import simulated, small_room
from indoor_rooms.layouts import LayoutError


def test_wilson_is_the_interval_of_the_book():
    # Brown, Cai and DasGupta 2001, https://doi.org/10.1214/ss/1009213286: it is never empty, not even at the ends.
    assert benchmark.wilson(0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)
    assert benchmark.wilson(10, 10) == pytest.approx((0.7225, 1.0), abs=1e-4)
    assert benchmark.wilson(195, 200) == pytest.approx((0.9428, 0.9893), abs=1e-4)


def end(target="mug", *, found=True, true=True, actions=5, off=(0.1, 4.0), collisions=0):
    return {
        "target": target, "found": found, "true": true, "actions": actions, "metres_off": off[0],
        "degrees_off": off[1], "collisions": collisions,
    }  # fmt: skip


def test_a_row_counts_true_and_false_ones():
    lost = end("bowl", found=False, true=False, collisions=4)
    ends = [end(), end(actions=7, off=(0.3, 8.0)), end("bowl", true=False), lost]
    row = benchmark._measured(ends)
    assert (row["searches"], row["true_found"], row["false_found"], row["not_found"]) == (4, 0.5, 0.25, 0.25)
    assert row["actions"] == 6
    assert row["metres_off"] == pytest.approx([0.15, 0.3])
    assert row["degrees_off"] == [5.0, 8.0]
    assert row["collisions"] == 1
    assert row["per_target"] == {"mug": 1.0, "bowl": 0.0}
    assert benchmark._measured([end(found=False, true=False)])["actions"] is None


def test_the_table_says_it():
    row = {**benchmark._measured([end(), end(found=False, true=False)]), "label": "off the lattice"}
    protocol = {
        "room": "kitchen_1", "targets": ["mug"], "max_steps": 100, "centimetres": 10, "degrees": 8, "nudge": 0.05,
        "true_iou": 0.5,
    }  # fmt: skip
    text = format_robot({"protocol": protocol, "rows": [row]})
    assert "off the lattice" in text
    assert "50.0 (" in text
    assert "within 10 cm and 8 degrees" in text


def test_a_robot_that_does_not_slip_is_where_it_planned_to_be():
    robot = simulated()
    for action in (Action.MOVE_AHEAD, Action.ROTATE_RIGHT, Action.MOVE_BACK):
        robot.execute(action)
    metres, degrees = _astray((2.3, 1.5, 0.0, 0.0), robot)
    assert metres < 0.03
    assert degrees < 2
    aside = simulated((2.3, 1.5, 8.0, 0.0), odometry_noise=OdometryNoise(), seed=2)
    aside.execute(Action.MOVE_AHEAD)
    metres, degrees = _astray((2.3, 1.4, 0.0, 0.0), aside)
    assert 0.05 < metres < 0.3
    assert 4 < degrees < 14


def test_the_nearest_pose_is_one_of_the_lattice():
    room = small_room()
    places = room.places()
    x, z = places[3]
    assert nearest_pose(room, (x + 0.05, z - 0.08, 356.0, 12.0)) == (x, z, 0.0, 0.0)
    assert nearest_pose(room, (x, z, 136.0, -16.0))[2:] == (180.0, -30.0)


def test_an_agent_of_another_room_is_refused(agent_folder: Path):
    with pytest.raises(UserError, match="was not trained in kitchen_1, but in toy_0"):
        RobotBenchmark([agent_folder], RobotBenchmarkConfig(room="kitchen_1", starts=1, compared=1)).prepare()


def test_what_is_wrong_with_a_room_is_said_by_the_process_that_opens_it(agent_folder: Path):
    nowhere = Conditions(0.0, 0.0, odometry_noise=False, nudge=0.0)
    lab = Lab(agent_folder, "kitchen_1_hour_never", nowhere, RobotBenchmarkConfig())
    with pytest.raises(LayoutError, match="no hour of the day 'never'"):
        list(ProcessExecutor(1).map(search_once, [0], lab))


def test_an_agent_has_its_own_targets_in_each_room(agent_folder: Path):
    agent = ActivePerceiver.from_pretrained(agent_folder)
    assert targets_in(agent, "toy_0") == [target.name for target in agent.config.targets]
    assert targets_in(agent, "kitchen_1") == []


def test_nothing_is_overwritten_and_nonsense_is_refused(tmp_path: Path):
    (tmp_path / "robot.json").write_text("mine")
    with pytest.raises(OutputExistsError):
        run_benchmark(RobotBenchmark([tmp_path], RobotBenchmarkConfig()), OutputFiles(tmp_path / "robot.json"))
    with pytest.raises(UserError, match="at least one agent"):
        RobotBenchmark([], RobotBenchmarkConfig()).prepare()
    with pytest.raises(UserError, match="must be at least 1"):
        RobotBenchmark([tmp_path], RobotBenchmarkConfig(starts=0)).prepare()
