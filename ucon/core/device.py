"""Where torch computes and how, by name: ``auto`` is settled here, by the device alone.

A machine without the GPU that was asked for says so in one line.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from ucon.core.errors import ConfigError, brief, unknown_name

if TYPE_CHECKING:
    import torch

AUTO: Final = "auto"
PRECISIONS: Final = ("float32", "bfloat16")
#: So many times what a CPU takes at once, a GPU takes.
_LARGER: Final = 4
#: Compute capability from which NVIDIA's cards multiply in bfloat16.
_BFLOAT16_FROM: Final = (8, 0)


def torch_device(name: str, option: str = "device") -> str:
    """``name`` as torch knows it: ``cpu``, ``cuda``, ``cuda:1``; ``auto`` is a GPU if there is one.

    Raises:
        ConfigError: no such device here; the message names ``option``.
    """
    import torch

    if name == AUTO:
        return "cuda" if torch.cuda.is_available() else "cpu"
    if not re.fullmatch(r"cpu|cuda(:\d{1,3})?", str(name)):
        raise ConfigError(f"{option}={brief(name)}: expected cpu, cuda, cuda:NUMBER or auto")
    kind = torch.device(name)
    if kind.type == "cuda" and (kind.index or 0) >= torch.cuda.device_count():
        raise ConfigError(f"{option}={name}: torch sees no such GPU here; give {option}=cpu")
    return name


def torch_precision(name: str, device: str = "cpu") -> torch.dtype:
    """The type that a network's passes multiply in; ``auto`` is bfloat16 on a GPU that has it, else float32.

    Args:
        name: ``float32``, ``bfloat16`` or ``auto``.
        device: as :func:`torch_device` gives it.

    Raises:
        ConfigError: no such precision.
    """
    import torch

    if name == AUTO:
        on_gpu = torch.device(device).type == "cuda"
        halves = on_gpu and torch.cuda.get_device_capability(device) >= _BFLOAT16_FROM
        return torch.bfloat16 if halves else torch.float32
    if name not in PRECISIONS:
        raise ConfigError(unknown_name("precision", str(name), (*PRECISIONS, AUTO)))
    return torch.bfloat16 if name == "bfloat16" else torch.float32


def cpu_precision(wanted: torch.dtype) -> torch.dtype:
    """``wanted``, but float32 for bfloat16 on a processor that has no such multiplication.

    Without AVX-512 torch emulates it, 45 times slower than float32.
    """
    import torch

    if wanted == torch.bfloat16 and not torch.ops.mkldnn._is_mkldnn_bf16_supported():
        return torch.float32
    return wanted


def batch_size(size: int | str, device: str, on_cpu: int) -> int:
    """How much is taken at once: ``size``; for ``auto`` ``on_cpu``, and four times as much on a GPU."""
    if size == AUTO:
        return on_cpu if device == "cpu" else _LARGER * on_cpu
    return size  # type: ignore[return-value]  # configurations are not typed; a learner checks it
