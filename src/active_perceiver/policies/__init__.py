"""Policies: what they are at run time. How they are trained and measured is in modules of their own.

`learners` has the table of learners, `config` their settings, `problem` what they are given; `evaluation` says how
well a policy searches, `sampling` runs episodes. Those need more than a robot has, so they are not imported here.
"""

from active_perceiver.policies.policy import ActionPolicy, Policy, RandomPolicy, policy_table

__all__ = ["ActionPolicy", "Policy", "RandomPolicy", "policy_table"]
