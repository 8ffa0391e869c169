"""`export`: a folder that runs where nothing but numpy, onnxruntime and pillow is installed, and what it refuses."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from active_perceiver.agent.checksums import CHECKSUMS_FILE
from active_perceiver.agent.config import AgentError
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.exported.clean_environment import clean_variables, make_clean_environment
from active_perceiver.benchmarks.exported.report import format_exported
from active_perceiver.cli.main import main
from active_perceiver.deploy import try_agent
from active_perceiver.deploy.export import export_agent
from active_perceiver.errors import UserError
from active_perceiver.live import SearchConfig, search
from active_perceiver.robots import RecordedRobot
from active_perceiver.scenes import SceneError
from active_perceiver.utils.files import OutputExistsError
from active_perceiver.vision.backbone import pooled

pytestmark = pytest.mark.xdist_group("export")

ROBOT = """
import json
import sys
from pathlib import Path

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.robots import Robot
from active_perceiver.live import SearchConfig, search
from active_perceiver.scenes import (Action, read_image)


class FileRobot:
    def __init__(self, folder, start):
        self.folder, self.state = folder, start
        self.moves = json.loads((folder / "moves.json").read_text())

    actions = tuple(Action)

    def look(self):
        return read_image(self.folder / f"{self.state}.png")

    def execute(self, action):
        before, self.state = self.state, self.moves[self.state][self.actions.index(action)]
        return self.state != before

    def pose(self):
        return None

    def stop(self):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()


agent = ActivePerceiver.from_pretrained(sys.argv[1])
views, searches = Path(sys.argv[2]), []
for target in range(3):
    for start in (3, 100):
        with FileRobot(views, start) as robot:
            assert isinstance(robot, Robot)
            config = SearchConfig(max_steps=40, seed=start)
            record = search(agent, robot, read_image(views / f"target_{target}.png"), config)
        searches.append([[taken.step.action.value for taken in record.step_records], record.found])
packages = {name.split(".")[0] for name in sys.modules} - set(sys.stdlib_module_names)
print(json.dumps({"searches": searches, "packages": sorted(packages)}))
"""


@pytest.fixture(scope="module")
def exported(agent_folder, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("exported") / "toy_robot"
    assert main(["export", str(agent_folder), str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def exported_int8(agent_folder, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("exported") / "toy_int8"
    assert main(["export", str(agent_folder), str(folder), "--int8"]) == 0
    return folder


@pytest.fixture(scope="module")
def clean_python(tmp_path_factory) -> Path:
    """The interpreter of an environment without anything that a robot need not have."""
    try:
        return make_clean_environment(tmp_path_factory.mktemp("clean") / "environment")
    except UserError as error:
        pytest.skip(str(error))


def run(python: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(python), *arguments], env=clean_variables(), capture_output=True, text=True, check=False
    )


def same_decisions(one: ActivePerceiver, other: ActivePerceiver, scene) -> None:
    for target in scene.targets:
        one.reset(target.picture(0), seed=0)
        other.reset(target.picture(0), seed=0)
        for state in range(0, len(scene), 23):
            ours, theirs = one.act(scene.view(state)), other.act(scene.view(state))
            np.testing.assert_array_equal(ours.probabilities, theirs.probabilities)
            assert (ours.found, ours.action) == (theirs.found, theirs.action)


def test_it_holds_what_runs_and_nothing_else(exported, agent_folder, scene):
    assert {path.name for path in exported.iterdir()} == {
        "README.md", "backbone.onnx", "checksums.json", "config.json", "known_pictures.npz", "maps", "policy.onnx",
        "recogniser.onnx", "targets",
    }  # fmt: skip
    assert not list(exported.parent.glob(".*"))
    sums = json.loads((exported / CHECKSUMS_FILE).read_text())["sha256"]
    files = {path.relative_to(exported).as_posix() for path in exported.rglob("*") if path.is_file()}
    assert sums.keys() == files - {CHECKSUMS_FILE}
    same_decisions(ActivePerceiver.from_pretrained(exported), ActivePerceiver.from_pretrained(agent_folder), scene)


def test_its_backbone_is_its_own(exported, tmp_path, monkeypatch):
    monkeypatch.setenv("ACTIVE_PERCEIVER_CACHE", str(tmp_path / "nothing"))
    assert ActivePerceiver.from_pretrained(exported).backbone.path == exported / "backbone.onnx"
    assert not (tmp_path / "nothing").exists()


def test_it_searches_where_only_three_packages_are(exported, agent_folder, scene, clean_python, tmp_path):
    for state in range(len(scene)):
        (tmp_path / f"{state}.png").write_bytes(scene.views[state])
    for number, target in enumerate(scene.targets):
        (tmp_path / f"target_{number}.png").write_bytes(target.pictures[0])
    (tmp_path / "moves.json").write_text(json.dumps(scene.transitions.tolist()))
    (tmp_path / "robot.py").write_text(ROBOT)
    done = run(clean_python, str(tmp_path / "robot.py"), str(exported), str(tmp_path))
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    agent, expected = ActivePerceiver.from_pretrained(agent_folder), []
    for target in scene.targets:
        for start in (3, 100):
            config = SearchConfig(max_steps=40, seed=start)
            record = search(agent, RecordedRobot(scene, start), target.picture(0), config)
            expected.append([[step_record.step.action.value for step_record in record.step_records], record.found])
    assert said["searches"] == expected
    assert any(found for _, found in expected)
    assert {"numpy", "onnxruntime", "PIL", "active_perceiver"} <= set(said["packages"])
    brought = {"h5py", "scipy", "gymnasium", "torch", "rich", "tyro", "platformdirs", "typing_extensions"}
    assert not brought & set(said["packages"])


def test_one_image_can_be_tried_there(exported, scene, clean_python, tmp_path):
    (tmp_path / "frame.png").write_bytes(scene.views[5])
    (tmp_path / "picture.png").write_bytes(scene.targets[1].pictures[0])
    tried = ("-m", "active_perceiver.deploy.try_agent", str(exported), "--picture", str(tmp_path / "picture.png"))
    done = run(clean_python, *tried, str(tmp_path / "frame.png"))
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    agent = ActivePerceiver.from_pretrained(exported)
    agent.reset(scene.targets[1].picture(0), seed=0)
    step = agent.act(scene.view(5))
    assert (said["action"], said["found"]) == (step.action.value, step.found)
    assert (said["score"] is None) == (step.detection is None)


def test_what_is_not_there_is_explained_there(agent_folder, clean_python, monkeypatch):
    """An agent that was not exported looks for its backbone in a cache, a scene is read by h5py: neither is there."""
    monkeypatch.delenv("ACTIVE_PERCEIVER_CACHE")
    load = "import sys; from active_perceiver.agent.perceiver import ActivePerceiver"
    load += "; ActivePerceiver.from_pretrained(sys.argv[1])"
    done = run(clean_python, "-c", load, str(agent_folder))
    assert "BackboneError" in done.stderr.splitlines()[-1]
    assert "`active-perceiver export`" in done.stderr.splitlines()[-1]
    done = run(clean_python, "-c", "from active_perceiver.scenes import open_scene; open_scene('kitchen_1')")
    assert "SceneError" in done.stderr.splitlines()[-1]
    assert "pip install h5py" in done.stderr.splitlines()[-1]


def test_images_one_after_the_other_are_a_search(exported, scene, tmp_path, capsys):
    frames = []
    for state in (0, 7, 0):
        frames.append(str(tmp_path / f"{state}.png"))
        (tmp_path / f"{state}.png").write_bytes(scene.views[state])
    (tmp_path / "picture.png").write_bytes(scene.targets[0].pictures[0])
    assert try_agent.main([str(exported), "--picture", str(tmp_path / "picture.png"), *frames]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["frame"] for line in lines] == frames
    agent = ActivePerceiver.from_pretrained(exported)
    agent.reset(scene.targets[0].picture(0), seed=0)
    assert [line["action"] for line in lines] == [agent.act(scene.view(state)).action.value for state in (0, 7, 0)]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"agent": "nowhere"}, "is not an agent"),
        ({"frame": "nowhere.png"}, "nowhere.png"),
        ({"picture": "nowhere.png"}, "nowhere.png"),
        ({"scene": "attic"}, "was not trained in 'attic'"),
    ],
)
def test_trying_with_wrong_input_is_explained(wrong, message, exported, scene, tmp_path, capsys):
    (tmp_path / "frame.png").write_bytes(scene.views[0])
    given = {"agent": str(exported), "frame": str(tmp_path / "frame.png"), "picture": str(tmp_path / "frame.png")}
    given |= {"scene": scene.name} | wrong
    arguments = [given["agent"], given["frame"], "--picture", given["picture"], "--scene", given["scene"]]
    assert try_agent.main(arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert message in said


def test_its_readme_says_how_to_run_it(exported, scene, monkeypatch):
    text = (exported / "README.md").read_text()
    assert "pip install numpy onnxruntime pillow\n" in text
    assert "pip install --no-deps" in text
    (tried,) = (line for line in text.splitlines() if line.startswith("python -m active_perceiver.deploy.try_agent"))
    name, picture = tried.split()[3], tried.split()[5]
    assert name == exported.name
    assert (exported.parent / picture).is_file()
    block = text.split("```python\n")[1].split("```")[0]
    assert f'SearchConfig(scene="{scene.name}")' in block
    monkeypatch.chdir(exported.parent)
    ran = {"robot": RecordedRobot(scene, seed=0)}
    exec(compile(block, "README.md", "exec"), ran)
    assert ran["record"].found


def test_nothing_is_replaced_by_accident(agent_folder, exported, tmp_path):
    with pytest.raises(OutputExistsError, match="--force to replace"):
        export_agent(agent_folder, exported)
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "holiday.jpg").touch()
    with pytest.raises(OutputExistsError, match="is not an agent and will not be replaced"):
        export_agent(agent_folder, tmp_path / "photos", force=True)
    for folder in (agent_folder, agent_folder.parent):
        with pytest.raises(OutputExistsError, match="holds the agent itself"):
            export_agent(agent_folder, folder, force=True)
    assert (agent_folder / "policy.safetensors").is_file()


def test_force_replaces_an_agent_whole(agent_folder, tmp_path):
    out = tmp_path / "robot"
    out.mkdir()
    (out / "config.json").touch()
    (out / "old.txt").touch()
    assert main(["export", str(agent_folder), str(out), "--force"]) == 0
    assert not (out / "old.txt").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["robot"]
    ActivePerceiver.from_pretrained(out)


def test_an_agent_without_maps_is_exported_without(agent_folder, tmp_path, scene):
    bare = tmp_path / "bare"
    shutil.copytree(agent_folder, bare)
    shutil.rmtree(bare / "maps")
    export_agent(bare, tmp_path / "robot")
    assert not (tmp_path / "robot" / "maps").exists()
    assert ActivePerceiver.from_pretrained(tmp_path / "robot").room(scene.name) is None


def test_an_exported_agent_can_be_exported_again(exported, tmp_path):
    export_agent(exported, tmp_path / "again")
    again, before = ((folder / CHECKSUMS_FILE).read_text() for folder in (tmp_path / "again", exported))
    names = [json.loads(text)["sha256"] for text in (again, before)]
    assert {name: names[0][name] for name in names[0] if name != "README.md"} == {
        name: names[1][name] for name in names[1] if name != "README.md"
    }


@pytest.mark.parametrize("name", ["backbone.onnx", "policy.onnx", "config.json", "maps/toy_0.npz"])
def test_a_damaged_file_is_named(name, exported, tmp_path):
    shutil.copytree(exported, tmp_path / "robot")
    path = tmp_path / "robot" / name
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    with pytest.raises(AgentError, match=f"{name} is damaged.*copy or export the agent again"):
        ActivePerceiver.from_pretrained(tmp_path / "robot")


def test_missing_files_and_checksums_are_named(exported, tmp_path):
    shutil.copytree(exported, tmp_path / "robot")
    (tmp_path / "robot" / "known_pictures.npz").unlink()
    with pytest.raises(AgentError, match=r"known_pictures.npz cannot be read \(No such file"):
        ActivePerceiver.from_pretrained(tmp_path / "robot")
    for content in ("", "[]", "{}", '{"sha256": 3}', '{"sha256": ["a"]}'):
        (tmp_path / "robot" / CHECKSUMS_FILE).write_text(content)
        with pytest.raises(AgentError, match=r"checksums\.json is damaged"):
            ActivePerceiver.from_pretrained(tmp_path / "robot")
    (tmp_path / "robot" / CHECKSUMS_FILE).unlink()
    ActivePerceiver.from_pretrained(tmp_path / "robot")  # what is missing can be computed


def test_a_copy_keeps_its_checksums(exported, tmp_path):
    ActivePerceiver.from_pretrained(exported).save_pretrained(tmp_path / "copy")
    assert (tmp_path / "copy" / CHECKSUMS_FILE).read_bytes() == (exported / CHECKSUMS_FILE).read_bytes()


def test_eight_bits_are_smaller_and_nearly_the_same(exported, exported_int8, scene):
    sizes = [(folder / "backbone.onnx").stat().st_size for folder in (exported_int8, exported)]
    assert sizes[0] < 0.5 * sizes[1]
    small, full = (ActivePerceiver.from_pretrained(folder) for folder in (exported_int8, exported))
    views = [scene.view(state) for state in range(0, len(scene), 9)]
    ours, theirs = (pooled(agent.backbone.maps(views)) for agent in (small, full))
    cosines = (ours * theirs).sum(axis=1) / np.linalg.norm(ours, axis=1) / np.linalg.norm(theirs, axis=1)
    assert not np.array_equal(ours, theirs)
    assert cosines.min() > 0.98


def test_eight_bits_are_made_once(exported_int8, tmp_path):
    with pytest.raises(UserError, match="has 8-bit numbers already"):
        export_agent(exported_int8, tmp_path / "again", int8=True)
    export_agent(exported_int8, tmp_path / "copy")
    ours, theirs = ((folder / "backbone.onnx").read_bytes() for folder in (tmp_path / "copy", exported_int8))
    assert ours == theirs


def test_eight_bits_know_their_pictures(exported_int8, scene, monkeypatch):
    """Their codes depend on the backbone; computed when the first search begins, they would delay it."""
    agent, looked = ActivePerceiver.from_pretrained(exported_int8), []
    maps = agent.backbone.maps
    monkeypatch.setattr(agent.backbone, "maps", lambda images: looked.append(len(images)) or maps(images))
    agent.reset(scene.targets[2].picture(0))
    assert looked == [1]


def test_a_scene_can_set_the_eight_bits(agent_folder, scene_file, exported_int8, tmp_path):
    export_agent(agent_folder, tmp_path / "by_scene", int8=True, calibrate=str(scene_file))
    ours, theirs = ((folder / "backbone.onnx").read_bytes() for folder in (tmp_path / "by_scene", exported_int8))
    assert ours != theirs
    with pytest.raises(SceneError, match="neither a bundled scene"):
        export_agent(agent_folder, tmp_path / "other", int8=True, calibrate="attic")
    with pytest.raises(UserError, match="with --int8 only"):
        export_agent(agent_folder, tmp_path / "other", calibrate=str(scene_file))
    assert not (tmp_path / "other").exists()


def test_eight_bits_without_onnx_name_the_extra(agent_folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "onnx", None)
    assert main(["export", str(agent_folder), str(tmp_path / "robot"), "--int8"]) == 2
    assert "pip install 'active-perceiver[train]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_an_agent_without_its_pictures_is_refused(agent_folder, tmp_path, scene):
    shutil.copytree(agent_folder, tmp_path / "agent")
    shutil.rmtree(tmp_path / "agent" / "targets" / scene.name / "ball0")
    with pytest.raises(AgentError, match="agent holds no pictures of 'ball0'"):
        export_agent(tmp_path / "agent", tmp_path / "robot")
    shutil.rmtree(tmp_path / "agent" / "targets")
    with pytest.raises(AgentError, match="agent holds no pictures of 'ball0'"):
        export_agent(tmp_path / "agent", tmp_path / "robot")
    assert [path.name for path in tmp_path.iterdir()] == ["agent"]


def test_no_agent_is_refused(tmp_path, capsys):
    assert main(["export", str(tmp_path / "nowhere"), str(tmp_path / "robot")]) == 2
    assert "is not an agent" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_benchmark_measures_both(agent_folder, clean_python, tmp_path, capsys):
    out, picture = tmp_path / "export.json", tmp_path / "export.png"
    arguments = ["benchmark", "export", str(agent_folder), "--repeats", "2", "--starts", "1", "--searches", "2"]
    outputs = ["--frame", "64", "48", "--out", str(out), "--picture", str(picture)]
    assert main([*arguments, "--python", str(clean_python), *outputs]) == 0
    result = json.loads(out.read_text())
    assert result["command"] == "benchmark export"
    full, small = result["agents"]["fp32"], result["agents"]["int8"]
    for one in (full, small):
        assert one["megabytes"]["all"] == pytest.approx(
            sum(size for part, size in one["megabytes"].items() if part != "all"), rel=1e-4
        )
        start, here = one["cold_start"], one["cold_start_here"]
        assert 0 < start["checking"] < start["whole"]
        assert one["start_ratio"] == pytest.approx(start["whole"] / here["whole"], rel=1e-4)
        assert 0 <= one["evaluation"]["overall"]["success"] <= 1
    assert small["megabytes"]["backbone"] < 0.5 * full["megabytes"]["backbone"]
    trained = json.loads((agent_folder / "result.json").read_text())
    assert full["evaluation"]["overall"]["success"] == pytest.approx(trained["overall"]["success"], abs=1e-3)
    assert format_exported(result) in capsys.readouterr().out
    assert Image.open(picture).format == "PNG"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [(["nowhere"], "is not an agent"), (["nowhere", "--repeats", "0"], "must be at least 1")],
)
def test_the_benchmark_explains_wrong_input(arguments, message, capsys):
    assert main(["benchmark", "export", *arguments]) == 2
    assert message in capsys.readouterr().err
