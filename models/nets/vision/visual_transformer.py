"""VTN's visual transformer (Du, Yu and Zheng, ICLR 2021): features of a frame's 49 regions, given its things.

The encoder reads the things; the decoder attends to them from each region, whose query is the frozen network's map plus
a position code. The layers are those of DETR (post-norm, 8 heads, 512 hidden units).
"""

from __future__ import annotations

import math
from typing import Final

import torch
from torch import Tensor, nn
from torch.nn.functional import dropout, linear, relu, softmax

from models.nets.vision.backbone import SIDE
from models.nets.vision.local_tokens import TOKENS, WIDTH

REGIONS: Final = SIDE * SIDE
REGION_WIDTH: Final = 64
#: Size of a frame's features: 49 x 64.
VISUAL_WIDTH: Final = REGIONS * REGION_WIDTH
_HEADS, _HIDDEN, _LAYERS = 8, 512, 6
#: Number of a token's 256 components that hold label, box (4), score and target.
_DESCRIBED: Final = 7
#: VTNet has 22 labels and feeds in their numbers; our labels are scaled to that range.
_LABEL_RANGE: Final = 22.0


class DecoderLayer(nn.Module):
    """DETR's decoder layer; position queries are added as in DETR.

    They are added to queries and keys of self-attention, and to the queries of cross-attention.

    Args:
        dropout: of attention and feed-forward layers.
    """

    def __init__(self, dropout: float) -> None:
        super().__init__()
        self.self_attention = nn.MultiheadAttention(WIDTH, _HEADS, dropout, batch_first=True)
        self.cross_attention = nn.MultiheadAttention(WIDTH, _HEADS, dropout, batch_first=True)
        self.linear1, self.linear2 = nn.Linear(WIDTH, _HIDDEN), nn.Linear(_HIDDEN, WIDTH)
        self.norms = nn.ModuleList(nn.LayerNorm(WIDTH) for _ in range(3))
        self.dropout = nn.Dropout(dropout)

    def forward(self, x: Tensor, memory: Tensor, query: Tensor, weight: Tensor) -> Tensor:
        """Update the regions.

        Args:
            x: (N, 49, 256) regions.
            memory: (N, L, 256) encoded things.
            query: (N, 49, 256) position queries of the regions.
            weight: (L,) added to the attention logits of things.
        """
        asked = x + query
        found = attended(self.self_attention, asked, asked, x)
        x = self.norms[0](x + self.dropout(found))
        found = attended(self.cross_attention, x + query, memory, memory, weight)
        x = self.norms[1](x + self.dropout(found))
        found = self.linear2(self.dropout(relu(self.linear1(x))))
        out: Tensor = self.norms[2](x + self.dropout(found))
        return out


class VisualTransformer(nn.Module):
    """Encodes frames as 3136 numbers each; 8.0 M parameters.

    Args:
        dropout: of encoder and decoder.
        channels: of the frozen network's maps.
    """

    position: Tensor

    def __init__(self, dropout: float = 0.1, channels: int = 512) -> None:
        super().__init__()
        self.local_embed = nn.Linear(WIDTH, WIDTH - _DESCRIBED)
        self.global_embed = nn.Conv2d(channels, WIDTH, 1)
        self.register_buffer("position", position_code(SIDE, WIDTH), persistent=False)
        layer = nn.TransformerEncoderLayer(WIDTH, _HEADS, _HIDDEN, dropout, batch_first=True)
        self.encoder = nn.TransformerEncoder(layer, _LAYERS, enable_nested_tensor=False)
        self.decoder = nn.ModuleList(DecoderLayer(dropout) for _ in range(_LAYERS))
        self.norm = nn.LayerNorm(WIDTH)
        self.regions = nn.Sequential(nn.Linear(WIDTH, 128), nn.ReLU(), nn.Linear(128, REGION_WIDTH), nn.ReLU())

    def forward(self, features: Tensor, things: Tensor, maps: Tensor) -> Tensor:
        """Features of N frames, (N, 3136).

        Args:
            features: (N, 100, 256) of the things.
            things: (N, 100, 7), see :func:`described`.
            maps: (N, channels, 7, 7) of the frozen network.
        """
        features, things, weight = merged(features, things)
        tokens = torch.cat([relu(self.local_embed(features)), things], -1)  # (N, L, 256)
        query = relu(self.global_embed(maps)).flatten(2).transpose(1, 2) + self.position  # (N, 49, 256)
        memory = self._encoded(tokens, weight)
        x = torch.zeros_like(query)
        for layer in self.decoder:
            x = layer(x, memory, query, weight)
        return self.regions(self.norm(x)).flatten(1)

    def _encoded(self, x: Tensor, weight: Tensor) -> Tensor:
        """Things (N, L, 256) after attending to each other; ``weight`` (L,) is added to their attention logits."""
        for layer in self.encoder.layers:
            assert isinstance(layer, nn.TransformerEncoderLayer)
            x = layer.norm1(x + layer.dropout1(attended(layer.self_attn, x, x, x, weight)))
            x = layer.norm2(x + layer.dropout2(layer.linear2(layer.dropout(relu(layer.linear1(x))))))
        return x


def attended(
    module: nn.MultiheadAttention, query: Tensor, key: Tensor, value: Tensor, weight: Tensor | None = None
) -> Tensor:
    """Attention with a module's weights; its own fast path would take numbers that are added to logits for a mask.

    Written out because torch's fused attention without dropout doubles the time of an update in bfloat16.

    Args:
        module: holds the weights.
        query: (N, Q, D).
        key: (N, L, D).
        value: (N, L, D).
        weight: (L,) added to the logits.

    Returns:
        (N, Q, D).
    """
    heads, width = module.num_heads, module.head_dim
    q, k, v = (
        linear(x, w, b).unflatten(-1, (heads, width)).transpose(1, 2)
        for x, w, b in zip(
            (query, key, value), module.in_proj_weight.chunk(3), module.in_proj_bias.chunk(3), strict=True
        )
    )
    logits = q @ k.transpose(-1, -2) * width**-0.5
    shares = softmax(logits if weight is None else logits + weight, -1).to(v.dtype)
    found = dropout(shares, module.dropout, module.training) @ v
    out: Tensor = module.out_proj(found.transpose(1, 2).flatten(2))
    return out


def merged(features: Tensor, things: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Merge unused tokens into one: attending to k equal tokens is attending to one with log k added to its logit.

    Most frames show a fifth of the things that there is room for.

    Args:
        features: (N, 100, 256) of the things; used rows come first.
        things: (N, 100, 7), zero in unused rows.

    Returns:
        Features (N, L, 256), things (N, L, 7), and what is added to the attention logit of each, (L,).
    """
    used = int((things != 0).any(-1).any(0).sum())
    weight = torch.zeros(min(used + 1, TOKENS), dtype=features.dtype, device=features.device)
    if used < TOKENS:
        weight[-1] = math.log(TOKENS - used)
    return features[:, : len(weight)], things[:, : len(weight)], weight


def described(label: Tensor, n_labels: int, box: Tensor, score: Tensor, target: Tensor) -> Tensor:
    """The last 7 components of things' tokens, (N, 100, 7).

    Args:
        label: (N, 100).
        n_labels: labels are scaled by it to VTNet's range.
        box: (N, 100, 4) in 0..1.
        score: (N, 100).
        target: (N, 100) indicator of the target.
    """
    parts = [label.float()[..., None] * (_LABEL_RANGE / n_labels), box.float(), score.float()[..., None]]
    return torch.cat([*parts, target[..., None]], -1)


def position_code(side: int, width: int) -> Tensor:
    """DETR's sine code, (side * side, width): half of it for the row, half for the column, counted from 1."""
    half = width // 2
    rate = 10_000 ** (2 * (torch.arange(half) // 2) / half)
    angle = torch.arange(1, side + 1)[:, None] / rate  # (side, half)
    code = torch.where(torch.arange(half) % 2 == 0, angle.sin(), angle.cos())
    rows, columns = code[:, None].expand(side, side, half), code[None].expand(side, side, half)
    return torch.cat([rows, columns], -1).reshape(side * side, width)


def glorot_(module: nn.Module) -> None:
    """VTNet's initialisation of convolutions and linear layers: uniform Glorot, biases 0.

    For :meth:`torch.nn.Module.apply`. Attention's joint projections are drawn by DETR's rule: the same, for the joint
    shape.
    """
    if isinstance(module, nn.MultiheadAttention):
        nn.init.xavier_uniform_(module.in_proj_weight)
        nn.init.zeros_(module.in_proj_bias)
    elif isinstance(module, nn.Conv2d | nn.Linear):
        nn.init.xavier_uniform_(module.weight)
        if module.bias is not None:
            nn.init.zeros_(module.bias)
