"""An agent that takes two views in a row to say found: against the rule, told in a loop, and where it is refused."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from active_perceiver.agent.config import AgentError
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.cli.main import main
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.object_measures import agent_detections, with_query_pictures
from active_perceiver.evaluation.stop_tables import evaluate_stops


@pytest.mark.parametrize("target", range(3))
def test_found_needs_the_last_other_view_to_be_nearly_enough(agent_folder, scene, target):
    plain = ActivePerceiver.from_pretrained(agent_folder, explore=False)
    careful = ActivePerceiver.from_pretrained(agent_folder, confirm=True, explore=False)
    picture = scene.targets[target].picture(0)
    for agent in (plain, careful):
        agent.reset(picture, seed=0)
    goal = plain.search(picture).goal
    largest = np.argsort(-scene.areas[:, target])[:8]
    far = np.flatnonzero(scene.areas[:, target] == 0)[:2]
    rng = np.random.default_rng(target)
    states = np.concatenate([largest[[0, 0]], far[[0]], rng.choice([*largest, *far], 40)])
    words, before, previous = [], False, None
    for state in states:
        found = plain.act(scene.view(state)).found
        if previous is not None and previous[0] != state:
            before = previous[1]
        words.append(careful.act(scene.view(state)).found)
        assert words[-1] == (found and before)
        goal_observation = goal.observe(plain.backbone.maps([scene.view(state)]))
        previous = (state, goal_observation.nearly)
        assert goal_observation.nearly or not goal_observation.found
    assert not words[0]
    assert not words[1]


def test_a_new_search_starts_unconfirmed(agent_folder, scene):
    agent = ActivePerceiver.from_pretrained(agent_folder, confirm=True, explore=False)
    best = np.argsort(-scene.areas[:, 0])[:12]
    agent.reset(scene.targets[0].picture(0), seed=0)
    said = [agent.act(scene.view(state)).found for state in best]
    assert any(said)
    for state in best:
        agent.reset(scene.targets[0].picture(0), seed=0)
        assert not agent.act(scene.view(state)).found


def test_two_views_take_longer(agent_folder):
    agent = ActivePerceiver.from_pretrained(agent_folder, explore=False)
    asked = [(with_query_pictures(agent, seen), seen.trained_pictures) for seen in agent_detections(agent)]
    one, two = (
        evaluate_stops(agent, asked, EvaluateConfig(confirm=confirm, explore=False)) for confirm in (False, True)
    )
    by_one, by_two = ({row.target: row for row in measured.per_target} for measured in (one, two))
    assert by_one.keys() == by_two.keys()
    for name, row in by_two.items():
        assert row.false_found <= by_one[name].false_found
    steps = [[row.mean_steps for row in rows.values() if np.isfinite(row.mean_steps)] for rows in (by_one, by_two)]
    assert np.mean(steps[1]) > np.mean(steps[0])


def test_an_agent_that_searches_for_views_does_not_confirm(agent_folder, tmp_path):
    folder = shutil.copytree(agent_folder, tmp_path / "views")
    config = json.loads((folder / "config.json").read_text())
    (folder / "config.json").write_text(json.dumps({**config, "task": "view", "found_similarity": 0.99}))
    with pytest.raises(AgentError, match="leave out confirm"):
        ActivePerceiver.from_pretrained(folder, confirm=True)


def test_search_takes_it_from_the_command_line(agent_folder, scene, scene_file, tmp_path, capsys):
    picture = tmp_path / "picture.jpg"
    picture.write_bytes(scene.targets[0].pictures[0])
    agent = ActivePerceiver.from_pretrained(agent_folder, explore=False)
    agent.reset(picture)
    goal = next(state for state in np.argsort(-scene.areas[:, 0]) if agent.act(scene.view(state)).found)
    arguments = ["search", str(agent_folder), "--picture", str(picture), "--robot", f"scene:{scene_file}"]
    arguments += ["--start", str(goal), "--seed", "0", "--max-steps", "1"]
    main(arguments)
    assert "found after 0 actions" in capsys.readouterr().out
    main([*arguments, "--confirm"])
    assert "found after 0 actions" not in capsys.readouterr().out
