"""`benchmark robustness`: what is changed, that an agent's tables are what it would do, and the command, tiny."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from active_perceiver.agent.config import AgentConfig, KnownTarget
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.agent.training_record import TrainingRecord
from active_perceiver.benchmarks.act.untrained_agent import save_untrained_agent
from active_perceiver.benchmarks.config import RobustnessConfig
from active_perceiver.benchmarks.robustness import measure as robustness
from active_perceiver.benchmarks.robustness import perturbations
from active_perceiver.benchmarks.robustness.measure import chosen_conditions, format_robustness, measure_robustness
from active_perceiver.benchmarks.robustness.perturbations import CLEAN, CONDITIONS, Condition
from active_perceiver.benchmarks.robustness.perturbed_detections import Queries, look_around, views_of_new_places
from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.detections import detect_all_views
from active_perceiver.evaluation.object_measures import measure_agent
from active_perceiver.policies.policy import policy_table
from active_perceiver.scenes import Scene, save_scene
from active_perceiver.scenes.images import encode_image
from active_perceiver.vision import Backbone
from active_perceiver.vision.cache import scene_features
from helpers.toy import toy_scene

NAMES = ("ball2", "ball0")
GREY = np.full((40, 50, 3), 128, np.uint8)


@pytest.fixture(scope="module")
def folder(scene: Scene, scene_file: Path, backbone: Backbone, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An agent with random weights that notes what a trained one does."""
    folder = tmp_path_factory.mktemp("robustness") / "agent"
    save_untrained_agent(folder, backbone, scene, NAMES)
    held_out = np.flatnonzero(scene.positions % 4 == 0).tolist()
    notes = TrainingRecord(scenes=(str(scene_file),), held_out_views={scene.name: held_out})
    known = [KnownTarget(scene.name, name, 0.02) for name in NAMES]
    replace(
        AgentConfig.load(folder), training=notes, targets=known, stop_area_threshold=0.02, match_threshold=0.5
    ).save(folder)
    return folder


@pytest.fixture(scope="module")
def agent(folder: Path) -> ActivePerceiver:
    return ActivePerceiver.from_pretrained(folder)


@pytest.fixture(scope="module")
def asked(agent: ActivePerceiver, scene: Scene) -> Queries:
    return Queries.of(agent, scene, NAMES)


def no_rooms(scene: Scene, out: Path, hour: str | None, moved: int | None) -> None:
    raise AssertionError("nothing is to be rendered")


def applied(name: str, image: np.ndarray, seed: int = 0) -> np.ndarray:
    change = CONDITIONS[name].image
    assert change is not None
    before = image.copy()
    changed = change(image, np.random.default_rng(seed))
    np.testing.assert_array_equal(image, before)
    assert changed.dtype == np.uint8
    assert changed.shape == image.shape
    return changed


@pytest.mark.parametrize("name", [name for name, condition in CONDITIONS.items() if condition.image])
def test_changes_of_images_follow_their_seed_and_change_something(name: str, scene: Scene) -> None:
    view = scene.view(3)
    changed = applied(name, view, seed=5)
    np.testing.assert_array_equal(changed, applied(name, view, seed=5))
    assert (changed != view).any()
    assert np.corrcoef(changed.ravel(), view.ravel())[0, 1] > 0.5  # still a picture of the same


def test_noise_is_as_strong_as_it_says() -> None:
    for sigma in (10, 25):
        noise = applied(f"noise {sigma}", GREY).astype(float) - 128
        assert noise.std() == pytest.approx(sigma, rel=0.05)
        assert abs(noise.mean()) < 1


def test_blur_spreads_a_point_as_far_as_it_says() -> None:
    point = np.zeros((41, 41, 3), np.uint8)
    point[20, 20] = 255
    far = np.abs(np.arange(41) - 20)
    wide = applied("motion blur 9", point)[..., 0]
    assert (wide > 0).sum() == 9
    assert (wide[20] > 0).sum() == 9
    spread = [(applied(f"blur {sigma}", point)[20, :, 0] > 0) * far for sigma in (1, 2)]
    assert 0 < spread[0].max() < spread[1].max()


def test_light_is_halved_doubled_and_coloured() -> None:
    halved, doubled = (applied(name, GREY)[0, 0, 0] / 255 for name in ("darker", "brighter"))
    light = (128 / 255) ** 2.2
    assert halved**2.2 == pytest.approx(light / 2, rel=0.03)
    assert doubled**2.2 == pytest.approx(light * 2, rel=0.03)
    red, green, blue = applied("warm cast", GREY)[0, 0].tolist()
    assert red > green == 128 > blue
    assert (applied("brighter", np.full((4, 4, 3), 250, np.uint8)) == 255).all()


@pytest.fixture
def detections() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    scores = np.where(rng.random((300, 2, 4)) < 0.4, 0.9, 0.1).astype(np.float32)
    scores[:, 1, 3] = 0.1
    return scores, rng.random((300, 2, 4, 4)).astype(np.float32)


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_detections_go_missing(detections: Any, share: float) -> None:
    scores, boxes = detections
    fewer, same = perturbations.missing(scores, boxes, 0.5, np.random.default_rng(1), share)
    np.testing.assert_array_equal(same, boxes)
    seen = scores >= 0.5
    assert (fewer[seen] < 0.5).mean() == pytest.approx(share, abs=0.05)
    assert not (fewer >= 0.5)[~seen].any()


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_wrong_detections_are_those_of_other_views(detections: Any, share: float) -> None:
    scores, boxes = detections
    kept = scores.copy(), boxes.copy()
    said, where = perturbations.wrong(scores, boxes, 0.5, np.random.default_rng(1), share)
    np.testing.assert_array_equal(scores, kept[0])
    np.testing.assert_array_equal(boxes, kept[1])
    changed = (where != boxes).any(-1)
    assert changed[:, 0].mean() == pytest.approx(share, abs=0.05)
    assert not changed[:, 1, 3].any()  # it is seen nowhere
    assert (said[changed] >= 0.5).all()
    np.testing.assert_array_equal(said[~changed], scores[~changed])
    for view, target, picture in np.argwhere(changed):
        originals = boxes[scores[:, target, picture] >= 0.5, target, picture]
        assert (originals == where[view, target, picture]).all(-1).any()


@pytest.mark.parametrize("name", [CLEAN, "noise 25", "JPEG 20"])
def test_tables_are_what_the_agent_does(name: str, agent: ActivePerceiver, asked: Queries, scene: Scene) -> None:
    change = CONDITIONS[name].image
    seen = look_around(agent, asked, scene, change, seed=7)
    threshold = agent.config.score_threshold
    observations = seen.observations(threshold, seen.trained_pictures)
    said_found = []
    for target, name_of_it in enumerate(NAMES):
        for picture in (0, 1):
            table = policy_table(agent.policy, observations, scene.name, picture)
            criterion = agent.gallery.criterion(agent.gallery.match(asked.embeddings[target, picture], scene.name))
            for state in (0, 17, 101):
                view = scene.view(state)
                if change is not None:
                    view = change(view, np.random.default_rng([7, state]))
                agent.reset(scene.targets[scene.target_index(name_of_it)].picture(picture))
                step = agent.act(view)
                assert step.detection is not None
                assert step.detection.score == pytest.approx(seen.scores[state, target, picture], abs=1e-3)
                np.testing.assert_allclose(step.detection.box, seen.boxes[state, target, picture], atol=1e-3)
                np.testing.assert_allclose(step.probabilities, table[state, target], atol=1e-3)
                area = np.prod(seen.boxes[state, target, picture, 2:])
                assert step.found == criterion.met(seen.scores[state, target, picture], area)
                said_found.append(step.found)
    assert any(said_found)


def test_the_plain_condition_is_the_usual_measurement(
    agent: ActivePerceiver, asked: Queries, scene: Scene, tmp_path: Path
) -> None:
    settings = RobustnessConfig(searches=30, limit=50, work=tmp_path)
    body = measure_robustness(agent, settings, {CLEAN: CONDITIONS[CLEAN]}, no_rooms)
    (row,) = body["conditions"]
    cached = detect_all_views(scene, scene_features(scene, agent.backbone), agent.recogniser, NAMES)
    usual = measure_agent(agent, [cached], EvaluateConfig(limit=50, searches=30))
    assert row["success"] == pytest.approx(usual.policy.overall.success, abs=1e-3)
    assert row["auroc"] == pytest.approx(usual.detection["pictures_seen"].auroc, abs=1e-2)
    assert row["true_found"] + row["false_found"] + row["not_found"] == pytest.approx(1)
    word = usual.stops["pictures_seen"].overall
    assert row["not_found"] == pytest.approx(word["not_found"], abs=0.1)


def test_recognition_is_judged_in_places_that_are_new(agent: ActivePerceiver, asked: Queries, scene: Scene) -> None:
    """Whatever the numbers of the views: here the room is seen from the other end first, and from one more place."""
    seen = look_around(agent, asked, scene)
    back = np.arange(len(scene))[::-1]
    poses = scene.poses[back].copy()
    poses[0, 0] += 10.0
    there = replace(seen, scene=replace(scene, poses=poses, views=[scene.views[state] for state in back]))
    held_out = agent.config.training.held_out_views[scene.name]
    trained = np.setdiff1d(np.arange(len(scene)), held_out)
    trained_places = {tuple(place) for place in scene.poses[trained, :2].round(2).tolist()}
    new = [state for state, place in enumerate(poses[:, :2].round(2).tolist()) if tuple(place) not in trained_places]
    assert len(new) > len(held_out)
    assert views_of_new_places(agent, [asked], [there]) == {scene.name: new}
    assert 0 in new


def test_rooms_are_rendered_where_there_is_no_file_and_kept(
    agent: ActivePerceiver, scene: Scene, tmp_path: Path
) -> None:
    rendered: list[tuple[str | None, int | None]] = []

    def render(base: Scene, out: Path, hour: str | None, moved: int | None) -> None:
        rendered.append((hour, moved))
        save_scene(darker(base) if hour else replace(toy_scene(3), name="other"), out)

    settings = RobustnessConfig(searches=10, limit=50, work=tmp_path)
    conditions = {name: CONDITIONS[name] for name in (CLEAN, "dusk", "moved 1", "wrong 30 %")}
    body = measure_robustness(agent, settings, conditions, render)
    assert rendered == [("dusk", None), (None, 1)]
    plain, dusk, moved, wrong = body["conditions"]
    assert plain["shortest_mean"] == pytest.approx(dusk["shortest_mean"], abs=2)  # where it is found it is as far
    assert {row["scene"] for row in moved["per_target"]} == {scene.name}
    assert plain["auroc"] != dusk["auroc"] != wrong["auroc"]
    measure_robustness(agent, settings, conditions, render)
    assert len(rendered) == 2
    text = format_robustness(body)
    assert all(name in text for name in conditions)


def darker(scene: Scene) -> Scene:
    views = [encode_image((scene.view(state) // 2).astype(np.uint8), "png") for state in range(len(scene))]
    return replace(scene, views=tuple(views), name="darker")


def test_what_is_measured_is_kept_for_resuming(
    agent: ActivePerceiver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = RobustnessConfig(searches=10, limit=50, work=tmp_path)
    conditions = {CLEAN: CONDITIONS[CLEAN]}
    first = measure_robustness(agent, settings, conditions, no_rooms)

    def never(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(robustness, "look_around", never)
    assert measure_robustness(agent, settings, conditions, no_rooms, resume=True) == first
    with pytest.raises(KeyboardInterrupt):
        measure_robustness(agent, settings, conditions, no_rooms)
    with pytest.raises(KeyboardInterrupt):  # another protocol is another measurement
        measure_robustness(agent, replace(settings, searches=11), conditions, no_rooms, resume=True)


def test_given_files_take_the_place_of_rendered_rooms() -> None:
    given = RobustnessConfig(other_hour=(Path("a/night.h5"),), moved=(Path("tidy.h5"),))
    conditions = chosen_conditions(given)
    assert next(iter(conditions)) == CLEAN
    assert not any(one.hour or one.moved for one in conditions.values())
    assert conditions["night"].file == Path("a/night.h5")
    assert conditions["night"].same_boxes
    assert not conditions["tidy"].same_boxes
    assert list(chosen_conditions(replace(given, conditions=("tidy",)))) == [CLEAN, "tidy"]


def test_another_room_is_not_another_hour(agent: ActivePerceiver, tmp_path: Path) -> None:
    path = tmp_path / "night.h5"
    save_scene(toy_scene(3), path)
    settings = RobustnessConfig(searches=5, limit=20, work=tmp_path)
    with pytest.raises(UserError, match="everything where it was"):
        measure_robustness(agent, settings, {"night": Condition("night", file=path, same_boxes=True)}, no_rooms)


def test_the_command_writes_result_and_picture(
    folder: Path, scene_file: Path, scene: Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, picture, night = tmp_path / "robust.json", tmp_path / "robust.png", tmp_path / "night.h5"
    save_scene(darker(scene), night)
    arguments = ["benchmark", "robustness", str(folder), "--conditions", "noise 25", "night", "--searches", "20"]
    arguments += ["--other-hour", str(night), "--work", str(tmp_path / "work"), "--limit", "50"]
    assert main([*arguments, "--out", str(out), "--picture", str(picture)]) == 0
    result = json.loads(out.read_text())
    assert result["command"] == "benchmark robustness"
    assert [row["condition"] for row in result["conditions"]] == [CLEAN, "noise 25", "night"]
    assert format_robustness(result) in capsys.readouterr().out
    assert Image.open(picture).format == "PNG"
    assert main([*arguments, "--out", str(out)]) == 2
    assert "--force" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "is not an agent"),
        (["AGENT", "--conditions", "fog"], "there is no condition ['fog']"),
        (["AGENT", "--conditions", "dusk"], "was not rendered by this software"),
        (["AGENT", "--moved", "lost.h5", "--conditions", "lost"], "nor a scene file"),
    ],
)
def test_wrong_input_is_explained(
    arguments: list[str], message: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [str(folder) if part == "AGENT" else part for part in arguments]
    assert main(["benchmark", "robustness", *given, "--work", str(tmp_path), "--searches", "5", "--limit", "20"]) == 2
    error = " ".join(capsys.readouterr().err.split())
    assert message in error
    assert "Traceback" not in error


def test_help_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["benchmark", "robustness", "--help"])
    assert stopped.value.code == 0
    assert "active-perceiver benchmark robustness" in capsys.readouterr().out.split("Examples:")[1]
