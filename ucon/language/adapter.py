"""Low-rank adapters (LoRA) of a frozen BERT: ``y = W x + up(down(x))`` on every matrix of attention and MLP.

``up`` starts at zero, so a new adapter changes nothing. Adapters are kept as fp16 safetensors that name the weights
they belong to; for use they are added into the matrices, so an adapted encoder costs what the frozen one does.

Imported where torch is needed anyway; :mod:`ucon.language.adapted` is the cheap way in.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import torch
from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor, nn

from ucon.core.errors import DataError, brief
from ucon.core.files import read_verified
from ucon.core.rng import derived_seed
from ucon.core.strict_json import parse_json

BASE_KEY: Final = "base_sha256"


class LowRank(nn.Module):
    """A frozen linear map with a trainable low-rank addition."""

    def __init__(self, base: nn.Linear, rank: int, generator: torch.Generator) -> None:
        super().__init__()
        self.base = base
        start = torch.randn(rank, base.in_features, generator=generator) / base.in_features**0.5
        self.down = nn.Parameter(start)  # (rank, in)
        self.up = nn.Parameter(torch.zeros(base.out_features, rank))  # (out, rank)

    def forward(self, x: Tensor) -> Tensor:
        """(..., in) -> (..., out)."""
        added: Tensor = nn.functional.linear(nn.functional.linear(x, self.down), self.up)
        return self.base(x) + added


def add_adapters(model: nn.Module, rank: int, seed: int) -> dict[str, nn.Parameter]:
    """Freeze ``model``, wrap the linear maps of its encoder layers, return what is to be trained by name."""
    model.requires_grad_(False)
    generator = torch.Generator().manual_seed(derived_seed(seed, "adapter"))
    parameters: dict[str, nn.Parameter] = {}
    for name, module in _linear_maps(model).items():
        parent, _, child = name.rpartition(".")
        wrapped = LowRank(module, rank, generator)
        setattr(model.get_submodule(parent), child, wrapped)
        parameters |= {f"{name}.down": wrapped.down, f"{name}.up": wrapped.up}
    return parameters


def merge(model: nn.Module, adapter: Mapping[str, Tensor], where: str = "adapter") -> None:
    """Add an adapter into the matrices of a plain model.

    Raises:
        DataError: names or shapes are not those of this model.
    """
    maps = _linear_maps(model)
    wanted = {f"{name}.{part}" for name in maps for part in ("down", "up")}
    if set(adapter) != wanted:
        odd = sorted(set(adapter) ^ wanted)[:3]
        raise DataError(f"{where}: not an adapter of this encoder ({', '.join(odd)}); use the encoder it was made for")
    with torch.no_grad():
        for name, module in maps.items():
            down, up = adapter[f"{name}.down"].float(), adapter[f"{name}.up"].float()
            shape = (up.shape[0], down.shape[1]) if up.shape[1:] == down.shape[:1] else None
            if shape != tuple(module.weight.shape):
                raise DataError(f"{where}: {name} does not fit {tuple(module.weight.shape)}; use its own encoder")
            module.weight += up @ down


def adapter_bytes(parameters: Mapping[str, Tensor], base_sha256: str) -> bytes:
    """The file of an adapter: fp16, with the hash of the weights that it belongs to."""
    half = {name: value.detach().to(torch.float16).contiguous() for name, value in sorted(parameters.items())}
    return save(half, {BASE_KEY: base_sha256})


def read_adapter(path: Path, base_sha256: str) -> dict[str, Tensor]:
    """Matrices of an adapter file that the manifest of its folder lists.

    Raises:
        DataError: missing, truncated or altered, not safetensors, or made for other weights.
    """
    raw = read_verified(path)
    try:
        tensors: dict[str, Tensor] = load(raw)
        size = int.from_bytes(raw[:8], "little")
        base = parse_json(raw[8 : 8 + size]).get("__metadata__", {}).get(BASE_KEY)
    except (SafetensorError, ValueError, KeyError) as error:
        why = brief(str(error))
        raise DataError(f"{path}: not an adapter ({why}); train one with `train.py learner=retriever`") from None
    if base != base_sha256:
        raise DataError(
            f"{path}: made for weights {brief(str(base)[:12])}, the encoder has {base_sha256[:12]}; use its own encoder"
        )
    return tensors


def _linear_maps(model: nn.Module) -> dict[str, nn.Linear]:
    """Attention and MLP matrices of the encoder's layers by name."""
    found = {name: m for name, m in model.named_modules() if isinstance(m, nn.Linear) and name.startswith("encoder.")}
    if not found:
        raise DataError(f"{type(model).__name__}: no encoder layers to adapt; expected a BERT")
    return found
