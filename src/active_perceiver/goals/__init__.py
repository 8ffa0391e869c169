"""What an agent looks for: the object in a picture, or the place from where a picture was taken."""

from active_perceiver.agent.config import SearchKind
from active_perceiver.goals.goal import GoalDetector, GoalObservation, SearchGoal
from active_perceiver.goals.object_goal import ObjectDetector, ObjectGoal, observe_goal
from active_perceiver.goals.view_goal import ViewDetector, ViewGoal

__all__ = [
    "GOAL_DETECTORS",
    "GoalDetector",
    "GoalObservation",
    "ObjectDetector",
    "ObjectGoal",
    "SearchGoal",
    "ViewDetector",
    "ViewGoal",
    "observe_goal",
]

GOAL_DETECTORS: dict[SearchKind, type[GoalDetector]] = {"object": ObjectDetector, "view": ViewDetector}
