"""A frozen CLIP image encoder as a further input of each frame; optional, its weights are not shipped."""

from __future__ import annotations

from typing import Final

import torch
from torch import Tensor, nn

from models.nets.vision.frozen import ClipTower

_OPTION: Final = "agent.policy.clip.path"
_MEAN, _DEVIATION = (0.48145466, 0.4578275, 0.40821073), (0.26862954, 0.26130258, 0.27577711)
"""Mean and standard deviation of the colours that CLIP was trained on (Radford et al., 2021)."""
_CHUNK: Final = 64


class ClipEye(ClipTower):
    """CLIP's image vectors of frames, computed once per frame and stored as float16.

    The model is transformers' ``CLIPVisionModelWithProjection``.
    """

    def __init__(self, path: str, option: str = _OPTION) -> None:
        """Set where the weights are; they are loaded on first use.

        Args:
            path: folder in Hugging Face layout (such as openai/clip-vit-base-patch32), or a name in its cache.
            option: name of the option with the path, for error messages.
        """
        super().__init__(path, "CLIPVisionModelWithProjection", option)

    @torch.no_grad()
    def vectors(self, rgb: Tensor) -> Tensor:
        """Unit vectors of frames.

        Args:
            rgb: (N, H, W, 3) uint8.

        Returns:
            (N, dim) float16 on the frames' device.

        Raises:
            DataError: the weights are missing or damaged.
        """
        model = self._weights.model.to(rgb.device)
        size = int(model.config.image_size)
        mean, deviation = (torch.tensor(v, device=rgb.device)[:, None, None] for v in (_MEAN, _DEVIATION))
        out = []
        for part in rgb.split(_CHUNK):
            images = part.permute(0, 3, 1, 2).float() / 255
            images = nn.functional.interpolate(images, (size, size), mode="bicubic", align_corners=False)
            found = model(pixel_values=(images - mean) / deviation).image_embeds.float()
            out.append((found / found.norm(dim=-1, keepdim=True)).half())
        return torch.cat(out)
