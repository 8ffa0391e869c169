"""`reproduce`: everything small from end to end, and what its tables are made of."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from active_perceiver.cli.main import main
from active_perceiver.envs import location_mask
from active_perceiver.errors import UserError
from active_perceiver.policies.evaluation import exact_evaluation
from active_perceiver.reproduction.cells import Cell, Cells, cells_of
from active_perceiver.reproduction.config import ReproduceConfig
from active_perceiver.reproduction.paper import TABLE_1
from active_perceiver.reproduction.paper_figures import expected_length
from active_perceiver.reproduction.policy_inputs import PolicyInputs
from active_perceiver.reproduction.setups import FULL, METHODS, QUICK
from active_perceiver.reproduction.tables import format_table_1, mean_and_interval, table_1, table_2
from active_perceiver.scenes import open_scene
from active_perceiver.vision.backbone import load_backbone

pytestmark = pytest.mark.xdist_group("reproduction")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("reproduction")
    assert main(["reproduce", "all", "--quick", "--out", str(out)]) == 0
    return out


def read(path):
    return json.loads(path.read_text())


def test_everything_is_written(folder):
    names = {path.name for path in folder.iterdir() if path.is_file()}
    assert names == {
        "table1.json", "table1.md", "table2.json", "table2.md", "curves.json", "curves.png", "entropy.json",
        "entropy.png", "trajectories.json", "trajectories.png", "choices.json", "choices.md",
    }  # fmt: skip
    assert not list(folder.rglob("*.checkpoint"))
    assert not list(folder.rglob("*.part*"))


def test_table_1_has_every_setup_method_and_learner_over_all_seeds(folder):
    table = read(folder / "table1.json")
    keys = {(row["setup"], row["method"], row["learner"]) for row in table["rows"]}
    learned = [name for name, method in METHODS.items() if method.reward]
    expected = {
        (setup, method, learner) for setup in QUICK.setups for method in learned for learner in ("a3c", "ppo")
    }
    assert keys == expected | {(setup, "random", None) for setup in QUICK.setups}
    assert {row["seeds"] for row in table["rows"]} == {QUICK.seeds}
    assert set(table["recogniser"]) == {"conference_room", "living_room_2"}
    text = (folder / "table1.md").read_text()
    assert text.count("record reward, low exploration") == 2 * len(QUICK.setups)
    assert "52.9 / 100.0 %" in text


def test_table_2_has_a_row_for_each_target(folder):
    rows = read(folder / "table2.json")["rows"]
    targets = {target for names in QUICK.setups["four_objects"].searches.values() for target in names}
    assert {row["target"] for row in rows} == targets
    assert len(rows) == 2 * 2 * len(targets)


def test_the_random_walk_is_measured_exactly_and_by_episodes(folder):
    [path] = folder.glob("cells/four_objects-random-0-*.json")
    cell = read(path)
    goal_observations = PolicyInputs(
        folder / "recognisers", load_backbone("efficientnet_lite0", image_size=QUICK.image_size), QUICK.recogniser,
        QUICK.folds, "recogniser",
    )  # fmt: skip
    task = goal_observations.training_task("conference_room", ("mug", "bag")).task
    walk = np.full((len(task), 2, 6), 1 / 6)
    exact = exact_evaluation(walk, task, QUICK.limit).overall
    assert cell["exact"]["overall"]["success"] == pytest.approx(exact.success, rel=1e-5)
    assert cell["exact"]["overall"]["mean_steps"] == pytest.approx(exact.mean_steps, rel=1e-5)
    sampled = cell["sampled"]
    assert sampled["protocol"]["episodes"] == QUICK.episodes
    assert sampled["overall"]["success"] * 2 * QUICK.episodes == pytest.approx(
        round(sampled["overall"]["success"] * 2 * QUICK.episodes), abs=1e-4
    )


def test_what_is_done_is_not_run_again_and_time_limits_stop_between_trainings(folder, capsys):
    before = {path: path.stat().st_mtime_ns for path in folder.glob("cells/*")}
    assert main(["reproduce", "table2", "--quick", "--out", str(folder)]) == 0
    assert {path: path.stat().st_mtime_ns for path in folder.glob("cells/*")} == before
    command = ["reproduce", "table2", "--quick", "--out", str(folder), "--learners", "ppo", "--seeds", "4"]
    assert main([*command, "--minutes", "0.0001"]) == 1
    assert "6 of 8 trainings are done" not in capsys.readouterr().err  # one was begun before time was up
    assert len(set(folder.glob("cells/*.json")) - set(before)) <= 2
    assert main(command) == 0
    assert len(set(folder.glob("cells/*.json")) - set(before)) == 4
    assert read(folder / "table2.json")["rows"][0]["seeds"] == 4


def test_curves_entropy_and_paths_hold_what_they_show(folder):
    curves = read(folder / "curves.json")
    assert len(curves["curves"]) == 8
    for curve in curves["curves"]:
        assert np.shape(curve["lengths"]) == (QUICK.seeds, len(curve["iterations"]))
        assert curve["iterations"][-1] in (QUICK.setups["four_objects"].updates, QUICK.ppo.iterations)
        assert np.min(curve["lengths"]) >= curves["shortest"] > 1
    entropy = read(folder / "entropy.json")
    for row in entropy["rows"]:
        assert row["mean_entropy"]["start"] == pytest.approx(np.log(6), abs=0.02)
        assert max(row["mean_entropy"].values()) <= entropy["most"] == pytest.approx(np.log(6))
    paths = read(folder / "trajectories.json")
    assert len(paths["searches"]) == 2 * 2 * 4  # learners, targets, starts
    assert len(paths["stuck"]) == 2 * 2
    assert all(0 < some["share"] <= 1 and some["area"] < 1.5 for some in paths["stuck"])  # they are not yet trained
    assert all(path["actions"] >= path["shortest"] > 0 for path in paths["searches"] if path["success"])
    for name in ("curves", "entropy", "trajectories"):
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_who_is_stuck_agrees_with_the_exact_success(folder):
    [path] = folder.glob("cells/four_objects-record_low-ppo-0-*.json")
    success = [target["success"] for target in read(path)["exact"]["per_target"]]
    stuck = [some for some in read(folder / "trajectories.json")["stuck"] if "ppo" in some["cell"]]
    # The stored policy is rounded, hence not quite the same.
    np.testing.assert_allclose([1 - some["share"] for some in stuck], success, atol=0.02)


def test_another_setting_is_another_cell(tmp_path):
    backbone = load_backbone("efficientnet_lite0", image_size=QUICK.image_size)
    goal_observations = PolicyInputs(tmp_path, backbone, QUICK.recogniser, QUICK.folds, "ground-truth")
    cell = Cell("one_object", "record_low", "ppo", 0)
    paths = {
        Cells(tmp_path, scale, some)._path(cell, "json")
        for scale in (QUICK, replace(QUICK, limit=400), replace(QUICK, ppo=replace(QUICK.ppo, gamma=0.9)))
        for some in (goal_observations, PolicyInputs(tmp_path, backbone, QUICK.recogniser, QUICK.folds, "recogniser"))
    }
    assert len(paths) == 6


def test_true_boxes_can_be_shown_instead(tmp_path):
    backbone = load_backbone("efficientnet_lite0", image_size=QUICK.image_size)
    goal_observations = PolicyInputs(tmp_path, backbone, QUICK.recogniser, QUICK.folds, "ground-truth")
    scene = open_scene("conference_room")
    training_task = goal_observations.training_task("conference_room", ("bag",))
    expected = location_mask(scene.boxes[:, scene.target_index("bag")])
    np.testing.assert_array_equal(training_task.observations.masks[:, 0, 0], expected)
    assert not list(tmp_path.iterdir())


def test_cells_are_all_combinations_once():
    cells = cells_of(tuple(FULL.setups), tuple(METHODS), ("a3c", "ppo"), 3)
    assert len(cells) == len(set(cells)) == 4 * (1 + 4 * 2) * 3
    assert len({cell.name for cell in cells}) == len(cells)


def test_intervals_are_students():
    values = [3.0, 5.0, 4.5, 3.9]
    summary = mean_and_interval([*values, None])
    low, high = stats.t.interval(0.95, 3, np.mean(values), stats.sem(values))
    assert summary["mean"] == pytest.approx(np.mean(values))
    assert summary["mean"] - summary["half"] == pytest.approx(low)
    assert summary["mean"] + summary["half"] == pytest.approx(high)
    assert mean_and_interval([2.0]) == {"mean": 2.0, "half": None, "n": 1}
    assert mean_and_interval([None]) == {"mean": None, "half": None, "n": 0}


def made_up(success, steps):
    figures = {"success": success, "mean_steps": steps, "ratio": steps and steps / 5, "spl": 0.5}
    part = {"overall": figures, "per_target": [{"target": "bread", **figures}]}
    return {"sampled": part, "exact": part, "history": [{"samples": 7}], "seconds": 1.0}


def test_tables_show_failure_as_a_dash_and_keep_the_papers_figures_beside_ours():
    cells = [Cell("one_object", "reward_2", "a3c", seed) for seed in (0, 1)]
    rows = table_1({cells[0]: made_up(0.0, None), cells[1]: made_up(0.0, None)})
    assert rows[0]["paper"] == {"mean_steps": TABLE_1["one_object"]["reward_2"][0], "success": 0.0}
    text = format_table_1(rows, FULL)
    assert "| A3C | - / 0.0 % | - / 0.0 ± 0.0 % |" in text
    [row] = table_2({Cell("four_objects", "record_high", "ppo", 0): made_up(0.5, 60.0)})
    assert row["paper"] == {"mean_steps": 2566.1, "success": 0.8}
    assert row["sampled"]["mean_steps"] == {"mean": 60.0, "half": None, "n": 1}


def test_failures_count_as_the_limit():
    assert expected_length({"success": 0.75, "mean_steps": 100.0}, 5000) == pytest.approx(75 + 1250)
    assert expected_length({"success": 0.0, "mean_steps": float("nan")}, 5000) == 5000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"seeds": 0}, "at least one seed"),
        ({"learners": ()}, "name at least one learner"),
        ({"minutes": 0.0}, "minutes must be positive"),
    ],
)
def test_says_what_is_wrong_with_settings(arguments, message):
    with pytest.raises(UserError, match=message):
        ReproduceConfig(**arguments)


def test_the_command_line_says_it_too(capsys, tmp_path):
    assert main(["reproduce", "table1", "--out", str(tmp_path), "--backbone", "no_such"]) == 2
    assert "no_such" in capsys.readouterr().err
