"""Low-rank adapters (LoRA) of a frozen BERT: ``y = W x + up(down(x))`` on every matrix of attention and MLP.

``up`` starts at zero, so a new adapter changes nothing. Adapters are stored as fp16 safetensors that name the weights
they belong to. For use they are added to the matrices, so an adapted encoder costs what the frozen one does.

This module imports torch; :mod:`ucon.language.adapted` does not.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import torch
from safetensors.torch import save
from torch import Tensor, nn

from ucon.core.errors import DataError, brief
from ucon.core.files import read_verified
from ucon.core.rng import derived_seed
from ucon.core.tensor_files import check_finite, header, metadata, read_tensors

BASE_KEY: Final = "base_sha256"
#: Largest adapter file: three times the encoder.
_MOST_BYTES: Final = 256 << 20


class LowRank(nn.Module):
    """A frozen linear map with a trainable low-rank addition.

    Attributes:
        base: the frozen map.
        down: (rank, in), random at first.
        up: (out, rank), zero at first.
    """

    def __init__(self, base: nn.Linear, rank: int, generator: torch.Generator) -> None:
        super().__init__()
        self.base = base
        start = torch.randn(rank, base.in_features, generator=generator) / base.in_features**0.5
        self.down = nn.Parameter(start)  # (rank, in)
        self.up = nn.Parameter(torch.zeros(base.out_features, rank))  # (out, rank)

    def forward(self, x: Tensor) -> Tensor:
        """Apply it: (..., in) -> (..., out)."""
        added: Tensor = nn.functional.linear(nn.functional.linear(x, self.down), self.up)
        return self.base(x) + added


def add_adapters(model: nn.Module, rank: int, seed: int) -> dict[str, nn.Parameter]:
    """Freeze a model and add adapters to the linear maps of its encoder layers, in place.

    Args:
        model: a BERT.
        rank: of the adapters.
        seed: of their initial values.

    Returns:
        Trainable parameters by name.
    """
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
    """Add an adapter to the matrices of a plain model, in place.

    Args:
        model: a BERT.
        adapter: matrices by name.
        where: names the adapter in errors.

    Raises:
        DataError: names or shapes are not those of this model.
    """
    maps = _linear_maps(model)
    wanted = {f"{name}.{part}" for name in maps for part in ("down", "up")}
    if set(adapter) != wanted:
        odd = ", ".join(map(brief, sorted(set(adapter) ^ wanted)[:3]))
        raise DataError(f"{where}: not an adapter of this encoder ({odd}); use the encoder it was made for")
    for name, module in maps.items():  # check all before adding any
        down, up = adapter[f"{name}.down"].shape, adapter[f"{name}.up"].shape
        if (up[:1], down[1:]) != (module.weight.shape[:1], module.weight.shape[1:]) or up[1:] != down[:1]:
            raise DataError(f"{where}: {name} does not fit {tuple(module.weight.shape)}; use its own encoder")
    with torch.no_grad():
        for name, module in maps.items():
            module.weight += adapter[f"{name}.up"].float() @ adapter[f"{name}.down"].float()


def begin_with(parameters: Mapping[str, nn.Parameter], adapter: Mapping[str, Tensor], where: str) -> None:
    """Copy an adapter's values into the parameters of :func:`add_adapters`.

    Args:
        parameters: to be written.
        adapter: matrices by name.
        where: names the adapter in errors.

    Raises:
        DataError: names or shapes differ, as with another rank.
    """
    shapes = {name: tuple(value.shape) for name, value in parameters.items()}
    if odd := sorted(name for name, value in adapter.items() if shapes.get(name) != tuple(value.shape)):
        found, expected = tuple(adapter[odd[0]].shape), shapes.get(odd[0])
        raise DataError(
            f"{where}: {brief(odd[0])} is {brief(found)}, expected {brief(expected)}; give its own learner.rank"
        )
    if missing := sorted(shapes.keys() - adapter.keys()):
        raise DataError(f"{where}: no {missing[0]} in it; use the encoder it was made for")
    with torch.no_grad():
        for name, value in parameters.items():
            value.copy_(adapter[name])


def adapter_bytes(parameters: Mapping[str, Tensor], base_sha256: str) -> bytes:
    """The bytes of an adapter file: fp16 matrices, with the hash of the weights they belong to."""
    half = {name: value.detach().to(torch.float16).contiguous() for name, value in sorted(parameters.items())}
    return save(half, {BASE_KEY: base_sha256})


def read_adapter(path: Path, base_sha256: str) -> dict[str, Tensor]:
    """Read an adapter file and check it against its folder's manifest.

    Args:
        path: the file.
        base_sha256: hash of the encoder's weights.

    Returns:
        Matrices by name.

    Raises:
        DataError: missing, truncated or altered, not safetensors, or made for other weights.
    """
    raw = read_verified(path, _MOST_BYTES)
    try:
        base = metadata(raw, path).get(BASE_KEY)
        kinds = {kind for kind, _ in header(raw, path).values()}
        if odd := sorted(kinds - {"float16", "float32"}):
            raise DataError(f"{path}: matrices of {odd[0]}, expected float16; train it again")
        tensors = read_tensors(raw, path)
        check_finite(tensors, path)
    except DataError as error:
        raise DataError(f"not an adapter: {error} with `train.py learner=retriever`") from None
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
