"""What a robot behind rosbridge is like: presets, YAML files, and files that make no sense."""

import math

import pytest
import yaml

from active_perceiver.robots.ros.config import Joint, RosConfigError, same_type
from active_perceiver.robots.ros.config_file import load_config, presets, save_config
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS
from active_perceiver.utils.files import OutputExistsError

SMALLEST = {"camera": {"topic": "/image"}, "velocity": {"topic": "/cmd_vel"}, "odometry": {"topic": "/odom"}}
TILT = {"topic": "/tilt"}


def loaded(tmp_path, settings):
    path = tmp_path / "robot.yaml"
    path.write_text(settings if isinstance(settings, str) else yaml.safe_dump(settings))
    return load_config(path)


def test_the_presets():
    assert presets() == ("turtlebot2", "turtlebot3", "turtlebot4")
    for name in presets():
        settings = load_config(name)
        assert settings.policy_actions == TURTLEBOT_ACTIONS
        assert settings.limits.speed <= 0.25
    assert load_config("turtlebot2").velocity.topic == "/mobile_base/commands/velocity"
    assert load_config("turtlebot4").velocity.stamped


def test_most_of_a_file_may_be_left_out(tmp_path):
    settings = loaded(tmp_path, SMALLEST)
    assert settings.tilts == (0.0,)
    assert settings.tilt is None
    assert not settings.velocity.stamped
    tilting = loaded(tmp_path, {**SMALLEST, "tilt": TILT, "tilts": [-30, 0, 30], "actions": "eight", "pan": None})
    assert tilting.policy_actions == EIGHT_ACTIONS
    assert tilting.tilts == (-30.0, 0.0, 30.0)


def test_what_is_saved_is_loaded_again(tmp_path):
    path = tmp_path / "robot.yaml"
    tilting = loaded(tmp_path, {**SMALLEST, "tilt": {**TILT, "sign": -1}, "tilts": [-30, 0, 30], "stamps": False})
    for settings in (*map(load_config, presets()), tilting):
        save_config(settings, path, force=True)
        assert load_config(path) == settings
    with pytest.raises(OutputExistsError, match="--force"):
        save_config(settings, path)


def test_the_angle_of_a_joint():
    joint = Joint("/tilt", sign=-1, rest=0.5)
    assert joint.value(30) == pytest.approx(0.5 - math.radians(30))
    assert joint.degrees(joint.value(-20)) == pytest.approx(-20)
    assert Joint("/tilt", unit="degrees", rest=90).value(30) == 120


def test_names_of_types():
    assert same_type("geometry_msgs/Twist", "geometry_msgs/msg/Twist")
    assert not same_type("geometry_msgs/Twist", "geometry_msgs/TwistStamped")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"speed": 1}, "unknown key 'speed'"),
        ({"camera": {"topic": "/image", "crop": 0.5, "fov": 60}}, "'camera' has the unknown key 'fov'"),
        ({"camera": {}}, "'camera' lacks 'topic'"),
        ({"camera": None}, "'camera' must hold topic"),
        ({"camera": "/image"}, "'camera' must hold topic"),
        ({"camera": {"topic": "image"}}, "camera: topic must be a name"),
        ({"camera": {"topic": "/image", "type": "sensor_msgs/Image"}}, "type must be sensor_msgs/CompressedImage"),
        ({"camera": {"topic": "/image", "crop": 0}}, "camera: crop must be"),
        ({"camera": {"topic": "/image", "max_image_age": 0.1}}, "max_image_age must be at least"),
        ({"velocity": {"topic": "/v", "type": "nav_msgs/Odometry"}}, "velocity: type must be geometry_msgs/Twist or"),
        ({"odometry": {"topic": 7}}, r"'odometry\.topic' must be a text"),
        ({"tilts": [0, 30]}, "tilts must be a single one"),
        ({"tilts": [30, 0], "tilt": TILT}, "tilts must be a rising list"),
        ({"tilts": [], "tilt": TILT}, "tilts must be a rising list"),
        ({"tilts": 0}, "'tilts' must be a list"),
        ({"tilts": [0, "up"], "tilt": TILT}, "'tilts' must be a number"),
        ({"tilt": {**TILT, "sign": 2}}, "tilt: sign must be 1 or -1"),
        ({"tilt": {**TILT, "sign": 1.0}}, r"'tilt\.sign' must be a whole number"),
        ({"tilt": {**TILT, "unit": "turns"}}, "unit must be radians or degrees"),
        ({"pan": {**TILT, "type": "std_msgs/Int16"}}, "pan: type must be std_msgs/Float64"),
        ({"step": float("nan")}, "'step' must be a number, got nan"),
        ({"step": "0.5 m"}, "'step' must be a number"),
        ({"step": True}, "'step' must be a number, got True"),
        ({"step": 2.0}, "step must be above 0 and at most the limit 'distance'"),
        ({"turn": 70}, "turn must be a part of 360"),
        ({"actions": "seven"}, "actions must be six or eight"),
        ({"settle": -1}, "settle must be"),
        ({"stamps": "yes"}, "'stamps' must be true or false"),
        ({"limits": {"speed": 5}}, "limits: the limit 'speed'"),
        ({"limits": {"speed": float("inf")}}, r"'limits\.speed' must be a number"),
        ({"limits": {"power": 5}}, "'limits' has the unknown key 'power'"),
        ({"connection": {"attempts": 1.5}}, r"'connection\.attempts' must be a whole number"),
        ({"connection": {"timeout": 0}}, "connection: timeout must be"),
    ],
)
def test_settings_that_make_no_sense_are_refused(tmp_path, change, said):
    with pytest.raises(RosConfigError, match=rf"robot\.yaml: .*{said}"):
        loaded(tmp_path, {**SMALLEST, **change})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "must hold camera"),
        ("- 1", "must hold camera"),
        ("camera: [", "not YAML at line"),
        ("limits: {speed: 0.1}\nlimits: {speed: 1.0}", "key 'limits' is there twice"),
        ("a: !!python/object/apply:os.system [ls]", "not YAML"),
        ("1: 2", "unknown key 1"),
        ("[" * 1000, r"not YAML|nested too deeply"),
    ],
)
def test_files_that_are_none_are_refused(tmp_path, text, said):
    with pytest.raises(RosConfigError, match=said):
        loaded(tmp_path, text)


def test_a_missing_file_names_the_presets(tmp_path):
    with pytest.raises(RosConfigError, match="turtlebot2, turtlebot3, turtlebot4"):
        load_config(tmp_path / "none.yaml")
    (tmp_path / "image.yaml").write_bytes(b"\xff\xd8\xff\xe0")
    with pytest.raises(RosConfigError, match="it is not text"):
        load_config(tmp_path / "image.yaml")
