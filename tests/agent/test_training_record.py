"""How an agent was trained, as its configuration keeps it."""

import json

import pytest

from active_perceiver.agent.config import AgentConfig, AgentError
from active_perceiver.agent.training_record import TrainingRecord

RECORD = TrainingRecord(
    scenes=("kitchen_1", "/rooms/attic.h5"),
    learner="ppo",
    seed=3,
    recogniser_scenes=("kitchen_1",),
    rank=4,
    held_out_pictures={"kitchen_1": {"mug": 2}},
    held_out_views={"kitchen_1": [5, 8]},
    view_augmentation=2,
    viewpoint_jitter_degrees=10.0,
)


def test_it_is_read_as_it_was_written():
    assert TrainingRecord.from_json(json.loads(json.dumps(RECORD.to_json()))) == RECORD


def test_what_an_earlier_version_wrote_is_read():
    old = {"scenes": ["kitchen_1"], "changed_views": 1, "changed_degrees": 0.5, "learner": "distil", "forgotten": 1}
    assert TrainingRecord.from_json(old) == TrainingRecord(
        scenes=("kitchen_1",), learner="distil", view_augmentation=1, viewpoint_jitter_degrees=0.5
    )


@pytest.mark.parametrize(
    "change",
    [
        {"scenes": "kitchen_1"}, {"scenes": [1]}, {"rank": "5"}, {"rank": True}, {"seed": 1.5}, {"learner": None},
        {"held_out_views": [5]}, {"view_augmentation": []}, {"viewpoint_jitter_degrees": "much"},
    ],
)  # fmt: skip
def test_a_damaged_one_is_refused(change, tmp_path):
    AgentConfig("efficientnet_lite0", 96, None, 1.0, {}, [], 1.0, 1.0, training=RECORD).save(tmp_path)
    assert AgentConfig.load(tmp_path).training == RECORD
    data = json.loads((tmp_path / "config.json").read_text())
    for training in ([], {**data["training"], **change}):
        (tmp_path / "config.json").write_text(json.dumps({**data, "training": training}))
        with pytest.raises(AgentError, match="is damaged: training"):
            AgentConfig.load(tmp_path)
