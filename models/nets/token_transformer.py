"""A transformer over tokens of different kinds that know where they are: attention may fade with distance."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

#: Metres at which the distance between two tokens is measured by soft steps.
_STEPS_M = (0.5, 1.0, 2.0, 3.0, 4.5, 6.5, 9.0, 13.0)


class DistanceBias(nn.Module):
    """What the distance between two tokens adds to their attention, for every head."""

    steps: Tensor

    def __init__(self, heads: int) -> None:
        super().__init__()
        self.register_buffer("steps", torch.tensor(_STEPS_M), persistent=False)
        self.weight = nn.Linear(len(_STEPS_M) + 1, heads, bias=False)
        nn.init.zeros_(self.weight.weight)

    def forward(self, xy: Tensor, placed: Tensor) -> Tensor:
        """(B, H, N, N) from positions (B, N, 2) in metres and which tokens have one (B, N) bool."""
        apart = torch.cdist(xy, xy)[..., None]  # (B, N, N, 1)
        both = (placed[:, :, None] & placed[:, None, :])[..., None].to(xy.dtype)
        steps = torch.sigmoid((apart - self.steps) / (0.4 * self.steps)) * both
        return self.weight(torch.cat([steps, both], -1)).permute(0, 3, 1, 2)


class TransformerBlock(nn.Module):
    """Pre-norm self-attention with a bias, and a feed-forward part."""

    def __init__(self, width: int, heads: int, inner: int) -> None:
        super().__init__()
        self.heads = heads
        self.norm_attention, self.norm_inner = nn.LayerNorm(width), nn.LayerNorm(width)
        self.qkv, self.out = nn.Linear(width, 3 * width), nn.Linear(width, width)
        self.inner = nn.Sequential(nn.Linear(width, inner), nn.GELU(), nn.Linear(inner, width))

    def forward(self, x: Tensor, bias: Tensor) -> Tensor:
        """Tokens (B, N, D) and what is added to the attention (B, H, N, N)."""
        b, n, d = x.shape
        q, k, v = self._qkv(x)
        seen = functional.scaled_dot_product_attention(q, k, v, attn_mask=bias)
        x = x + self.out(seen.transpose(1, 2).reshape(b, n, d))
        return x + self.inner(self.norm_inner(x))

    def attention(self, x: Tensor, bias: Tensor) -> Tensor:
        """Weights (B, H, N, N) by which each token attends to the others: what :meth:`forward` does not keep."""
        q, k, _ = self._qkv(x)
        return (q @ k.transpose(2, 3) / q.shape[-1] ** 0.5 + bias).softmax(-1)

    def _qkv(self, x: Tensor) -> Tensor:
        """(3, B, H, N, D / H)."""
        b, n, d = x.shape
        qkv: Tensor = self.qkv(self.norm_attention(x)).view(b, n, 3, self.heads, d // self.heads)
        return qkv.permute(2, 0, 3, 1, 4)


class TokenTransformer(nn.Module):
    """Blocks that share one bias by distance; tokens that are not there are attended by none."""

    def __init__(self, width: int, layers: int, heads: int, inner: int) -> None:
        super().__init__()
        self.distance = DistanceBias(heads)
        self.blocks = nn.ModuleList(TransformerBlock(width, heads, inner) for _ in range(layers))
        self.norm = nn.LayerNorm(width)

    def forward(self, x: Tensor, xy: Tensor, placed: Tensor, there: Tensor) -> Tensor:
        """Tokens (B, N, D), positions (B, N, 2) metres, which have one and which are there (B, N) bool."""
        bias = self._bias(xy, placed, there)
        for block in self.blocks:
            x = block(x, bias)
        return self.norm(x)

    def attention(self, x: Tensor, xy: Tensor, placed: Tensor, there: Tensor) -> Tensor:
        """Weights (L, B, H, N, N) of every block, of the same tokens: for people, nothing in use needs them."""
        bias, weights = self._bias(xy, placed, there), []
        for block in self.blocks:
            assert isinstance(block, TransformerBlock)
            weights.append(block.attention(x, bias))
            x = block(x, bias)
        return torch.stack(weights)

    def _bias(self, xy: Tensor, placed: Tensor, there: Tensor) -> Tensor:
        return self.distance(xy, placed).masked_fill(~there[:, None, None, :], float("-inf"))  # type: ignore[no-any-return]
