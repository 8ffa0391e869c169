"""Policies: what they are at run time, how they are trained, how well they search. Only training imports torch."""

from active_perceiver.policies.config import (
    A3cConfig,
    DistilConfig,
    LearnerConfig,
    MirrorDescentConfig,
    PpoConfig,
)
from active_perceiver.policies.evaluation import (
    Evaluation,
    SearchResult,
    episode_evaluation,
    exact_evaluation,
    mean_evaluation,
)
from active_perceiver.policies.learners import LEARNERS, Learner, learner_named
from active_perceiver.policies.policy import ActionPolicy, Policy, RandomPolicy, policy_table
from active_perceiver.policies.problem import Problem
from active_perceiver.policies.sampling import ActionSampler, Episode, run_episode

__all__ = [
    "LEARNERS",
    "A3cConfig",
    "ActionPolicy",
    "ActionSampler",
    "DistilConfig",
    "Episode",
    "Evaluation",
    "Learner",
    "LearnerConfig",
    "MirrorDescentConfig",
    "Policy",
    "PpoConfig",
    "Problem",
    "RandomPolicy",
    "SearchResult",
    "episode_evaluation",
    "exact_evaluation",
    "learner_named",
    "mean_evaluation",
    "policy_table",
    "run_episode",
]
