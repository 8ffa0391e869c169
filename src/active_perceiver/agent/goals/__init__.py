"""What an agent looks for: the object in a picture, or the place from where a picture was taken."""

from active_perceiver.agent.config import GoalName
from active_perceiver.agent.goals.goal import Goal, GoalDetector, GoalObservation, SearchGoal
from active_perceiver.agent.goals.object_goal import OBJECT, ObjectDetector, ObjectGoal, observe_goal
from active_perceiver.agent.goals.view_goal import VIEW, ViewDetector, ViewGoal

__all__ = [
    "GOALS",
    "Goal",
    "GoalDetector",
    "GoalObservation",
    "ObjectDetector",
    "ObjectGoal",
    "SearchGoal",
    "ViewDetector",
    "ViewGoal",
    "observe_goal",
]

GOALS: dict[GoalName, Goal] = {goal.name: goal for goal in (OBJECT, VIEW)}
