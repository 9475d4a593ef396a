"""A transformer over tokens of several kinds with positions in the plane; attention may depend on distance."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

#: Thresholds, in metres, of the soft steps that encode the distance between two tokens.
_STEPS_M = (0.5, 1.0, 2.0, 3.0, 4.5, 6.5, 9.0, 13.0)


class DistanceBias(nn.Module):
    """Learned bias of attention logits by the distance between two tokens, for every head.

    Args:
        heads: number of heads.
    """

    steps: Tensor

    def __init__(self, heads: int) -> None:
        super().__init__()
        self.register_buffer("steps", torch.tensor(_STEPS_M), persistent=False)
        self.weight = nn.Linear(len(_STEPS_M) + 1, heads, bias=False)
        nn.init.zeros_(self.weight.weight)

    def forward(self, xy: Tensor, placed: Tensor) -> Tensor:
        """Bias of all pairs of N tokens.

        Args:
            xy: (B, N, 2) positions in metres.
            placed: (B, N) bool, True for tokens with a position.

        Returns:
            (B, heads, N, N).
        """
        apart = torch.cdist(xy, xy)[..., None]  # (B, N, N, 1)
        both = (placed[:, :, None] & placed[:, None, :])[..., None].to(xy.dtype)
        steps = torch.sigmoid((apart - self.steps) / (0.4 * self.steps)) * both
        return self.weight(torch.cat([steps, both], -1)).permute(0, 3, 1, 2)


class TransformerBlock(nn.Module):
    """Pre-norm self-attention with a bias, and a feed-forward layer.

    Args:
        width: of tokens.
        heads: of attention.
        inner: units of the feed-forward layer.
    """

    def __init__(self, width: int, heads: int, inner: int) -> None:
        super().__init__()
        self.heads = heads
        self.norm_attention, self.norm_inner = nn.LayerNorm(width), nn.LayerNorm(width)
        self.qkv, self.out = nn.Linear(width, 3 * width), nn.Linear(width, width)
        self.inner = nn.Sequential(nn.Linear(width, inner), nn.GELU(), nn.Linear(inner, width))

    def forward(self, x: Tensor, bias: Tensor) -> Tensor:
        """Update tokens (B, N, D); ``bias`` (B, heads, N, N) is added to the attention logits."""
        b, n, d = x.shape
        q, k, v = self._qkv(x)
        seen = functional.scaled_dot_product_attention(q, k, v, attn_mask=bias)
        x = x + self.out(seen.transpose(1, 2).reshape(b, n, d))
        return x + self.inner(self.norm_inner(x))

    def attention(self, x: Tensor, bias: Tensor) -> Tensor:
        """Attention weights (B, heads, N, N), which :meth:`forward` does not return."""
        q, k, _ = self._qkv(x)
        return (q @ k.transpose(2, 3) / q.shape[-1] ** 0.5 + bias).softmax(-1)

    def _qkv(self, x: Tensor) -> Tensor:
        """Queries, keys and values, (3, B, heads, N, D / heads)."""
        b, n, d = x.shape
        qkv: Tensor = self.qkv(self.norm_attention(x)).view(b, n, 3, self.heads, d // self.heads)
        return qkv.permute(2, 0, 3, 1, 4)


class TokenTransformer(nn.Module):
    """Transformer blocks that share one bias by distance; padding is never attended to.

    Args:
        width: of tokens.
        layers: number of blocks.
        heads: of attention.
        inner: units of the feed-forward layers.
    """

    def __init__(self, width: int, layers: int, heads: int, inner: int) -> None:
        super().__init__()
        self.distance = DistanceBias(heads)
        self.blocks = nn.ModuleList(TransformerBlock(width, heads, inner) for _ in range(layers))
        self.norm = nn.LayerNorm(width)

    def forward(self, x: Tensor, xy: Tensor, placed: Tensor, there: Tensor) -> Tensor:
        """Update tokens.

        Args:
            x: (B, N, D) tokens.
            xy: (B, N, 2) positions in metres.
            placed: (B, N) bool, True for tokens with a position.
            there: (B, N) bool, False for padding.

        Returns:
            (B, N, D).
        """
        bias = self._bias(xy, placed, there)
        for block in self.blocks:
            x = block(x, bias)
        return self.norm(x)

    def attention(self, x: Tensor, xy: Tensor, placed: Tensor, there: Tensor) -> Tensor:
        """Attention weights of every block, (layers, B, heads, N, N), for display; arguments as for :meth:`forward`."""
        bias, weights = self._bias(xy, placed, there), []
        for block in self.blocks:
            assert isinstance(block, TransformerBlock)
            weights.append(block.attention(x, bias))
            x = block(x, bias)
        return torch.stack(weights)

    def _bias(self, xy: Tensor, placed: Tensor, there: Tensor) -> Tensor:
        return self.distance(xy, placed).masked_fill(~there[:, None, None, :], float("-inf"))  # type: ignore[no-any-return]
