"""All that the generator takes from the package. Modules move: they are named here and nowhere else."""

from __future__ import annotations

from active_perceiver.benchmarks.act.report import format_act_speed
from active_perceiver.benchmarks.env.report import format_env_speed
from active_perceiver.benchmarks.exported.report import format_exported
from active_perceiver.benchmarks.policies.report import format_policies
from active_perceiver.benchmarks.recogniser.report import format_recogniser_ablation
from active_perceiver.benchmarks.robot.report import format_robot
from active_perceiver.benchmarks.robustness.report import format_robustness
from active_perceiver.benchmarks.scale.report import format_scale
from active_perceiver.benchmarks.train.report import format_train_speed
from active_perceiver.cli.main import main
from active_perceiver.envs.registration import scene_id
from active_perceiver.reproduction.setups import FULL
from active_perceiver.reproduction.tables import format_choices, format_recogniser, format_table_1, format_table_2
from active_perceiver.scenes import bundled_names, open_scene
from active_perceiver.scenes.bundled import TARGETS_OF_RECORD, scene_path
from indoor_rooms.objects import OBJECTS

__all__ = [
    "BENCHMARK_TABLES",
    "FULL",
    "OBJECTS",
    "TARGETS_OF_RECORD",
    "bundled_names",
    "format_choices",
    "format_recogniser",
    "format_table_1",
    "format_table_2",
    "main",
    "open_scene",
    "scene_id",
    "scene_path",
]

BENCHMARK_TABLES = {
    "act": format_act_speed,
    "env": format_env_speed,
    "export": format_exported,
    "policies": format_policies,
    "recogniser": format_recogniser_ablation,
    "robot": format_robot,
    "robustness": format_robustness,
    "scale": format_scale,
    "train": format_train_speed,
}
"""What prints the result of each benchmark that has a page."""
