"""VTN's frozen ResNet-18: a feature map of 512 x 7 x 7 for every frame (He et al., 2016)."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import torch
from torch import Tensor

from models.nets.vision.backbone import FrozenBackbone
from models.nets.vision.frozen import FrozenWeights
from ucon.core.errors import DataError
from ucon.core.rng import derived_seed


class FrozenResNet18(FrozenBackbone):
    """The last convolution's map of a frame.

    VTNet uses weights trained on ImageNet, which are read from a folder (``hf download microsoft/resnet-18``). Without
    one the weights are random, from a fixed seed: the features are of some use, but not the paper's, and networks
    trained on them say so in their configuration.
    """

    channels = 512
    mean, deviation = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)

    def __init__(self, path: str | None = None, seed: int = 0) -> None:
        """Set where the weights are; they are loaded on first use.

        Args:
            path: folder in Hugging Face layout, or a name in its cache; None: random weights.
            seed: of random weights.
        """
        super().__init__()
        self._weights = None if path is None else FrozenWeights(path, "ResNetModel", "agent.policy.backbone.path")
        self._seed = seed

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

    def _mapped(self, images: Tensor) -> Tensor:
        found: Tensor = self._model.to(images.device)(images).last_hidden_state
        return found

    @cached_property
    def _model(self) -> Any:
        model = self._random() if self._weights is None else self._weights.model
        config = model.config
        if (config.layer_type, list(config.depths), config.hidden_sizes[-1]) != ("basic", [2, 2, 2, 2], self.channels):
            raise DataError(
                f"agent.policy.backbone.path={self._weights and self._weights.path}: a ResNet of layers "
                f"{config.depths} ({config.layer_type}), expected a ResNet-18"
            )
        return model.to(memory_format=torch.channels_last)

    def _random(self) -> Any:
        from transformers import ResNetConfig, ResNetModel

        config = ResNetConfig(hidden_sizes=[64, 128, 256, self.channels], depths=[2, 2, 2, 2], layer_type="basic")
        with torch.random.fork_rng(devices=[]), torch.inference_mode(False):
            torch.manual_seed(derived_seed(self._seed, "resnet18"))
            return ResNetModel(config).eval().requires_grad_(False)
