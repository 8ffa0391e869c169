"""ResNet-50 up to res4f (torchvision's `layer3`), in torch; needed only to convert its weights to ONNX.

He, Zhang, Ren, Sun, "Deep Residual Learning for Image Recognition", CVPR 2016 (https://arxiv.org/abs/1512.03385); the
paper's feature extractor (section IV). Names and layout are torchvision's, so that its published file loads.
"""

from __future__ import annotations

from collections import OrderedDict

import torch
from torch import Tensor, nn
from torch.nn import functional

from active_perceiver.vision.sessions import BackboneError

CHANNELS = 1024
# torchvision's ResNet50_Weights.IMAGENET1K_V1, of the paper's time; the name carries the hash that is checked.
WEIGHTS_URL = "https://download.pytorch.org/models/resnet50-0676ba61.pth"
MEAN = (0.485, 0.456, 0.406)
STD = (0.229, 0.224, 0.225)


class Bottleneck(nn.Module):
    """1x1, 3x3 (with the stride), 1x1 convolutions around a shortcut."""

    def __init__(self, inputs: int, width: int, stride: int) -> None:
        super().__init__()
        outputs = 4 * width
        self.conv1, self.bn1 = nn.Conv2d(inputs, width, 1, bias=False), nn.BatchNorm2d(width)
        self.conv2 = nn.Conv2d(width, width, 3, stride, padding=1, bias=False)
        self.bn2 = nn.BatchNorm2d(width)
        self.conv3, self.bn3 = nn.Conv2d(width, outputs, 1, bias=False), nn.BatchNorm2d(outputs)
        self.downsample = nn.Sequential()
        if stride > 1 or inputs != outputs:
            self.downsample.extend([nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs)])

    def forward(self, x: Tensor) -> Tensor:
        """(N, inputs, H, W) -> (N, 4 * width, H / stride, W / stride)."""
        y = functional.relu(self.bn1(self.conv1(x)))
        y = functional.relu(self.bn2(self.conv2(y)))
        return functional.relu(self.bn3(self.conv3(y)) + self.downsample(x))


def _layer(inputs: int, width: int, blocks: int, stride: int) -> nn.Sequential:
    first = Bottleneck(inputs, width, stride)
    return nn.Sequential(first, *(Bottleneck(4 * width, width, 1) for _ in range(blocks - 1)))


class ResNet50Trunk(nn.Module):
    """Images in, the (N, 1024, H / 16, W / 16) feature map of res4f out."""

    mean: Tensor
    std: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.conv1, self.bn1 = nn.Conv2d(3, 64, 7, 2, padding=3, bias=False), nn.BatchNorm2d(64)
        self.layer1 = _layer(64, 64, 3, 1)
        self.layer2 = _layer(256, 128, 4, 2)
        self.layer3 = _layer(512, 256, 6, 2)
        self.register_buffer("mean", 255.0 * torch.tensor(MEAN)[:, None, None], persistent=False)
        self.register_buffer("std", 255.0 * torch.tensor(STD)[:, None, None], persistent=False)

    def forward(self, images: Tensor) -> Tensor:
        """(N, H, W, 3) uint8 RGB -> (N, 1024, H / 16, W / 16); H and W are multiples of 32."""
        x = (images.permute(0, 3, 1, 2).float() - self.mean) / self.std
        x = functional.max_pool2d(functional.relu(self.bn1(self.conv1(x))), 3, 2, padding=1)
        return self.layer3(self.layer2(self.layer1(x)))


def load_weights(network: ResNet50Trunk, state: OrderedDict[str, Tensor]) -> None:
    """Load torchvision's state dict; only what lies behind res4f (`layer4`, `fc`) may be left over.

    Raises:
        BackboneError: if the file is not a ResNet-50 of torchvision.
    """
    missing, unexpected = network.load_state_dict(state, strict=False)
    lost = [name for name in missing if not name.endswith("num_batches_tracked")]
    extra = [name for name in unexpected if not name.startswith(("layer4.", "fc."))]
    if lost or extra:
        raise BackboneError(f"the file is not a ResNet-50 of torchvision: missing {lost[:3]}, unexpected {extra[:3]}")


def resnet50() -> ResNet50Trunk:
    """The trunk with torchvision's ImageNet weights (98 MB), downloaded once and checked by their hash.

    Raises:
        BackboneError: if they cannot be downloaded or are damaged.
    """
    network = ResNet50Trunk().eval()
    try:
        state = torch.hub.load_state_dict_from_url(
            WEIGHTS_URL, map_location="cpu", check_hash=True, weights_only=True, progress=False
        )
    except (OSError, RuntimeError) as error:
        raise BackboneError(
            f"the weights of resnet50 could not be downloaded from {WEIGHTS_URL} ({error}); connect to the internet "
            f"once, put the file into {torch.hub.get_dir()}/checkpoints, or use --backbone efficientnet_lite0"
        ) from None
    load_weights(network, OrderedDict(state))
    return network
