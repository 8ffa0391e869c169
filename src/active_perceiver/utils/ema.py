"""Running means of weights while they are trained. Needs torch."""

from __future__ import annotations

from functools import partial
from typing import Any

from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn


def ema_weights(network: nn.Module, keep: float) -> AveragedModel:
    """A network whose weights are the exponential running mean of another's; call `update_parameters` at each step.

    Early on, when weights change most, the mean reaches less far back, or it would lag behind what is learned.

    Args:
        network: whose weights.
        keep: share of the mean that stays at each step, later on, 0..1 (not 1); 0 for the weights as they are.
    """
    return AveragedModel(network, multi_avg_fn=partial(_update, keep))


def _update(keep: float, averaged: Any, current: Any, steps: Tensor | int) -> None:
    done = int(steps)
    get_ema_multi_avg_fn(min(keep, (1 + done) / (10 + done)))(averaged, current, steps)
