"""Base of VTN's frozen networks, which turn each frame into a small map of features."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any, ClassVar, Final

import torch
from torch import Tensor

from models.nets.vision.frozen import without_models
from ucon.core.device import cpu_precision

SIDE: Final = 7
"""Side of the map."""
#: Side of the image that gives a map of 7 x 7. VTNet's frames had 300 pixels; ours, of 128, are enlarged.
INPUT_PX: Final = 224
#: Frames computed at once, on a GPU and on a CPU, whose cache holds the layers of only a few.
_CHUNK, _CHUNK_ON_CPU = 64, 4
#: Number of cached maps, some 10 MB: an agent that is stuck sees the same frame again and again.
_REMEMBERED: Final = 256


class FrozenBackbone:
    """Maps of frames by a network that is never trained, rounded to float16.

    Processors that support bfloat16 compute in it, in half of the time; it changes maps by 1 to 3 %.
    """

    channels: ClassVar[int]
    """Channels of the map."""
    mean: ClassVar[tuple[float, float, float]]
    """Mean of red, green and blue in the network's training images, from 0 to 1."""
    deviation: ClassVar[tuple[float, float, float]]
    """Their standard deviation."""

    def __init__(self) -> None:
        self._known: OrderedDict[bytes, Tensor] = OrderedDict()

    @property
    def name(self) -> str:
        """Network and hash of its weights, or the seed of random ones; also shown in tables."""
        raise NotImplementedError

    def check(self) -> None:
        """Raise :class:`DataError` where files are missing; loads nothing."""

    def fingerprint(self) -> str | None:
        """Hash of the files; "" for random weights, None where files are missing."""
        raise NotImplementedError

    @torch.no_grad()
    def maps(self, rgb: Tensor) -> Tensor:
        """Feature maps of frames.

        Args:
            rgb: (N, H, W, 3) uint8.

        Returns:
            (N, channels, 7, 7) float16 on the frames' device.
        """
        with torch.autocast(rgb.device.type, enabled=False):  # stored maps must not depend on the training precision
            if len(rgb) == 1 and not rgb.is_cuda:
                return self._remembered(rgb)
            parts = [self._computed(part) for part in rgb.split(_CHUNK if rgb.is_cuda else _CHUNK_ON_CPU)]
            empty = (0, self.channels, SIDE, SIDE)
            return torch.cat(parts) if parts else rgb.new_zeros(empty, dtype=torch.float16)

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
        mean, deviation = (images.new_tensor(values).view(3, 1, 1) for values in (self.mean, self.deviation))
        images = ((images - mean) / deviation).contiguous(memory_format=torch.channels_last)
        precise = images.is_cuda or cpu_precision(torch.bfloat16) == torch.float32
        with torch.autocast(images.device.type, torch.bfloat16, enabled=not precise):
            return self._mapped(images).contiguous().half()

    def _mapped(self, images: Tensor) -> Tensor:
        """Maps (N, channels, 7, 7) of normalised images (N, 3, 224, 224)."""
        raise NotImplementedError

    def __getstate__(self) -> dict[str, Any]:
        return without_models(self, "_model") | {"_known": OrderedDict()}
