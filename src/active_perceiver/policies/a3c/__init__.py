"""Asynchronous advantage actor-critic, the paper's learner: a process for each scene and target."""
