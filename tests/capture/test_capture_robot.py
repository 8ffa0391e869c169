"""A robot that takes the photographs: the folder that it writes, what is in its way, interruptions, marks, ROS."""

import json

import numpy as np
import pytest
from PIL import Image

from active_perceiver.capture.robot import SIGN, photograph_places
from active_perceiver.capture.tour import PlacesError, grid_poses, seen_from
from active_perceiver.cli.main import main
from active_perceiver.datasets.photos.pose_table import read_poses, write_poses
from active_perceiver.datasets.photos.reader import PhotoConfig, import_photos
from active_perceiver.robots import NavigatingRobot, RecordedRobot
from active_perceiver.robots.ros.config_file import save_config
from active_perceiver.scenes.images import decode_image
from active_perceiver.scenes.scene import SceneError
from active_perceiver.simulation.diff_drive import OdometryNoise
from active_perceiver.simulation.simulated_robot import SimulatedRobot
from active_perceiver.utils.files import OutputExistsError
from helpers.bridge import comes_to_rest, served, view, with_
from helpers.simulated_place import NO_NOISE, small_room

# Four by three places; those at x 0.95 and 1.45 and z 0.4 and 0.9 are where the table is.
FIRST = (0.45, 0.4, 0.0, 0.0)
POSES = grid_poses(4, 3, 0.5, 4, (-30.0, 0.0))
AT_TABLE = tuple(f"IMG_{number + 1:04}.jpg" for number in range(96) if number // 8 in (3, 4, 6, 7))
TWO = grid_poses(1, 2, 0.4, 2, (0.0,))


class Watched(SimulatedRobot):
    """Remembers how far it truly was beside what it was sent to when it looked; may be interrupted."""

    def __init__(self, start=FIRST, odometry_noise=NO_NOISE, looks=None, seed=0):
        super().__init__(small_room(), start, odometry_noise=odometry_noise, seed=seed)
        self.began, self.looks, self.asked = self.pose(), looks, None
        self.off: list[tuple[float, float, float]] = []

    def go_to(self, *pose):
        self.asked = pose
        return super().go_to(*pose)

    def look(self):
        if len(self.off) == self.looks:
            raise KeyboardInterrupt
        x, z, heading, tilt = seen_from(np.array([self.began, self.pose()]), 0)[1] - self.asked
        self.off.append((np.hypot(x, z), abs((heading + 180) % 360 - 180), abs(tilt)))
        return super().look()


def table_of(tmp_path, poses=POSES):
    path = tmp_path / "plan.csv"
    write_poses(path, [f"IMG_{number:04}.jpg" for number in range(1, len(poses) + 1)], poses)
    return read_poses(path)


def taken(folder):
    return sorted(path.name for path in folder.glob("*.jpg"))


def test_it_photographs_every_pose_but_those_in_the_furniture(tmp_path):
    table, folder, robot = table_of(tmp_path), tmp_path / "photos", Watched()
    done = photograph_places(robot, table, folder)
    assert done.blocked == AT_TABLE
    assert (done.taken, done.there, done.left, done.next) == (64, 64, (), None)
    assert taken(folder) == sorted(set(table.files) - set(AT_TABLE))
    beside, heading, tilt = np.array(robot.off).max(axis=0)
    assert beside < 0.11  # nowhere farther than what still counts as there
    assert np.median(np.array(robot.off)[:, 0]) < 0.02
    assert heading < 2.5
    assert tilt == 0
    # It is back, and stands.
    assert robot.pose() == pytest.approx((0.45, 0.4, robot.pose()[2], -30), abs=0.02)
    assert not robot.body.moving
    # Each photograph shows what is seen from its own pose, and not from another.
    number = table.files.index("IMG_0090.jpg")
    x, z, turn, up = POSES[number]
    shown = decode_image((folder / "IMG_0090.jpg").read_bytes()).astype(float)
    errors = {}
    for other in range(0, 360, 90):
        image, _ = small_room().look((FIRST[0] + x, FIRST[1] + z, other, up))
        errors[other] = np.abs(image - shown).mean()
    assert min(errors, key=errors.get) == turn
    assert errors[turn] < 12


def test_the_folder_is_imported_once_there_are_pictures_of_targets(tmp_path):
    folder = tmp_path / "photos"
    (folder / "targets" / "mug").mkdir(parents=True)
    Image.new("RGB", (32, 32)).save(folder / "targets" / "mug" / "1.jpg")
    photograph_places(Watched(), table_of(tmp_path), folder)
    scene = import_photos(folder, PhotoConfig(image_size=32)).scene
    assert len(scene) == 64
    np.testing.assert_allclose(scene.poses, np.delete(POSES, [int(n[4:8]) - 1 for n in AT_TABLE], 0), atol=1e-5)


def test_with_slip_it_drifts_and_marks_help(tmp_path):
    poses = POSES[[f"IMG_{number:04}.jpg" not in AT_TABLE for number in range(1, 97)]]
    table = table_of(tmp_path, poses)
    whole = Watched(odometry_noise=OdometryNoise(), seed=3)
    photograph_places(whole, table, tmp_path / "whole")
    beside, at, runs, start = [], None, 0, FIRST
    while True:
        robot = Watched(start, odometry_noise=OdometryNoise(), seed=3)
        done = photograph_places(robot, table, tmp_path / "marked", at=at, at_once=2, resume=runs > 0)
        runs += 1
        beside += [one[0] for one in robot.off]
        if done.next is None:
            break
        at = table.files[done.next]
        x, z, heading, tilt = poses[done.next]
        # It waits near the mark for somebody to put it there.
        assert np.hypot(robot.body.x - FIRST[0] - x, robot.body.z - FIRST[1] - z) < 0.3
        start = (FIRST[0] + x, FIRST[1] + z, heading, tilt)
    assert runs == 4
    assert done.blocked == ()
    assert len(taken(tmp_path / "marked")) == 64
    assert np.mean(beside) < 0.06
    assert np.mean(beside) < np.mean([one[0] for one in whole.off])


def test_interrupted_it_stops_and_goes_on_with_what_is_missing(tmp_path, caplog):
    table, folder = table_of(tmp_path), tmp_path / "photos"
    with pytest.raises(KeyboardInterrupt), Watched(looks=11) as robot:
        photograph_places(robot, table, folder)
    assert "11 of 96 photographs" in caplog.text
    robot.body.wait(1)
    assert not robot.body.moving
    first = {name: (folder / name).stat().st_mtime_ns for name in taken(folder)}
    assert len(first) == 11
    # The table names those that are there, as they were meant.
    there = read_poses(folder / "poses.csv")
    assert set(there.files) == set(first)
    np.testing.assert_allclose(there.poses, POSES[[table.files.index(name) for name in there.files]])
    (folder / ".IMG_0050.jpg.half.part.jpg").write_bytes(b"half")  # as a killed process leaves it
    with pytest.raises(OutputExistsError, match="--resume takes those that are missing"):
        photograph_places(Watched(), table, folder)
    done = photograph_places(Watched(), table, folder, resume=True)
    assert (done.taken, done.there) == (53, 64)
    assert {name: (folder / name).stat().st_mtime_ns for name in first} == first
    again = photograph_places(Watched(), table, folder, resume=True)
    assert (again.taken, again.there, again.blocked) == (0, 64, AT_TABLE)


def test_other_places_are_not_mixed_in_and_force_takes_all_anew(tmp_path):
    folder, few = tmp_path / "photos", table_of(tmp_path, TWO)
    photograph_places(Watched(), few, folder)
    other = table_of(tmp_path, np.add(TWO, (0, 0, 0, -30)))
    with pytest.raises(OutputExistsError, match="begun with other places"):
        photograph_places(Watched(), other, folder, resume=True)
    (folder / "notes.txt").write_text("mine")
    before = {name: (folder / name).stat().st_mtime_ns for name in taken(folder)}
    assert photograph_places(Watched(), other, folder, force=True).taken == 4
    assert all((folder / name).stat().st_mtime_ns != time for name, time in before.items())
    assert (folder / "notes.txt").read_text() == "mine"
    np.testing.assert_allclose(read_poses(folder / "poses.csv").poses, other.poses)


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize(
    ("name", "text"), [("IMG_0002.jpg", "mine"), ("poses.csv", "mine"), (SIGN, "{}"), (SIGN, "[[")]
)
def test_what_no_capture_wrote_is_never_replaced(tmp_path, name, text, force):
    folder = tmp_path / "photos"
    folder.mkdir()
    (folder / name).write_text(text)
    with pytest.raises(OutputExistsError, match="that no capture wrote"):
        photograph_places(Watched(), table_of(tmp_path, TWO), folder, force=force, resume=force)
    assert {path.name: path.read_text() for path in folder.iterdir()} == {name: text}


def test_a_sign_that_names_files_elsewhere_deletes_nothing(tmp_path):
    folder, mine = tmp_path / "photos", tmp_path / "mine.jpg"
    folder.mkdir()
    mine.write_text("mine")
    noted = {"format": "active-perceiver-capture", "version": 1, "files": ["../mine.jpg"], "poses": [[0, 0, 0, 0]]}
    (folder / SIGN).write_text(json.dumps(noted))
    with pytest.raises(OutputExistsError, match="that no capture wrote"):
        photograph_places(Watched(), table_of(tmp_path, TWO), folder, force=True)
    assert mine.exists()


@pytest.mark.parametrize("name", ["../IMG_1.jpg", "/tmp/IMG_1.jpg", "IMG_1.png", "a/IMG_1.jpg", ".jpg", "poses.csv"])
def test_names_that_no_photograph_should_have_are_refused(tmp_path, name):
    (tmp_path / "plan.csv").write_text(f"file,x,z,heading\n{name},0,0,0\n")
    with pytest.raises(PlacesError, match="line 2: a photograph cannot be called"):
        photograph_places(Watched(), read_poses(tmp_path / "plan.csv"), tmp_path / "photos")
    assert not (tmp_path / "photos").exists()


def test_what_the_robot_cannot_do_is_refused_before_it_moves(tmp_path):
    robot = Watched()
    with pytest.raises(PlacesError, match="line 2: the robot has no tilt of -60 degrees, its tilts are -30, 0, 30"):
        photograph_places(robot, table_of(tmp_path, np.add(TWO, (0, 0, 0, -60))), tmp_path / "photos")
    with pytest.raises(PlacesError, match="no photograph 'IMG_0009"):
        photograph_places(robot, table_of(tmp_path, TWO), tmp_path / "photos", at="IMG_0009.jpg")
    with pytest.raises(PlacesError, match="places at once are 1 or more"):
        photograph_places(robot, table_of(tmp_path, TWO), tmp_path / "photos", at_once=0)
    in_centimetres = np.multiply(grid_poses(1, 3, 0.5, 1, (0.0,)), (100, 100, 1, 1))
    with pytest.raises(PlacesError, match=r"line 3: .* to x 0, z 50 there are no places at most 10 m apart"):
        photograph_places(robot, table_of(tmp_path, in_centimetres), tmp_path / "photos")
    assert robot.body.time == 0
    assert not (tmp_path / "photos").exists()


def test_tables_without_names_number_the_photographs(tmp_path):
    (tmp_path / "plan.csv").write_text("x;z;heading\n0;0,5;0\n0;1;90\n")
    assert read_poses(tmp_path / "plan.csv", naming=True).files == ("IMG_0001.jpg", "IMG_0002.jpg")
    (tmp_path / "named.csv").write_text("file,x,z,heading\n,0,0,0\nb.jpg,0,0,90\n,1,0,0\n")
    assert read_poses(tmp_path / "named.csv", naming=True).files == ("IMG_0001.jpg", "b.jpg", "IMG_0003.jpg")
    for name, said in (("plan.csv", "column 'file' is missing"), ("named.csv", "file is empty")):
        with pytest.raises(SceneError, match=said):
            read_poses(tmp_path / name)


def test_a_robot_behind_rosbridge_takes_them_too(tmp_path, capsys):
    (tmp_path / "plan.csv").write_text("x,z,heading,tilt\n2,3,90,0\n2.4,3,90,-30\n2.4,3,180,0\n")
    settings = with_(limits={"distance": 0.5})
    save_config(settings, tmp_path / "robot.yaml")
    folder = tmp_path / "photos"
    with served(settings) as bridge:
        bridge.body.x, bridge.body.z = 5.0, -1.0  # the odometry does not know
        options = ["--robot-config", tmp_path / "robot.yaml", "--places", tmp_path / "plan.csv", "--out", folder]
        code = main(["scenes", "capture", "robot", f"ros:{bridge.url}", *map(str, options)])
        assert code == 0
        assert comes_to_rest(bridge.body)
    printed = capsys.readouterr().out
    assert "3 of 3 photographs, 3 of them taken now" in printed
    assert "back where it began" in printed
    # The robot's ahead is the table's x.
    for name, pose in (("IMG_0001.jpg", (5, -1, 0, 0)), ("IMG_0002.jpg", (5, -0.6, 0, -30)),
                       ("IMG_0003.jpg", (5, -0.6, 90, 0))):  # fmt: skip
        shown = decode_image((folder / name).read_bytes()).reshape(-1, 3).mean(0)
        np.testing.assert_allclose(shown, view(*pose).reshape(-1, 3).mean(0), atol=9)


def test_who_can_wander(scene):
    assert isinstance(Watched(), NavigatingRobot)
    assert not isinstance(RecordedRobot(scene, 0), NavigatingRobot)


def test_the_commands_refuse_what_makes_no_sense(tmp_path, capsys):
    plan, out = tmp_path / "plan.csv", tmp_path / "photos"
    grid = ["scenes", "capture", "grid", "--across", "2", "--along", "3", "--out", str(plan)]
    assert main([*grid, "--step", "0.5", "--tilts", "-25", "0"]) == 0
    assert "6 places, 48 poses" in capsys.readouterr().out
    np.testing.assert_allclose(read_poses(plan).poses, grid_poses(2, 3, 0.5, 4, (-25, 0)))
    robot = ["--places", str(plan), "--out", str(out)]
    for command, said in (
        (grid, "--force"),
        ([*grid, "--force", "--across", "0"], "across must be"),
        (["scenes", "capture", "robot", "scene:kitchen_1", *robot], "cannot drive to poses"),
        (["scenes", "capture", "robot", "ros:ws://127.0.0.1:1", *robot], "--robot-config"),
        (["scenes", "capture", "robot", "room:cellar_1", *robot], "no room that can be made"),
        (["scenes", "capture", "robot", "room:kitchen_1", *robot, "--at", "IMG_0009.jpg"], "--start"),
        (["scenes", "capture", "robot", "room:kitchen_1", "--places", "no.csv", "--out", str(out)], "there is no no"),
    ):
        assert main(command) == 2
        assert said in capsys.readouterr().err
    assert not out.exists()
