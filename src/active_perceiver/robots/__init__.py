"""Robots: anything that can look and act, and the loop that searches with one."""

from active_perceiver.robots.recorded import RecordedRobot
from active_perceiver.robots.robot import Robot, Wanderer
from active_perceiver.robots.searching import Glimpse, SearchRecord, search

__all__ = ["Glimpse", "RecordedRobot", "Robot", "SearchRecord", "Wanderer", "search"]
