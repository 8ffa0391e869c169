"""The recognisers as torch modules: the paper's, and one that matches the target against the feature map.

Both work in three steps, so that a scene's table and a robot's search compute nothing twice: a part without weights
to learn (`prepare`), a code of the view and a code of the target on their own, and a judgement on the two.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from active_perceiver.recognition.loss import centre_loss, paper_loss
from active_perceiver.vision.backbone import middle_weights


class RecogniserNetwork(nn.Module):
    """(view maps, target maps) -> is the target in the view (logit), and where (box).

    Attributes:
        map_shape: (C, h, w) of the feature maps.
    """

    # Platt scaling (Platt, 1999), fitted after training: makes the logit's sigmoid a probability.
    scale: Tensor
    shift: Tensor

    def __init__(self, map_shape: tuple[int, int, int]) -> None:
        super().__init__()
        self.map_shape = map_shape
        self.register_buffer("scale", torch.ones(()))
        self.register_buffer("shift", torch.zeros(()))

    def fit(self, maps: Tensor) -> None:
        """Adapt what is not learned by gradient to a sample of view maps, (N, C, h, w)."""

    def prepare(self, maps: Tensor) -> Tensor:
        """What can be computed once for all of training: (N, C, h, w) -> (N, ...)."""
        raise NotImplementedError

    def prepare_target(self, maps: Tensor) -> Tensor:
        """The same for target pictures: (N, C, h, w) -> (N, ...)."""
        return self.prepare(maps)

    def encode_view(self, prepared: Tensor) -> Tensor:
        """(N, ...) prepared views -> (N, ...) codes."""
        raise NotImplementedError

    def encode_target(self, prepared: Tensor) -> Tensor:
        """(N, ...) prepared target pictures -> (N, D) codes."""
        raise NotImplementedError

    def evaluate_pairs(self, view_embeddings: Tensor, target_embeddings: Tensor) -> Tensor:
        """Compare each view with M targets of its own: (N, ...), (N, M, D) -> (N * M, ...)."""
        raise NotImplementedError

    def decode(self, judged: Tensor) -> tuple[Tensor, Tensor]:
        """(P, ...) judgements -> (P,) uncalibrated logits, (P, 4) boxes."""
        raise NotImplementedError

    def loss(self, judged: Tensor, present: Tensor, boxes: Tensor) -> Tensor:
        """Training loss of P judgements.

        Args:
            judged: (P, ...) as `judge` returns them.
            present: (P,) float, 1 where the target is in the view, else 0.
            boxes: (P, 4) true boxes; anything finite where it is not.
        """
        raise NotImplementedError

    def all_pairs(self, view_embeddings: Tensor, target_embeddings: Tensor) -> tuple[Tensor, Tensor]:
        """Compare N views with M targets: (N, ...), (M, D) -> (N, M) logits, (N, M, 4) boxes inside the image."""
        views, targets = view_embeddings.shape[0], target_embeddings.shape[0]
        judged = self.evaluate_pairs(
            view_embeddings, target_embeddings[None].expand(views, targets, target_embeddings.shape[1])
        )
        logits, boxes = self.decode(judged)
        logits = self.scale * logits + self.shift
        return logits.reshape(views, targets), inside_image(boxes).reshape(views, targets, 4)

    def forward(self, view_maps: Tensor, target_maps: Tensor) -> tuple[Tensor, Tensor]:
        """Judge views.

        Args:
            view_maps: (N, C, h, w).
            target_maps: (N, C, h, w), or (1, C, h, w) for the same target in all.

        Returns:
            (N,) presence logits and (N, 4) boxes: centre x, centre y, width, height as fractions of the image.
        """
        embeddings = self.encode_target(self.prepare_target(target_maps))
        judged = self.evaluate_pairs(
            self.encode_view(self.prepare(view_maps)),
            embeddings.expand(view_maps.shape[0], embeddings.shape[1])[:, None],
        )
        logits, boxes = self.decode(judged)
        return self.scale * logits + self.shift, inside_image(boxes)


def inside_image(boxes: Tensor) -> Tensor:
    """Cut boxes (..., 4) at the image's edges; a negative size becomes zero."""
    low = (boxes[..., :2] - boxes[..., 2:] / 2).clamp(0.0, 1.0)
    high = (boxes[..., :2] + boxes[..., 2:] / 2).clamp(0.0, 1.0)
    return torch.cat([(low + high) / 2, (high - low).clamp(min=0.0)], dim=-1)


class PooledRecogniser(RecogniserNetwork):
    """The paper's recogniser (section IV-A): both maps averaged over the image, then fully connected layers.

    The averages are standardised first; they are small positive numbers, on which training is slow.
    """

    mean: Tensor
    spread: Tensor

    def __init__(self, map_shape: tuple[int, int, int], width: int = 512) -> None:
        super().__init__(map_shape)
        self.register_buffer("mean", torch.zeros(map_shape[0]))
        self.register_buffer("spread", torch.ones(map_shape[0]))
        self.view = nn.Linear(map_shape[0], width)
        self.target = nn.Linear(map_shape[0], width)
        self.fuse = nn.Linear(2 * width, width)
        self.presence = nn.Sequential(nn.Linear(width, width), nn.ReLU(), nn.Linear(width, 1))
        self.box = nn.Sequential(nn.Linear(width, width), nn.ReLU(), nn.Linear(width, 4))

    def fit(self, maps: Tensor) -> None:
        """Take each feature's mean and standard deviation over a sample of views."""
        averages = maps.mean(dim=(2, 3))
        self.mean.copy_(averages.mean(0))
        self.spread.copy_(averages.std(0).clamp(min=1e-3))

    def prepare(self, maps: Tensor) -> Tensor:
        """Global average, standardised: (N, C, h, w) -> (N, C)."""
        return (maps.mean(dim=(2, 3)) - self.mean) / self.spread

    def encode_view(self, prepared: Tensor) -> Tensor:
        """(N, C) -> (N, 512)."""
        return functional.relu(self.view(prepared))

    def encode_target(self, prepared: Tensor) -> Tensor:
        """(N, C) -> (N, 512)."""
        return functional.relu(self.target(prepared))

    def evaluate_pairs(self, view_embeddings: Tensor, target_embeddings: Tensor) -> Tensor:
        """(N, 512), (N, M, 512) -> (N * M, 5): a logit and a box."""
        views = view_embeddings[:, None].expand(target_embeddings.shape)
        fused = functional.relu(self.fuse(torch.cat([views, target_embeddings], dim=2).flatten(0, 1)))
        return torch.cat([self.presence(fused), self.box(fused)], dim=1)

    def decode(self, judged: Tensor) -> tuple[Tensor, Tensor]:
        """(P, 5) -> (P,) logits, (P, 4) boxes."""
        return judged[:, 0], judged[:, 1:]

    def loss(self, judged: Tensor, present: Tensor, boxes: Tensor) -> Tensor:
        """The paper's loss, see `paper_loss`."""
        return paper_loss(judged[:, 0], judged[:, 1:], present, boxes)


class MatchingRecogniser(RecogniserNetwork):
    """The target's code is matched against every cell of the view's map; a heat map says where its centre is.

    Pooling loses where things are and drowns small ones; here each cell of a 20 x 20 map answers for itself, and the
    box is read at the hottest cell, as in Zhou, Wang, Kraehenbuehl, "Objects as Points", 2019
    (https://arxiv.org/abs/1904.07850). How cells are compared depends on the target, as in one-shot detection (Hsieh
    et al., "One-Shot Object Detection with Co-Attention and Co-Excitation", NeurIPS 2019).
    """

    mean: Tensor
    basis: Tensor

    def __init__(
        self, map_shape: tuple[int, int, int], reduced: int = 160, width: int = 128, hidden: int = 64
    ) -> None:
        super().__init__(map_shape)
        self.reduced = min(reduced, map_shape[0])
        self.hidden = hidden
        self.register_buffer("mean", torch.zeros(map_shape[0]))
        self.register_buffer("basis", torch.eye(self.reduced, map_shape[0]))
        self.view = nn.Conv2d(self.reduced, width, 1)
        self.context = nn.Conv2d(width, hidden, 1)
        self.target = nn.Conv2d(self.reduced, width, 1)
        self.attention = nn.Conv2d(self.reduced, 1, 1)
        self.focus = nn.Parameter(
            torch.from_numpy(np.log(middle_weights(map_shape[1] // 2, map_shape[2] // 2))).flatten()
        )
        self.compare = nn.Linear(width, hidden, bias=False)
        self.expect = nn.Linear(width, hidden)
        self.refine = nn.Sequential(
            nn.GroupNorm(8, hidden), nn.ReLU(), nn.Conv2d(hidden, hidden, 3, padding=1),
            nn.GroupNorm(8, hidden), nn.ReLU(), nn.Conv2d(hidden, hidden, 3, padding=1),
            nn.GroupNorm(8, hidden), nn.ReLU(), 
        )  # fmt: skip
        self.answer = nn.Conv2d(hidden, 5, 1)
        assert self.answer.bias is not None
        nn.init.constant_(
            self.answer.bias[:1], -4.0
        )  # few cells are centres: Lin et al., "Focal Loss", 2017, section 4.1

    def fit(self, maps: Tensor) -> None:
        """Take the directions in which the cells of a sample of views differ most (principal components)."""
        cells = maps.permute(0, 2, 3, 1).flatten(0, 2)
        mean = cells.mean(0)
        centred = cells - mean
        _, vectors = torch.linalg.eigh(centred.T @ centred / len(cells))
        basis = vectors[:, -self.reduced :].T.flip(0)
        spread = (centred @ basis.T).std(0).mean()
        self.mean.copy_(mean)
        self.basis.copy_(basis / spread)

    def prepare(self, maps: Tensor) -> Tensor:
        """Project onto the principal components: (N, C, h, w) -> (N, 160, h, w)."""
        return functional.conv2d(maps - self.mean[:, None, None], self.basis[:, :, None, None])

    def prepare_target(self, maps: Tensor) -> Tensor:
        """The same at half the resolution, enough for a picture that its object fills."""
        return functional.avg_pool2d(self.prepare(maps), 2)

    def encode_view(self, prepared: Tensor) -> Tensor:
        """(N, 160, h, w) -> (N, 128 + 64, h, w): what is compared, and what is known without the target."""
        view = self.view(prepared)
        return torch.cat([view, self.context(functional.relu(view))], dim=1)

    def encode_target(self, prepared: Tensor) -> Tensor:
        """(N, 160, h / 2, w / 2) -> (N, 128), looking at what is in the middle and not at what lies around it."""
        cells = functional.relu(self.target(prepared).flatten(2))
        weights = (self.attention(prepared).flatten(2) + self.focus).softmax(dim=2)
        return (cells * weights).sum(2) + (cells * self.focus.exp()).amax(2)

    def evaluate_pairs(self, view_embeddings: Tensor, target_embeddings: Tensor) -> Tensor:
        """(N, 192, h, w), (N, M, 128) -> (N * M, 5, h, w): centre logit, and box relative to the cell."""
        views, targets, width = target_embeddings.shape
        view, context = view_embeddings.flatten(2).split([width, self.hidden], dim=1)
        # compare(view * target) for all targets of a view as one matrix product, without the products in memory.
        weights = (self.compare.weight * target_embeddings[:, :, None]).flatten(1, 2)
        compared = (weights @ view).reshape(views, targets, self.hidden, view.shape[2])
        joint = compared + context[:, None] + self.expect(target_embeddings)[..., None]
        return self.answer(self.refine(joint.reshape(views * targets, self.hidden, *self.map_shape[1:])))

    def boxes(self, judged: Tensor) -> Tensor:
        """The box that each cell proposes: (P, 5, h, w) -> (P, 4, h, w)."""
        rows, columns = self.map_shape[1:]
        x = (torch.arange(columns, device=judged.device) + 0.5) / columns
        y = (torch.arange(rows, device=judged.device) + 0.5) / rows
        offset = 1.5 * judged[:, 1:3].tanh()  # in cells: the hottest cell may be a neighbour of the right one
        size = (judged[:, 3:5] - 2.0).clamp(max=0.5).exp()
        return torch.cat(
            [x[None, None, None, :] + offset[:, :1] / columns, y[None, None, :, None] + offset[:, 1:] / rows, size],
            dim=1,
        )

    def decode(self, judged: Tensor) -> tuple[Tensor, Tensor]:
        """The hottest cell's logit and box: (P, 5, h, w) -> (P,), (P, 4)."""
        logits, hottest = judged[:, 0].flatten(1).max(dim=1)
        boxes = self.boxes(judged).flatten(2)
        return logits, boxes.gather(2, hottest[:, None, None].expand(-1, 4, 1))[:, :, 0]

    def loss(self, judged: Tensor, present: Tensor, boxes: Tensor) -> Tensor:
        """Focal loss of the centre's heat map and box loss near the centre, see `centre_loss`."""
        return centre_loss(judged[:, 0], self.boxes(judged), present, boxes)


RECOGNISERS: dict[str, type[RecogniserNetwork]] = {"matching": MatchingRecogniser, "pooled": PooledRecogniser}
