"""What an agent looks for: the object in a picture, or the place from where a picture was taken."""

from active_perceiver.agent.config import SearchKind
from active_perceiver.goals.goal import GoalDetector, GoalObservation
from active_perceiver.goals.object_goal import ObjectDetector, observe_goal
from active_perceiver.goals.view_goal import ViewDetector

__all__ = ["GOAL_DETECTORS", "ObjectDetector", "GoalDetector", "GoalObservation", "ViewDetector", "observe_goal"]

GOAL_DETECTORS: dict[SearchKind, type[GoalDetector]] = {"object": ObjectDetector, "view": ViewDetector}
