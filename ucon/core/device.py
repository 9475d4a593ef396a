"""Where torch computes, by name; a machine without the GPU that was asked for says so in one line."""

from __future__ import annotations

from ucon.core.errors import ConfigError, brief


def torch_device(name: str, option: str = "device") -> str:
    """``name`` as torch knows it: ``cpu``, ``cuda``, ``cuda:1``; ``auto`` is a GPU if there is one.

    Raises:
        ConfigError: no such device here; the message names ``option``.
    """
    import torch

    if name == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    try:
        kind = torch.device(name)
    except (RuntimeError, TypeError):
        kind = torch.device("meta")
    if name != "cpu" and kind.type != "cuda":
        raise ConfigError(f"{option}={brief(name)}: expected cpu, cuda, cuda:NUMBER or auto")
    if kind.type == "cuda" and (kind.index or 0) >= torch.cuda.device_count():
        raise ConfigError(f"{option}={name}: torch sees no such GPU here; give {option}=cpu")
    return name
