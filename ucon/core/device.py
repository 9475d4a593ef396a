"""Where torch computes, by name; a machine without the GPU that was asked for says so in one line."""

from __future__ import annotations

import re

from ucon.core.errors import ConfigError, brief


def torch_device(name: str, option: str = "device") -> str:
    """``name`` as torch knows it: ``cpu``, ``cuda``, ``cuda:1``; ``auto`` is a GPU if there is one.

    Raises:
        ConfigError: no such device here; the message names ``option``.
    """
    import torch

    if name == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    if not re.fullmatch(r"cpu|cuda(:\d{1,3})?", str(name)):
        raise ConfigError(f"{option}={brief(name)}: expected cpu, cuda, cuda:NUMBER or auto")
    kind = torch.device(name)
    if kind.type == "cuda" and (kind.index or 0) >= torch.cuda.device_count():
        raise ConfigError(f"{option}={name}: torch sees no such GPU here; give {option}=cpu")
    return name
