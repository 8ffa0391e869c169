from __future__ import annotations

import numpy as np
import pytest

from active_perceiver.recognition import Detection, Recogniser, RecogniserError, detect_table
from active_perceiver.vision import scene_features
from helpers.toy import toy_scene

torch = pytest.importorskip("torch")

from active_perceiver.recognition.export import (  # noqa: E402
    export_recogniser,
    load_network,
    recogniser_onnx,
    save_network,
)
from active_perceiver.recognition.network import RECOGNISERS, inside_image  # noqa: E402

SHAPE = (672, 6, 6)


@pytest.fixture(scope="module", params=list(RECOGNISERS))
def network(request):
    torch.manual_seed(0)
    network = RECOGNISERS[request.param](SHAPE)
    network.fit(torch.rand(40, *SHAPE))
    network.scale.fill_(1.5)
    network.shift.fill_(-0.5)
    return network.eval()


@pytest.fixture(scope="module")
def recogniser(network):
    return Recogniser(recogniser_onnx(network, 0.4, "a print"), threads=1)


def maps(rng, count: int) -> np.ndarray:
    return rng.random((count, *SHAPE), dtype=np.float32)


def test_onnx_is_torch(network, recogniser, rng):
    views, target = maps(rng, 5), maps(rng, 1)
    scores, boxes = recogniser.detect(views, recogniser.encode_target(target)[0])
    with torch.inference_mode():
        logits, expected = network(torch.from_numpy(views), torch.from_numpy(target))
    np.testing.assert_allclose(scores, logits.sigmoid().numpy(), atol=1e-4)
    np.testing.assert_allclose(boxes, expected.numpy(), atol=1e-3)
    assert (scores.shape, boxes.shape) == ((5,), (5, 4))


def test_many_targets_at_once_are_the_same_as_one_by_one(recogniser, rng):
    views, embeddings = maps(rng, 3), recogniser.encode_target(maps(rng, 4))
    scores, boxes = recogniser.detect_many(views, embeddings)
    for index, embedding in enumerate(embeddings):
        one_score, one_box = recogniser.detect(views, embedding)
        np.testing.assert_allclose(scores[:, index], one_score, atol=1e-5)
        np.testing.assert_allclose(boxes[:, index], one_box, atol=1e-5)


def test_what_is_stored(network, recogniser):
    assert recogniser.kind in RECOGNISERS
    assert (recogniser.threshold, recogniser.backbone, recogniser.map_shape) == (0.4, "a print", SHAPE)


def test_nothing_to_do(recogniser, rng):
    embeddings = recogniser.encode_target(maps(rng, 0))
    assert len(embeddings) == 0
    scores, boxes = recogniser.detect_many(maps(rng, 2), embeddings)
    assert (scores.shape, boxes.shape) == ((2, 0), (2, 0, 4))
    assert recogniser.detect(maps(rng, 0), recogniser.encode_target(maps(rng, 1)))[0].shape == (0,)


@pytest.mark.parametrize("shape", [(672, 6, 6), (1, 672, 7, 6), (1, 1024, 6, 6)])
def test_wrong_maps(recogniser, shape):
    with pytest.raises(RecogniserError, match="backbone and the image size"):
        recogniser.encode_target(np.zeros(shape, np.float32))
    with pytest.raises(RecogniserError, match="backbone and the image size"):
        recogniser.detect(np.zeros(shape, np.float32), recogniser.encode_target(np.zeros((1, *SHAPE), np.float32)))


def test_wrong_code_and_numbers_that_are_not_finite(recogniser, rng):
    with pytest.raises(RecogniserError, match="encode_target"):
        recogniser.detect(maps(rng, 1), np.zeros(7, np.float32))
    broken = np.full((1, *SHAPE), np.nan, np.float32)
    with pytest.raises(RecogniserError, match="not finite"):
        recogniser.encode_target(broken)
    with pytest.raises(RecogniserError, match="not finite"):
        recogniser.detect(broken, recogniser.encode_target(maps(rng, 1)))


def test_table(recogniser, backbone):
    scene = toy_scene(side=1, targets=2)
    features = scene_features(scene, backbone)
    calls = []
    scores, boxes = detect_table(recogniser, features, progress=lambda done, total: calls.append((done, total)))
    assert (scores.shape, boxes.shape) == ((12, 2, 4), (12, 2, 4, 4))
    embedding = recogniser.encode_target(features.target_maps[1, 2:3])
    one_score, one_box = recogniser.detect(features.view_maps, embedding)
    np.testing.assert_allclose(scores[:, 1, 2], one_score, atol=1e-4)
    np.testing.assert_allclose(boxes[:, 1, 2], one_box, atol=1e-4)
    assert calls[-1] == (12, 12)
    chosen, _ = detect_table(recogniser, features, np.array([1]))
    np.testing.assert_allclose(chosen, scores[:, 1:], atol=1e-5)
    none, _ = detect_table(recogniser, features, np.array([], int))
    assert none.shape == (12, 0, 4)


def test_weights_come_back(network, tmp_path, rng):
    save_network(network, tmp_path / "model.safetensors")
    again = load_network(tmp_path / "model.safetensors")
    inputs = torch.from_numpy(maps(rng, 2)), torch.from_numpy(maps(rng, 1))
    with torch.inference_mode():
        assert torch.equal(again(*inputs)[0], network(*inputs)[0])


def test_unreadable_files(network, tmp_path):
    with pytest.raises(RecogniserError, match="no file"):
        load_network(tmp_path / "missing.safetensors")
    (tmp_path / "rubbish").write_bytes(b"rubbish, not weights")
    with pytest.raises(RecogniserError, match="does not hold"):
        load_network(tmp_path / "rubbish")
    with pytest.raises(RecogniserError, match="not a readable ONNX"):
        Recogniser(tmp_path / "rubbish")
    with pytest.raises(RecogniserError, match="cannot be read"):
        Recogniser(tmp_path / "missing.onnx")


def test_another_model_is_refused(backbone):
    with pytest.raises(RecogniserError, match="but not a recogniser"):
        Recogniser(backbone.path)


def test_a_failed_export_leaves_what_was_there(tmp_path, monkeypatch):
    network = RECOGNISERS["pooled"](SHAPE)
    path = tmp_path / "recogniser.onnx"
    path.write_bytes(b"the old one")
    monkeypatch.setattr("active_perceiver.vision.onnx_export.np.abs", lambda _: np.ones(1))
    with pytest.raises(RuntimeError, match="differs from torch"):
        export_recogniser(network, path)
    assert path.read_bytes() == b"the old one"


def test_boxes_are_cut_at_the_edges():
    boxes = torch.tensor([[0.0, 0.5, 0.4, 0.2], [0.5, 0.5, -0.1, 0.2], [0.5, 0.5, 3.0, 0.5], [2.0, 2.0, 0.1, 0.1]])
    expected = [[0.1, 0.5, 0.2, 0.2], [0.5, 0.5, 0.0, 0.2], [0.5, 0.5, 1.0, 0.5], [1.0, 1.0, 0.0, 0.0]]
    np.testing.assert_allclose(inside_image(boxes).numpy(), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("score", "box"),
    [
        (1.1, [0.5, 0.5, 0.1, 0.1]),
        (np.nan, [0.5, 0.5, 0.1, 0.1]),
        (0.5, [0.5, 0.5, 0.1]),
        (0.5, [0.5, 0.5, -0.1, 0.1]),
        (0.5, [np.nan] * 4),
    ],
)
def test_bad_detections(score, box):
    with pytest.raises(RecogniserError):
        Detection(score, np.array(box))


def test_detection():
    detection = Detection(0.75, np.array([0.5, 0.5, 0.2, 0.4]))
    assert detection.area == pytest.approx(0.08)
    assert detection.box.dtype == np.float32
    assert not detection.box.flags.writeable


def test_target_codes_look_at_the_middle_of_the_picture():
    """What lies around the object in a picture, as phone pictures have it, hardly changes the target's code."""
    torch.manual_seed(0)
    network = RECOGNISERS["matching"]((24, 20, 20)).eval()
    picture, other = torch.rand(1, 24, 20, 20), torch.rand(1, 24, 20, 20)
    corner, middle = picture.clone(), picture.clone()
    corner[:, :, :6, :6] = other[:, :, :6, :6]
    middle[:, :, 7:13, 7:13] = other[:, :, 7:13, 7:13]
    embeddings = [network.encode_target(network.prepare_target(maps)) for maps in (picture, corner, middle)]
    around, within = (float((embedding - embeddings[0]).detach().norm()) for embedding in embeddings[1:])
    assert around < 0.2 * within
