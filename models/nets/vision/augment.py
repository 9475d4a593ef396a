"""Augmentation of image sequences: colour jitter and a shift, drawn once per episode and equal for all its steps."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import pad

#: Weights of red, green and blue in brightness (ITU-R 601).
_GREY = (0.299, 0.587, 0.114)


def color_jitter(images: Tensor, strength: float, generator: torch.Generator) -> Tensor:
    """Change brightness, contrast, saturation and hue, in this order.

    Args:
        images: (T, B, 3, H, W) in 0..1.
        strength: s; factors are drawn from 1 - s to 1 + s, turns of the hue from -s to s of a full circle.
        generator: of the CPU.

    Returns:
        Images of the same shape, in 0..1.
    """
    drawn = 2 * torch.rand(4, images.shape[1], generator=generator) - 1  # (4, B)
    shape = (1, -1, 1, 1, 1)
    brightness, contrast, saturation = ((1 + strength * drawn[k]).to(images).view(shape) for k in range(3))
    images = (images * brightness).clamp(0, 1)
    middle = grey(images).mean((2, 3, 4), keepdim=True)
    images = (middle + contrast * (images - middle)).clamp(0, 1)
    plain = grey(images)
    images = (plain + saturation * (images - plain)).clamp(0, 1)
    return turn_hue(images, strength * drawn[3].to(images)).clamp(0, 1)


def grey(images: Tensor) -> Tensor:
    """Brightness (..., 1, H, W) of images (..., 3, H, W)."""
    return (images * images.new_tensor(_GREY).view(3, 1, 1)).sum(-3, keepdim=True)


def turn_hue(images: Tensor, turns: Tensor) -> Tensor:
    """Rotate colours about the grey axis, at equal brightness.

    Linear in YIQ; at thirds of a turn red, green and blue change places, up to brightness.

    Args:
        images: (T, B, 3, H, W).
        turns: (B,) in full circles.
    """
    to_yiq = images.new_tensor([_GREY, (0.596, -0.274, -0.322), (0.211, -0.523, 0.312)])
    angle = 2 * torch.pi * turns
    cos, sin = angle.cos(), angle.sin()
    zero, one = torch.zeros_like(cos), torch.ones_like(cos)
    rows = [one, zero, zero, zero, cos, -sin, zero, sin, cos]
    turn = torch.stack(rows, -1).view(-1, 3, 3)  # (B, 3, 3)
    matrix = torch.linalg.inv(to_yiq) @ turn @ to_yiq
    return torch.einsum("bij,tbjhw->tbihw", matrix, images)


def random_shift(images: Tensor, most_px: int, generator: torch.Generator) -> Tensor:
    """Move images by up to ``most_px`` pixels in x and y; the border is repeated (DrQ).

    Args:
        images: (T, B, C, H, W).
        most_px: largest shift.
        generator: of the CPU.
    """
    steps, batch, _, height, width = images.shape
    moved = torch.randint(0, 2 * most_px + 1, (batch, 2), generator=generator).tolist()
    padded = pad(images.flatten(0, 1), (most_px,) * 4, mode="replicate").unflatten(0, (steps, batch))
    parts = [padded[:, b, :, y : y + height, x : x + width] for b, (y, x) in enumerate(moved)]
    return torch.stack(parts, 1)
