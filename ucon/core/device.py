"""Torch devices and precisions by name, with one-line errors; ``auto`` depends on the machine alone."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from ucon.core.errors import ConfigError, brief, unknown_name

if TYPE_CHECKING:
    import torch

AUTO: Final = "auto"
NO_GPU: Final = "torch sees no such GPU here"
"""Error text for a GPU that torch does not see."""
PRECISIONS: Final = ("float32", "bfloat16")
#: Batch size on a GPU relative to a CPU, for ``auto``.
_LARGER: Final = 4
#: Compute capability from which NVIDIA's cards multiply in bfloat16.
_BFLOAT16_FROM: Final = (8, 0)


def torch_device(name: str, option: str = "device") -> str:
    """The torch device of a name.

    Args:
        name: ``cpu``, ``cuda``, ``cuda:1``; ``auto`` is a GPU if there is one.
        option: names the option in errors.

    Raises:
        ConfigError: no such device here.
    """
    import torch

    if name == AUTO:
        return "cuda" if torch.cuda.is_available() else "cpu"
    if not re.fullmatch(r"cpu|cuda(:\d{1,3})?", str(name)):
        raise ConfigError(f"{option}={brief(name)}: expected cpu, cuda, cuda:NUMBER or auto")
    kind = torch.device(name)
    if kind.type == "cuda" and (kind.index or 0) >= torch.cuda.device_count():
        raise ConfigError(f"{option}={name}: {NO_GPU}; give {option}=cpu")
    return name


def torch_precision(name: str, device: str = "cpu", *, on_cpu: bool = False) -> torch.dtype:
    """The type of a network's matrix products.

    Args:
        name: ``float32``, ``bfloat16``, or ``auto``: bfloat16 on a GPU with bfloat16 products, else float32.
        device: as :func:`torch_device` gives it.
        on_cpu: whether ``auto`` means bfloat16 on a processor that supports it, too.

    Raises:
        ConfigError: no such precision.
    """
    import torch

    if name == AUTO:
        if torch.device(device).type == "cuda":
            halves = torch.cuda.get_device_capability(device) >= _BFLOAT16_FROM
        else:
            halves = on_cpu and (torch.cpu._is_avx512_bf16_supported() or torch.cpu._is_amx_tile_supported())
        return torch.bfloat16 if halves else torch.float32
    if name not in PRECISIONS:
        raise ConfigError(unknown_name("precision", str(name), (*PRECISIONS, AUTO)))
    return torch.bfloat16 if name == "bfloat16" else torch.float32


def cpu_precision(wanted: torch.dtype) -> torch.dtype:
    """The wanted type, but float32 instead of bfloat16 on a processor without bfloat16 products.

    Without AVX-512 torch emulates them, 45 times slower than float32.
    """
    import torch

    if wanted == torch.bfloat16 and not torch.ops.mkldnn._is_mkldnn_bf16_supported():
        return torch.float32
    return wanted


def batch_size(size: int | str, device: str, on_cpu: int) -> int:
    """The batch size of an option.

    Args:
        size: a number, or ``auto``.
        device: as :func:`torch_device` gives it.
        on_cpu: the value of ``auto`` on a CPU; four times as much on a GPU.
    """
    if size == AUTO:
        return on_cpu if device == "cpu" else _LARGER * on_cpu
    return size  # type: ignore[return-value]  # configurations are not typed; a learner checks it
