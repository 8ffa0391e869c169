"""A recogniser's boxes in views that nobody has labelled, and the commands that put boxes into a scene."""

import dataclasses
import json

import numpy as np
import pytest

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.labelling.journal import Journal, journal_path
from active_perceiver.labelling.proposals import propose_boxes, surest_boxes
from active_perceiver.labelling.view_labels import ViewLabels
from active_perceiver.recognition.metrics import box_iou
from active_perceiver.scenes import load_scene, save_scene
from active_perceiver.scenes.scene import LABELLED, PROPOSED, UNLABELLED
from active_perceiver.training.inputs import label_warnings

pytestmark = pytest.mark.xdist_group("proposals")

SEEN, EARLIER = 100, 120
"""Views up to the first number are labelled, those up to the second have proposals from earlier."""


@pytest.fixture(scope="module")
def partly(scene):
    labels = np.full(len(scene), UNLABELLED, np.uint8)
    labels[:EARLIER], labels[:SEEN] = PROPOSED, LABELLED
    boxes = scene.boxes.copy()
    boxes[EARLIER:] = np.nan
    return dataclasses.replace(scene, labels=labels, boxes=boxes)


@pytest.fixture
def partly_file(partly, tmp_path):
    save_scene(partly, tmp_path / "partly.h5")
    return tmp_path / "partly.h5"


@pytest.fixture(scope="module")
def proposed(partly, agent_folder):
    calls = []
    scene, proposals = propose_boxes(partly, agent_folder, progress=lambda *call: calls.append(call[:2]))
    assert calls[-1] == (192 - EARLIER, 192 - EARLIER)
    return scene, proposals


def test_what_was_labelled_or_proposed_stays(partly, proposed):
    scene, proposals = proposed
    np.testing.assert_array_equal(scene.boxes[:EARLIER], partly.boxes[:EARLIER])
    np.testing.assert_array_equal(scene.labels[:EARLIER], partly.labels[:EARLIER])
    assert (scene.labels[EARLIER:] == PROPOSED).all()
    counts = (~np.isnan(scene.boxes[EARLIER:, :, 0])).sum(axis=0)
    assert proposals.views == 192 - EARLIER
    assert list(proposals.boxes.values()) == counts.tolist()
    assert counts.sum() > 5
    assert str(int(counts.sum())) in str(proposals).splitlines()[0]


def test_most_of_it_is_right(scene, proposed):
    boxes, truth = proposed[0].boxes[EARLIER:], scene.boxes[EARLIER:]
    drawn = ~np.isnan(boxes[..., 0])
    there = drawn & ~np.isnan(truth[..., 0])
    assert there.sum() > 0.7 * drawn.sum()
    assert (box_iou(boxes[there], truth[there]) > 0.3).mean() > 0.7


def test_it_is_what_the_agent_sees_picture_by_picture(partly, proposed, agent_folder):
    """Against asking for one picture in one view at a time."""
    agent = ActivePerceiver.from_pretrained(agent_folder)
    for view in (121, 150, 191):
        maps = agent.backbone.maps([partly.view(view)])
        for index, target in enumerate(partly.targets):
            found = []
            for picture in range(target.trained):  # the held-out ones are not used
                embedding = agent.recogniser.encode_target(agent.backbone.maps([target.picture(picture)]))
                scores, boxes = agent.recogniser.detect(maps, embedding)
                found.append((float(scores[0]), boxes[0]))
            score, box = max(found, key=lambda one: one[0])
            ours = proposed[0].boxes[view, index]
            assert np.isnan(ours[0]) == (score < agent.recogniser.threshold)
            if not np.isnan(ours[0]):
                inside = (np.abs(box[:2] - 0.5) + box[2:] / 2 <= 0.5).all()
                assert not inside or np.allclose(ours, box, atol=1e-4)


def test_a_lower_threshold_proposes_more_and_anew_looks_again(partly, proposed, agent_folder):
    scene, more = propose_boxes(partly, agent_folder, threshold=0.05, anew=True)
    assert sum(more.boxes.values()) > sum(proposed[1].boxes.values())
    assert more.views == 192 - SEEN
    np.testing.assert_array_equal(scene.boxes[:SEEN], partly.boxes[:SEEN])


def test_surest_boxes():
    scores = np.array([[0.2, 0.9, 0.4], [0.1, 0.3, 0.95]], np.float32)
    places = np.full((2, 3, 4), 0.1, np.float32)
    places[0, 1] = [0.9, 0.5, 0.4, 0.2]  # sticks out
    places[1, 2] = [0.5, 0.5, 0.001, 0.5]  # hardly anything
    boxes = surest_boxes(scores, places, [2, 1], 0.5)
    np.testing.assert_allclose(boxes[0, 0], [0.85, 0.5, 0.3, 0.2], atol=1e-6)
    assert np.isnan(boxes[[0, 1, 1], [1, 0, 1]]).all()


def test_what_cannot_be_proposed_is_refused(scene, partly, agent_folder, tmp_path):
    with pytest.raises(UserError, match="no unlabelled views"):
        propose_boxes(scene, agent_folder)
    labels = np.where(np.arange(len(scene)) < 5, PROPOSED, LABELLED).astype(np.uint8)
    with pytest.raises(UserError, match="5 have proposals already, which --force makes anew"):
        propose_boxes(dataclasses.replace(scene, labels=labels), agent_folder)
    for threshold in (0.0, 1.0, float("nan")):
        with pytest.raises(UserError, match="probability between 0 and 1"):
            propose_boxes(partly, agent_folder, threshold=threshold)
    with pytest.raises(UserError, match="is not an agent"):
        propose_boxes(partly, tmp_path)


def test_the_command_proposes(partly_file, agent_folder, capsys):
    assert main(["scenes", "label", str(partly_file), "--propose", str(agent_folder)]) == 0
    said = capsys.readouterr().out
    assert "boxes proposed in 72 views" in said
    assert f"scenes label {partly_file}" in said
    assert (load_scene(partly_file).labels[EARLIER:] == PROPOSED).all()
    assert not journal_path(partly_file).exists()
    assert main(["scenes", "label", str(partly_file), "--propose", str(agent_folder)]) == 2
    assert main(["scenes", "label", str(partly_file), "--propose", str(agent_folder), "--force"]) == 0


def test_the_command_takes_boxes_from_a_file_after_what_was_left_in_the_journal(partly_file, partly, capsys):
    from active_perceiver.scenes.box_labels import view_file_names

    journal = Journal(journal_path(partly_file), partly)
    journal.append(150, ViewLabels(LABELLED, {"ball0": (0.5, 0.5, 0.5, 0.5)}))
    journal.close()
    coco = partly_file.with_name("coco.json")
    names = view_file_names(partly)
    coco.write_text(
        json.dumps(
            {
                "images": [{"id": 1, "file_name": names[140], "width": 48, "height": 48}],
                "annotations": [{"id": 1, "image_id": 1, "category_id": 1, "bbox": [12, 24, 12, 6]}],
                "categories": [{"id": 1, "name": "ball2"}],
            }
        )
    )
    assert main(["scenes", "label", str(partly_file), "--from", str(coco)]) == 0
    assert "left in its journal: 1" in capsys.readouterr().out
    scene = load_scene(partly_file)
    assert scene.labels[[140, 150]].tolist() == [LABELLED, LABELLED]
    np.testing.assert_allclose(scene.boxes[140, 2], [0.375, 0.5625, 0.25, 0.125])
    np.testing.assert_allclose(scene.boxes[150, 0], 0.5)
    assert np.isnan(scene.boxes[140, :2]).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["kitchen_1"], "with --out my_kitchen_1.h5"),
        (["nowhere.h5"], "neither a bundled scene"),
        (["{scene}", "--from", "x.json", "--propose", "agent"], "use one after the other"),
        (["{scene}", "--from", "nowhere.json"], "nowhere.json"),
        (["{scene}", "--propose", "nowhere"], "is not an agent"),
        (["{scene}", "--port", "70000"], "cannot be served"),
        (["{scene}", "--out", "{scene}"], "exists"),
        (["{scene}", "--out", "{scene}", "--from", "nowhere.json"], "exists"),
        (["kitchen_1", "--out", "{scene}.copy.h5", "--from", "nowhere.json"], "nowhere.json"),
        (["kitchen_1", "--out", "{scene}.copy.h5", "--propose", "nowhere"], "no unlabelled views"),
    ],
)
def test_errors_are_sentences_and_leave_everything(partly_file, arguments, message, capsys):
    before = partly_file.read_bytes()
    given = [argument.format(scene=partly_file) for argument in arguments]
    assert main(["scenes", "label", *given]) == 2
    error = capsys.readouterr().err.replace("\n", " ")
    assert message in error
    assert "Traceback" not in error
    assert partly_file.read_bytes() == before
    assert [path.name for path in partly_file.parent.iterdir()] == [partly_file.name]


def test_training_says_what_it_is_not_sure_of(scene, partly):
    assert label_warnings([scene]) == []
    unlabelled, proposed = label_warnings([partly, scene])
    assert unlabelled.startswith("72 of 192 views of toy_0 are not labelled")
    assert "boxes of 20 of 192 views of toy_0 were proposed" in proposed
