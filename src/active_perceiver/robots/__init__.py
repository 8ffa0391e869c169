"""Robots: anything that can look and act."""

from active_perceiver.robots.recorded import RecordedRobot
from active_perceiver.robots.robot import NavigatingRobot, Robot

__all__ = ["RecordedRobot", "Robot", "NavigatingRobot"]
