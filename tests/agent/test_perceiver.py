"""ActivePerceiver: what a robot runs, without torch, and what it refuses."""

import dataclasses
import itertools
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from active_perceiver.agent.config import AgentConfig, AgentError
from active_perceiver.agent.found_criterion import OPEN_SET_SCORE, FoundCriterion
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.agent.target_matching import PICTURES_FILE
from active_perceiver.envs.task import SearchTask
from active_perceiver.evaluation.object_measures import agent_detections, with_query_pictures
from active_perceiver.live import SearchConfig, search
from active_perceiver.policies.policy import policy_table
from active_perceiver.robots import RecordedRobot
from active_perceiver.scenes import ImageError, decode_image
from active_perceiver.scenes.images import encode_image
from active_perceiver.utils.files import OutputExistsError


@pytest.fixture(scope="module")
def agent(agent_folder) -> ActivePerceiver:
    return ActivePerceiver.from_pretrained(agent_folder)


def test_acting_on_one_image_is_what_the_tables_say(agent, scene):
    """What is measured on tables is what a robot does: same detections, same probabilities, same word."""
    detections = agent_detections(agent)[0]
    threshold = agent.config.score_threshold
    observations = detections.observations(threshold, [1])
    table = policy_table(agent.policy, observations, scene.name, 0)
    for target in range(3):
        for state in range(0, len(scene), 17):
            agent.reset(scene.targets[target].picture(1), seed=0)
            score, box = detections.scores[state, target, 1], detections.boxes[state, target, 1]
            if abs(score - threshold) < 0.01:
                continue  # rounding of cached maps may tip it
            step = agent.act(scene.view(state))
            assert (step.detection is not None) == (score >= threshold)
            if step.detection is not None:
                assert step.detection.score == pytest.approx(score, abs=0.01)
                np.testing.assert_allclose(step.detection.box, box, atol=0.01)
                assert step.found == (step.detection.area >= agent.criterion.area)
            np.testing.assert_allclose(step.probabilities, table[state, target], atol=0.02)


def test_each_picture_is_matched_to_its_target(agent, scene):
    for target in scene.targets:
        agent.reset(target.picture(0))
        known = next(entry for entry in agent.config.targets if entry.name == target.name)
        assert agent.criterion == FoundCriterion(agent.config.score_threshold, known.stop_area_threshold)


def test_an_unknown_picture_needs_more_to_be_found(agent):
    noise = np.random.default_rng(0).integers(0, 255, (64, 64, 3)).astype(np.uint8)
    agent.reset(noise)
    assert agent.criterion == FoundCriterion(OPEN_SET_SCORE, agent.config.stop_area_threshold)
    assert not agent.criterion.met(OPEN_SET_SCORE - 0.01, 1.0)
    assert not agent.criterion.met(1.0, agent.config.stop_area_threshold / 2)
    assert agent.criterion.met(1.0, 1.0)


def test_looking_at_the_same_view_again_makes_it_less_insistent(agent_folder, scene):
    agent = ActivePerceiver.from_pretrained(agent_folder, explore=False)
    agent.reset(scene.targets[0].picture(0), seed=0)
    first, second, third = (agent.act(scene.view(5)).probabilities.max() for _ in range(3))
    assert first > second > third
    agent.reset(scene.targets[0].picture(0), seed=0)
    assert agent.act(scene.view(5)).probabilities.max() == first


def test_a_search_follows_from_its_seed(agent, scene):
    steps = SearchTask.from_scene(scene).steps[:, 0]
    far = np.argsort(-steps, kind="stable")[:12]

    def run(seed):
        paths = []
        for start in far:
            with RecordedRobot(scene, int(start)) as robot:
                record = search(agent, robot, scene.targets[0].picture(0), SearchConfig(max_steps=25, seed=seed))
            paths.append([step_record.pose for step_record in record.step_records])
        return paths

    assert run(1) == run(1)
    assert any(run(1) != run(seed) for seed in range(2, 5))


def test_it_finds_a_ball_and_says_so(agent, scene):
    task = SearchTask.from_scene(scene)
    found, right = 0, 0
    for target in range(3):
        for start in task.starts(target)[::40]:
            with RecordedRobot(scene, int(start)) as robot:
                record = search(
                    agent, robot, scene.targets[target].picture(0), SearchConfig(max_steps=60, seed=int(start))
                )
                found += record.found
                right += record.found and task.areas[robot.state, target] > 0
    assert found >= 5
    assert right >= 0.7 * found


def test_it_gives_up_at_the_limit_when_the_object_is_not_there(agent, scene):
    with RecordedRobot(scene, 0) as robot:
        black = np.zeros((40, 40, 3), np.uint8)
        agent_that_never_believes = dataclasses.replace(agent.config, score_threshold=1.1)
        sceptic = ActivePerceiver(agent.folder, agent_that_never_believes, agent.backbone)
        record = search(sceptic, robot, black, SearchConfig(max_steps=7, seed=0))
    assert not record.found
    assert record.actions == 7


def test_the_robot_is_stopped_whatever_happens(agent, scene):
    class Breaking(RecordedRobot):
        stops = 0

        def execute(self, action):
            raise ConnectionError("the robot is gone")

        def stop(self):
            self.stops += 1

    robot = Breaking(scene, 0)
    with pytest.raises(ConnectionError):
        search(agent, robot, scene.targets[0].picture(0), SearchConfig(seed=0))
    assert robot.stops == 1


@pytest.mark.parametrize("mode", ["RGBA", "L", "P", "exif", "tall"])
def test_pictures_of_every_kind_find_their_target(agent, scene, tmp_path, mode):
    image = Image.fromarray(scene.targets[0].picture(0))
    path = tmp_path / "picture.png"
    options = {}
    if mode == "RGBA":
        image.putalpha(Image.fromarray((np.asarray(image)[..., 1] < 150).astype(np.uint8) * 255))
    elif mode == "exif":
        exif = Image.Exif()
        exif[274] = 8
        options = {"exif": exif}
    elif mode == "tall":
        tall = Image.new("RGB", (48, 120), (215, 215, 215))
        tall.paste(image, (0, 36))
        image = tall
    else:
        image = image.convert(mode)
    image.save(path, **options)
    agent.reset(path, seed=0)
    assert agent.act(scene.view(0)).probabilities.sum() == pytest.approx(1, abs=1e-5)


def test_an_unreadable_picture_is_refused(agent, tmp_path):
    path = tmp_path / "broken.jpg"
    path.write_bytes(b"\xff\xd8\xff broken")
    with pytest.raises(ImageError, match=r"broken\.jpg"):
        agent.reset(path)


def test_act_before_reset_and_unknown_branches_are_refused(agent_folder):
    fresh = ActivePerceiver.from_pretrained(agent_folder)
    with pytest.raises(AgentError, match="call reset"):
        fresh.act(np.zeros((8, 8, 3), np.uint8))
    with pytest.raises(AgentError, match="not trained in 'attic'"):
        fresh.reset(np.zeros((8, 8, 3), np.uint8), scene="attic")


def test_several_branches_need_a_choice(agent):
    config = dataclasses.replace(agent.config, branches={"a": ["MoveAhead"], "b": ["MoveAhead"]})
    with pytest.raises(AgentError, match=r"several scenes \(a, b\)"):
        ActivePerceiver(agent.folder, config, agent.backbone).reset(np.zeros((8, 8, 3), np.uint8))


def test_save_pretrained_copies_and_does_not_overwrite(agent, scene, tmp_path):
    agent.save_pretrained(tmp_path / "copy")
    copy = ActivePerceiver.from_pretrained(tmp_path / "copy")
    agent.reset(scene.targets[1].picture(0), seed=3)
    copy.reset(scene.targets[1].picture(0), seed=3)
    np.testing.assert_array_equal(agent.act(scene.view(9)).probabilities, copy.act(scene.view(9)).probabilities)
    with pytest.raises(OutputExistsError):
        agent.save_pretrained(tmp_path / "copy")


def codes_of(agent):
    return [
        np.hstack([known.embeddings, known.features]) for known in map(agent.gallery.pictures, agent.config.targets)
    ]


def refuse_maps(*_):
    raise AssertionError("the backbone was run")


def test_the_codes_an_agent_is_saved_with_are_those_it_would_compute(agent, tmp_path, monkeypatch):
    agent.save_pretrained(tmp_path / "copy")
    copy = ActivePerceiver.from_pretrained(tmp_path / "copy")
    monkeypatch.setattr(copy.backbone, "maps", refuse_maps)
    stored = codes_of(copy)
    (tmp_path / "copy" / PICTURES_FILE).unlink()
    computed = codes_of(ActivePerceiver.from_pretrained(tmp_path / "copy"))
    assert [embeddings.shape for embeddings in stored] == [embeddings.shape for embeddings in computed]
    for one, other in zip(stored, computed, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5)


CODE_DAMAGES = {
    "empty": lambda path: path.write_bytes(b""),
    "truncated": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "one bit": lambda path: path.write_bytes(path.read_bytes().replace(b"\x93NUMPY", b"\x92NUMPY")),
    "garbled": lambda path: path.write_bytes(
        bytes(value ^ (number % 7 == 0) for number, value in enumerate(path.read_bytes()))
    ),
    "another file": lambda path: path.write_bytes(b"\x93NUMPY but no more than that"),
    "a pickle": lambda path: np.savez(path, embeddings=np.array([{}], object)),
    "a folder": lambda path: (path.unlink(), path.mkdir()),
}


@pytest.mark.parametrize("name", CODE_DAMAGES)
def test_damaged_codes_are_computed_anew(agent, tmp_path, name):
    agent.save_pretrained(tmp_path / "copy")
    CODE_DAMAGES[name](tmp_path / "copy" / PICTURES_FILE)
    for one, other in zip(codes_of(ActivePerceiver.from_pretrained(tmp_path / "copy")), codes_of(agent), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5)


def test_stale_codes_are_computed_anew(agent, scene, tmp_path):
    """One more picture of one target: its codes are computed, the others' are not."""
    agent.save_pretrained(tmp_path / "copy")
    folder = tmp_path / "copy" / "targets" / scene.name / "ball0"
    (folder / "99.webp").write_bytes(scene.targets[1].pictures[0])
    copy = ActivePerceiver.from_pretrained(tmp_path / "copy")
    looked = []
    whole = copy.backbone.maps
    copy.backbone.maps = lambda images: (looked.append(len(images)), whole(images))[1]
    more = dict(zip(copy.config.targets, codes_of(copy), strict=True))
    before = dict(zip(agent.config.targets, codes_of(agent), strict=True))
    assert looked == [len(list(folder.glob("*")))]
    for target, embeddings in more.items():
        assert len(embeddings) == len(before[target]) + (target.name == "ball0")
    copy.gallery.save_pictures()
    fresh = ActivePerceiver.from_pretrained(tmp_path / "copy")
    fresh.backbone.maps = refuse_maps
    for target, embeddings in zip(fresh.config.targets, codes_of(fresh), strict=True):
        np.testing.assert_array_equal(embeddings, more[target])


def test_codes_of_another_recogniser_are_not_taken(agent, tmp_path):
    agent.save_pretrained(tmp_path / "copy")
    path = tmp_path / "copy" / "recogniser.onnx"
    path.write_bytes(path.read_bytes() + b"\x0a\x00")  # the same to ONNX, but another file
    copy = ActivePerceiver.from_pretrained(tmp_path / "copy")
    copy.backbone.maps = refuse_maps
    with pytest.raises(AssertionError, match="backbone was run"):
        codes_of(copy)


def test_an_encoded_image_is_acted_on_as_the_decoded_one(agent, scene):
    data, steps = encode_image(scene.view(9), "png"), []
    for image in (data, scene.view(9)):
        agent.reset(scene.targets[1].picture(0), seed=3)
        steps.append(agent.act(image))
    np.testing.assert_array_equal(steps[0].probabilities, steps[1].probabilities)
    with pytest.raises(ImageError, match="the robot's image"):
        agent.act(data[:50])


def test_decoding_a_large_image_small_changes_no_detection(agent, scene):
    size = 2 * agent.backbone.image_size
    threshold, seen = agent.config.score_threshold, 0
    agent.reset(scene.targets[0].picture(1), seed=0)
    for state in np.argsort(-scene.areas[:, 0])[::4][:20]:  # large, small, and not there at all
        view = np.asarray(Image.fromarray(scene.view(state)).resize((size, size)))
        data = encode_image(view, "jpeg")
        small, whole = agent.act(data).detection, agent.act(decode_image(data)).detection
        if small is not None and whole is not None:
            seen += 1
            assert small.score == pytest.approx(whole.score, abs=0.1)
            np.testing.assert_allclose(small.box, whole.box, atol=0.03)
        else:
            known = small or whole
            assert known is None or known.score < threshold + 0.1
    assert seen >= 3


def test_threads_reach_backbone_and_recogniser(agent_folder, scene, monkeypatch):
    from active_perceiver.vision import sessions

    opened, whole = {}, sessions.onnxruntime.InferenceSession

    def note(data, options, **arguments):
        session = whole(data, options, **arguments)
        opened[session.get_modelmeta().custom_metadata_map["kind"].split("-")[-1]] = options.intra_op_num_threads
        return session

    monkeypatch.setattr(sessions.onnxruntime, "InferenceSession", note)
    ActivePerceiver.from_pretrained(agent_folder, threads=2)
    assert opened == {"backbone": 2, "recogniser": 2, "policy": 1}
    with pytest.raises(AgentError, match="at least 1 thread"):
        ActivePerceiver.from_pretrained(agent_folder, threads=0)


def damage(folder: Path, change) -> None:
    path = folder / "config.json"
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))


DAMAGES = {
    "no config": (lambda folder: (folder / "config.json").unlink(), "not an agent"),
    "no JSON": (lambda folder: (folder / "config.json").write_text("{"), "cannot be read as JSON"),
    "other format": (lambda folder: damage(folder, lambda d: d.update(format="x")), "does not describe an agent"),
    "newer": (lambda folder: damage(folder, lambda d: d.update(version=9)), "has version 9"),
    "field missing": (lambda folder: damage(folder, lambda d: d.pop("backbone")), "lacks backbone"),
    "unknown action": (lambda folder: damage(folder, lambda d: d.update(branches={"a": ["Fly"]})), "damaged"),
    "targets odd": (lambda folder: damage(folder, lambda d: d.update(targets=[{"x": 1}])), "damaged"),
    "no recogniser": (lambda folder: (folder / "recogniser.onnx").unlink(), "lacks recogniser.onnx"),
    "no policy": (lambda folder: (folder / "policy.onnx").unlink(), "lacks policy.onnx"),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damaged_folders_say_what_is_wrong(agent_folder, tmp_path, name):
    folder = tmp_path / "agent"
    shutil.copytree(agent_folder, folder)
    change, message = DAMAGES[name]
    change(folder)
    with pytest.raises(AgentError, match=message):
        ActivePerceiver.from_pretrained(folder)


def test_a_config_survives_the_file(agent, tmp_path):
    agent.config.save(tmp_path)
    assert AgentConfig.load(tmp_path) == agent.config


NO_TORCH = """
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("torch", "embreex", "mitsuba_oidn"):
            raise ImportError(name + " is not on this robot")

sys.meta_path.insert(0, Refuse())
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.robots import RecordedRobot
from active_perceiver.live import SearchConfig, search
from active_perceiver.scenes import open_scene

agent = ActivePerceiver.from_pretrained(sys.argv[1])
scene = open_scene(sys.argv[2])
with RecordedRobot(scene, 3) as robot:
    record = search(agent, robot, scene.targets[0].picture(0), SearchConfig(max_steps=5, seed=0))
assert "torch" not in sys.modules
print(record.actions)
"""


def test_it_runs_where_torch_cannot_be_imported(agent_folder, scene_file):
    done = subprocess.run(
        [sys.executable, "-c", NO_TORCH, str(agent_folder), str(scene_file)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip().isdigit()


def test_a_picture_of_a_known_target_is_taken_for_the_known_one(agent, scene):
    """An unseen picture searches exactly as that picture does which it is taken for; one like none, as itself."""
    target = scene.targets[1]
    unseen, state = target.picture(target.trained), 9
    embedding = agent.recogniser.encode_target(agent.backbone.maps([unseen]))[0]
    agent.gallery._config = dataclasses.replace(agent.config, match_threshold=-1.0)
    try:
        match = agent.gallery.match(embedding, scene.name)
        agent.reset(unseen, seed=0)
        as_known = agent.act(scene.view(state))
        agent.reset(scene.targets[scene.target_index(match.target.name)].picture(match.picture), seed=0)
        np.testing.assert_allclose(as_known.probabilities, agent.act(scene.view(state)).probabilities, atol=1e-5)
        agent.gallery._config = dataclasses.replace(agent.config, match_threshold=1.1)
        assert agent.gallery.match(embedding, scene.name) is None
        agent.reset(unseen, seed=0)
        alone = agent.act(scene.view(state)).probabilities
        assert np.abs(alone - as_known.probabilities).max() > 1e-5
    finally:
        agent.gallery._config = agent.config


def test_the_tables_with_unseen_pictures_are_what_the_agent_sees(agent, scene):
    seen = agent_detections(agent)[0]
    taken = with_query_pictures(agent, seen)
    for target, number in itertools.product(range(3), seen.held_out_pictures):
        agent.reset(scene.targets[seen.targets[target]].picture(number), seed=0)
        for state in range(0, len(scene), 23):
            step = agent.act(scene.view(state))
            score = taken.scores[state, target, number]
            if abs(score - agent.config.score_threshold) > 0.02:
                assert (step.detection is not None) == (score >= agent.config.score_threshold)
    trained = seen.trained_pictures
    np.testing.assert_array_equal(taken.scores[:, :, trained], seen.scores[:, :, trained])
