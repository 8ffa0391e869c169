"""A robot that takes the photographs: its tour, the folder that it writes, what is in its way, interruptions."""

import itertools
import json
import math

import networkx
import numpy as np
import pytest

from active_perceiver.capturing.robot_photographs import photograph_places
from active_perceiver.capturing.tour import PlacesError, Tour, from_first, grid_poses, neighbours
from active_perceiver.cli import main
from active_perceiver.files import OutputExistsError
from active_perceiver.progress import quiet
from active_perceiver.robots import RecordedRobot, Wanderer
from active_perceiver.robots.body import Slip
from active_perceiver.robots.rosbridge import RosRobot
from active_perceiver.robots.simulated import SimulatedRobot
from active_perceiver.scenes import Action
from active_perceiver.scenes.images import decode_image
from active_perceiver.scenes.importers.photos import PhotoSettings, import_photos
from active_perceiver.scenes.importers.pose_table import read_poses, write_poses
from active_perceiver.scenes.scene import SceneError
from bridge import SETTINGS as BRIDGED
from bridge import comes_to_rest, served, with_
from simulated_place import NO_SLIP, START, small_room, simulated

# Three by three places half a metre apart, two of them where the table is, if the robot begins at the first.
FIRST = (0.8, 1.3, 0.0, 0.0)
GRID = grid_poses(4, 3, 0.5, 4, (-30.0, 0.0))


class Watched(SimulatedRobot):
    """Remembers where it truly was when it looked, from where it began, and what it was asked for; may be stopped."""

    def __init__(self, start=FIRST, slip=NO_SLIP, looks=None, **options):
        super().__init__(small_room(), start, slip=slip, **options)
        self.seen, self.asked, self.looks = [], [], looks
        self.began = self.pose()

    def go_to(self, *pose):
        self.asked.append(pose)
        return super().go_to(*pose)

    def look(self):
        if len(self.seen) == self.looks:
            raise KeyboardInterrupt
        x, z, heading, tilt = from_first(np.array([self.began, self.pose()]))[1]
        self.seen.append((x, z, heading, tilt))
        return super().look()

    def off(self):
        """(L, 2) metres beside, and degrees beside, what was asked for, at each look."""
        reached = [pose for pose in self.asked]
        del reached
        return None


def table_of(tmp_path, poses, names=None, name="plan.csv"):
    path = tmp_path / name
    write_poses(path, names or [f"IMG_{number:04}.jpg" for number in range(1, len(poses) + 1)], poses)
    return read_poses(path)


def taken(folder):
    return sorted(path.name for path in folder.glob("*.jpg"))
