from __future__ import annotations

import math

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from active_perceiver.recognition.loss import centre_heat, centre_loss, focal_loss, iou, paper_loss  # noqa: E402
from active_perceiver.recognition.metrics import box_iou  # noqa: E402


def test_paper_loss_by_hand():
    logits = torch.tensor([0.0, math.log(3.0), -math.log(3.0)])
    present = torch.tensor([1.0, 1.0, 0.0])
    truth = torch.zeros(3, 4)
    boxes = torch.tensor([[0.1, 0.0, 0.0, 0.2], [0.0, 0.0, 0.3, 0.0], [9.0, 9.0, 9.0, 9.0]])
    entropy = math.log(2.0) + 2 * math.log(4.0 / 3.0)
    assert paper_loss(logits, boxes, present, truth).item() == pytest.approx(entropy + 0.5 * (0.05 + 0.09), abs=1e-6)


def test_iou_is_that_of_numpy(rng):
    one, other = rng.uniform(0.1, 0.6, (2, 50, 4)).astype(np.float32)
    ours = iou(torch.from_numpy(one), torch.from_numpy(other)).numpy()
    np.testing.assert_allclose(ours, box_iou(one, other), atol=1e-5)


def test_heat_is_one_at_the_centre_and_falls():
    boxes = torch.tensor([[0.35, 0.65, 0.3, 0.5], [0.5, 0.5, 0.2, 0.2], [1.0, 0.0, 0.1, 0.1]])
    heat = centre_heat(boxes, torch.tensor([1.0, 0.0, 1.0]), 10, 10)
    assert heat[0].max() == heat[0, 6, 3] == 1.0
    assert heat[0, 6, 4] > heat[0, 6, 5] > heat[0, 6, 7]
    assert (heat[1] == 0).all()
    assert heat[2, 0, 9] == 1.0  # a centre on the edge belongs to the last cell


def test_focal_loss_by_hand():
    logits = torch.tensor([[[0.0, math.log(3.0)]]])  # probabilities 1/2 and 3/4
    heat = torch.tensor([[[1.0, 0.5]]])
    expected = 0.5**2 * math.log(2.0) + 0.5**4 * 0.75**2 * math.log(4.0)
    assert focal_loss(logits, heat).item() == pytest.approx(expected, rel=1e-5)


def test_a_perfect_answer_costs_next_to_nothing():
    truth, present = torch.tensor([[0.45, 0.45, 0.2, 0.2]]), torch.ones(1)
    heat = centre_heat(truth, present, 10, 10)
    logits = torch.where(heat >= 1.0, 20.0, -20.0)
    boxes = truth[:, :, None, None].expand(1, 4, 10, 10)
    assert centre_loss(logits, boxes, present, truth).item() == pytest.approx(0.0, abs=1e-4)
    worse = boxes.clone()
    worse[:, 0] += 0.05
    assert centre_loss(logits, worse, present, truth).item() > 0.5


def test_no_positives_is_no_trouble():
    logits = torch.zeros(2, 4, 4, requires_grad=True)
    loss = centre_loss(logits, torch.zeros(2, 4, 4, 4), torch.zeros(2), torch.zeros(2, 4))
    loss.backward()
    assert torch.isfinite(logits.grad).all()
