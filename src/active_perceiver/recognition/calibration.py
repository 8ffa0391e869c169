"""Calibrating a trained recogniser and measuring it on the views and pictures that were kept out of training."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from active_perceiver.recognition.metrics import RecognitionMetrics, choose_threshold
from active_perceiver.recognition.network import RecogniserNetwork
from active_perceiver.recognition.pairs import ABSENT, IGNORE_INDEX, PRESENT, Annotations, Split

# Pairs that are judged together.
PAIRS = 128
# Pictures of each target that it is asked for with, at most, in each measurement, spread over all there are: pictures
# that follow one another are alike.
PICTURES = 2


@torch.inference_mode()
def evaluate_pairs(
    network: RecogniserNetwork, views: Tensor, asked: Tensor
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """All prepared views with all prepared pictures: (V, ...), (Q, ...) -> (V, Q) logits, (V, Q, 4) boxes."""
    embeddings = network.encode_target(asked.float())
    parts = [
        network.all_pairs(network.encode_view(part.float()), embeddings)
        for part in views.split(max(1, PAIRS // len(asked)))
    ]
    logits, boxes = (torch.cat(column).numpy() for column in zip(*parts, strict=True))
    return logits, boxes


def _evaluate_scenes(
    network: RecogniserNetwork, views: Tensor, asked: Tensor, names: NDArray[np.str_], judged: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Like `evaluate_pairs`, but only the views of a scene with the targets of that scene: nothing else is known.

    Args:
        network: the recogniser.
        views: (V, ...) prepared views.
        asked: (Q, ...) prepared pictures.
        names: (Q,) "scene/target" of the pictures.
        judged: (V, Q) which answers will be used; the others may be anything.
    """
    logits = np.zeros(judged.shape, np.float32)
    boxes = np.zeros((*judged.shape, 4), np.float32)
    scenes = np.array([name.rpartition("/")[0] for name in names])
    for scene in np.unique(scenes):
        columns = np.flatnonzero(scenes == scene)
        rows = np.flatnonzero(judged[:, columns].any(axis=1))
        if len(rows):
            block = np.ix_(rows, columns)
            logits[block], boxes[block] = evaluate_pairs(
                network, views[torch.from_numpy(rows)], asked[torch.from_numpy(columns)]
            )
    return logits, boxes


def queries(data: Annotations, split: Split) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """For each measurement the (Q,) targets and (Q,) pictures that are asked for."""
    seen, unseen, unknown = [], [], []
    for target, (count, trained) in enumerate(zip(data.pictures, split.seen_pictures, strict=True)):
        if split.targets[target]:
            unknown += [(target, picture) for picture in _spread(0, count)]
        else:
            seen += [(target, picture) for picture in _spread(0, trained)]
            unseen += [(target, picture) for picture in _spread(trained, count)]
    asked = {"seen pictures": seen, "unseen pictures": unseen, "unknown targets": unknown}
    return {name: (np.array(rows)[:, 0], np.array(rows)[:, 1]) for name, rows in asked.items() if rows}


def _spread(start: int, stop: int) -> list[int]:
    """Up to `PICTURES` numbers from start to stop - 1, evenly spread."""
    chosen = min(PICTURES, stop - start)
    return [start + number * (stop - start) // chosen for number in range(chosen)]


def calibrate_split(
    network: RecogniserNetwork, views: Tensor, pictures: Tensor, data: Annotations, split: Split, most_false: float
) -> tuple[float, dict[str, RecognitionMetrics]]:
    """Calibrate the network, choose its threshold and measure it, all on the views that were held out.

    Args:
        network: trained; its `scale` and `shift` are set.
        views: (V, ...) prepared views.
        pictures: (T, K, ...) prepared target pictures.
        data: what they show.
        split: what was held out.
        most_false: see `choose_threshold`.

    Returns:
        The threshold, and the metrics by name, see `TrainedRecogniser`. Nothing is measured if nothing was held out.
    """
    if not split.views.any():
        return 0.5, {}
    held_out = views[torch.from_numpy(split.views)]
    states = data.states[split.views]
    asked = queries(data, split)
    answers = {
        name: _evaluate_scenes(
            network,
            held_out,
            pictures[torch.from_numpy(targets), torch.from_numpy(numbers)],
            data.names[targets],
            states[:, targets] != IGNORE_INDEX,
        )
        for name, (targets, numbers) in asked.items()
    }
    known = [name for name in asked if name != "unknown targets"]
    truth = np.concatenate([states[:, asked[name][0]] for name in known], axis=1)
    logits = np.concatenate([answers[name][0] for name in known], axis=1)
    scale, shift = platt_scaling(logits[truth != IGNORE_INDEX], truth[truth != IGNORE_INDEX] == PRESENT)
    network.shift.copy_(scale * network.shift + shift)
    network.scale.mul_(scale)
    probabilities = {name: sigmoid(scale * answers[name][0] + shift) for name in asked}
    scores = np.concatenate([probabilities[name] for name in known], axis=1)
    threshold = choose_threshold(scores[truth != IGNORE_INDEX], truth[truth != IGNORE_INDEX] == PRESENT, most_false)

    metrics = {
        name: measure(probabilities[name], answers[name][1], data, split.views, targets, threshold)
        for name, (targets, _) in asked.items()
    }
    return threshold, metrics


def measure(
    scores: NDArray[np.floating],
    boxes: NDArray[np.floating],
    data: Annotations,
    views: NDArray[np.bool_],
    targets: NDArray[np.int64],
    threshold: float,
) -> RecognitionMetrics:
    """How good answers are, leaving out what cannot be judged.

    Args:
        scores: (N, Q) presence probabilities in N views.
        boxes: (N, Q, 4) where the targets would be.
        data: what the views show.
        views: (V,) bool, the N of all views that were asked.
        targets: (Q,) which of the targets each was asked for.
        threshold: score from which on a detection counts.
    """
    states = data.states[views][:, targets]
    judged = states != IGNORE_INDEX
    truth = data.boxes[views][:, targets]
    truth[states == ABSENT] = np.nan
    names = np.broadcast_to(data.names[targets], judged.shape)
    return RecognitionMetrics.of(scores[judged], boxes[judged], truth[judged], threshold, names[judged], 0.0)


def platt_scaling(logits: NDArray[np.float32], present: NDArray[np.bool_]) -> tuple[float, float]:
    """Scale and shift that turn scores into log-odds of being right.

    Platt, "Probabilistic Outputs for Support Vector Machines", 1999, with its softened labels, which keep the scale
    finite when the classes can be told apart.

    Args:
        logits: (N,).
        present: (N,) truth.

    Returns:
        Scale (positive) and shift; 1 and 0 if only one class is there.
    """
    positives, negatives = int(present.sum()), int((~present).sum())
    if positives == 0 or negatives == 0:
        return 1.0, 0.0
    x = torch.from_numpy(logits.astype(np.float64))
    high, low = (positives + 1) / (positives + 2), 1 / (negatives + 2)
    labels = torch.from_numpy(np.where(present, high, low))
    weights = torch.zeros(2, dtype=torch.float64, requires_grad=True)  # logarithm of the scale, and the shift
    optimiser = torch.optim.LBFGS([weights], max_iter=100, line_search_fn="strong_wolfe")

    def closure() -> Tensor:
        optimiser.zero_grad()
        loss = functional.binary_cross_entropy_with_logits(weights[0].exp() * x + weights[1], labels)
        loss.backward()
        return loss

    optimiser.step(closure)
    scale, shift = weights.detach().tolist()
    return float(np.exp(scale)), shift


def sigmoid(logits: NDArray[np.float32]) -> NDArray[np.float32]:
    """Log-odds as probabilities, without overflow."""
    return 0.5 + 0.5 * np.tanh(0.5 * logits)
