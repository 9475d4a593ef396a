"""VTN's frozen ResNet-18: a feature map of 512 x 7 x 7 for every frame (He et al., 2016)."""

from __future__ import annotations

from collections import OrderedDict
from functools import cached_property
from typing import Any, Final

import torch
from torch import Tensor

from models.nets.vision.frozen import FrozenWeights, without_models
from ucon.core.errors import DataError
from ucon.core.rng import derived_seed

CHANNELS: Final = 512
SIDE: Final = 7
#: Side of the image that gives a map of 7 x 7. VTNet's frames had 300 pixels; ours, of 128, are enlarged.
INPUT_PX: Final = 224
_CHUNK: Final = 64
#: Number of cached maps, 13 MB: an agent that is stuck sees the same frame again and again.
_REMEMBERED: Final = 256
#: Mean and standard deviation of ImageNet's colours, which the published weights expect.
_MEAN, _DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


class FrozenResNet18:
    """The last convolution's map of a frame, rounded to float16.

    VTNet uses weights trained on ImageNet, which are read from a folder (``hf download microsoft/resnet-18``). Without
    one
    the weights are random, from a fixed seed: features of some use, but not the paper's, and networks trained on them
    say
    so in their configuration.
    """

    def __init__(self, path: str | None = None, seed: int = 0) -> None:
        """Set where the weights are; they are loaded on first use.

        Args:
            path: folder in Hugging Face layout, or a name in its cache; None: random weights.
            seed: of random weights.
        """
        self._weights = None if path is None else FrozenWeights(path, "ResNetModel", "agent.policy.backbone.path")
        self._seed = seed
        self._known: OrderedDict[bytes, Tensor] = OrderedDict()

    @cached_property
    def name(self) -> str:
        """``resnet18`` with a hash of the files, or with ``random`` and the seed."""
        return f"resnet18 random {self._seed}" if self._weights is None else f"resnet18 {self._weights.identity}"

    def check(self) -> None:
        """Raise :class:`DataError` where the files are missing; loads nothing."""
        if self._weights is not None:
            self._weights.check()

    def fingerprint(self) -> str | None:
        """Hash of the files; "" for random weights, None where files are missing."""
        return "" if self._weights is None else self._weights.fingerprint()

    @torch.no_grad()
    def maps(self, rgb: Tensor) -> Tensor:
        """Feature maps of frames.

        Args:
            rgb: (N, H, W, 3) uint8.

        Returns:
            (N, 512, 7, 7) float16 on the frames' device.
        """
        with torch.autocast(rgb.device.type, enabled=False):  # stored maps must not depend on the training precision
            if len(rgb) == 1 and not rgb.is_cuda:
                return self._remembered(rgb)
            parts = [self._computed(part) for part in rgb.split(_CHUNK)]
            return torch.cat(parts) if parts else rgb.new_zeros((0, CHANNELS, SIDE, SIDE), dtype=torch.float16)

    def _remembered(self, rgb: Tensor) -> Tensor:
        key = rgb.numpy().tobytes()
        if key not in self._known:
            self._known[key] = self._computed(rgb).clone()
            if len(self._known) > _REMEMBERED:
                self._known.popitem(last=False)
        return self._known[key]

    def _computed(self, rgb: Tensor) -> Tensor:
        images = rgb.permute(0, 3, 1, 2).float() / 255
        images = torch.nn.functional.interpolate(images, (INPUT_PX, INPUT_PX), mode="bilinear", align_corners=False)
        mean, deviation = (images.new_tensor(values).view(3, 1, 1) for values in (_MEAN, _DEVIATION))
        images = ((images - mean) / deviation).contiguous(memory_format=torch.channels_last)
        found: Tensor = self._model.to(rgb.device)(images).last_hidden_state
        return found.contiguous().half()

    def __getstate__(self) -> dict[str, Any]:
        return without_models(self, "_model") | {"_known": OrderedDict()}

    @cached_property
    def _model(self) -> Any:
        model = self._random() if self._weights is None else self._weights.model
        config = model.config
        if (config.layer_type, list(config.depths), config.hidden_sizes[-1]) != ("basic", [2, 2, 2, 2], CHANNELS):
            raise DataError(
                f"agent.policy.backbone.path={self._weights and self._weights.path}: a ResNet of layers "
                f"{config.depths} ({config.layer_type}), expected a ResNet-18"
            )
        return model.to(memory_format=torch.channels_last)

    def _random(self) -> Any:
        from transformers import ResNetConfig, ResNetModel

        config = ResNetConfig(hidden_sizes=[64, 128, 256, CHANNELS], depths=[2, 2, 2, 2], layer_type="basic")
        with torch.random.fork_rng(devices=[]), torch.inference_mode(False):
            torch.manual_seed(derived_seed(self._seed, "resnet18"))
            return ResNetModel(config).eval().requires_grad_(False)
