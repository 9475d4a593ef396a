"""A frozen CLIP image encoder as one more look at each frame: optional, its weights are somebody else's."""

from __future__ import annotations

from typing import Final

import torch
from torch import Tensor, nn

from models.nets.vision.frozen import ClipTower

_OPTION: Final = "agent.policy.clip.path"
_MEAN, _DEVIATION = (0.48145466, 0.4578275, 0.40821073), (0.26862954, 0.26130258, 0.27577711)
"""Of the colours that CLIP was trained on (Radford et al., 2021)."""
_CHUNK: Final = 64


class ClipEye(ClipTower):
    """Unit vectors of frames by ``CLIPVisionModelWithProjection``: computed once a frame, stored in float16."""

    def __init__(self, path: str, option: str = _OPTION) -> None:
        """Describe the weights.

        Args:
            path: folder in Hugging Face layout (such as openai/clip-vit-base-patch32) or a name in its cache.
            option: what gave the path, for messages.
        """
        super().__init__(path, "CLIPVisionModelWithProjection", option)

    @torch.no_grad()
    def vectors(self, rgb: Tensor) -> Tensor:
        """Frames (N, H, W, 3) uint8 to unit vectors (N, dim) float16, on the frames' device."""
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
