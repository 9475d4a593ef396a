"""Weights of a network as a folder: what ``train.py`` leaves in ``model/``, and what agents are given as checkpoint.

policy.safetensors   all that is learned, in float32 or, rounded, in float16
config.json          format, architecture and arguments: the network that the weights belong to; of one that reads
                     habits also max_habits, the longest list that it may have learned from (absent: MAX_HABITS)
MANIFEST.json        sizes and SHA-256 of both, written by whoever writes the files

A network is not built from these files; it is built by its configuration, and then either fits them or says why not.
So nothing in a folder decides what code runs.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

from ucon.core.errors import DataError, brief
from ucon.core.files import canonical_json, read_verified, sha256_bytes
from ucon.core.tensor_files import read_fitting
from ucon.core.untrusted.strict_json import parse_json

if TYPE_CHECKING:
    from torch import Tensor

WEIGHTS: Final = "policy.safetensors"
CONFIG: Final = "config.json"
#: Where a run of ``train.py`` puts them.
IN_RUN: Final = "model"
FORMAT: Final = 1
#: Habits of the longest list that environments give by default, in training too.
MAX_HABITS: Final = 1024
#: More than any environment gives.
_MOST_HABITS: Final = 1 << 20
_MOST_CONFIG: Final = 1 << 20


class Network(Protocol):
    """A torch module that says what it is."""

    architecture: str

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Plain values that its weights depend on beside the architecture."""
        ...

    def state_dict(self) -> dict[str, Tensor]:
        """Its tensors by name."""
        ...

    def load_state_dict(self, state_dict: Mapping[str, Any], strict: bool = True) -> Any:
        """Take tensors over."""
        ...


def network_files(network: Network, *, half: bool = False) -> dict[str, bytes]:
    """The files of a network by name, to be written beside a manifest (as a learner's product is).

    Args:
        network: whose weights.
        half: float16 in place of float32. Whole numbers stay as they are.

    Raises:
        DataError: a weight that is not finite, or beyond what float16 holds.
    """
    import torch
    from safetensors.torch import save

    tensors = {}
    for name, tensor in sorted(network.state_dict().items()):
        kept = tensor.detach().cpu()
        kept = kept.half() if half and kept.is_floating_point() else kept
        if kept.is_floating_point() and not bool(torch.isfinite(kept).all()):
            raise DataError(f"{network.architecture}: {name} is not finite in {kept.dtype}; nothing is saved")
        tensors[name] = kept.clone().contiguous()
    config = {"format": FORMAT, "architecture": network.architecture, "arguments": dict(network.arguments)}
    if (most := getattr(network, "max_habits", None)) is not None:
        config["max_habits"] = most
    return {WEIGHTS: save(tensors), CONFIG: (json.dumps(config, indent=1, sort_keys=True) + "\n").encode()}


def learns_from(network: Any, env: Any) -> None:
    """Tell a network that reads habits how many its environment gives in training at most."""
    if getattr(network, "max_habits", None) is not None:
        network.max_habits = env.max_habits


def model_folder(path: str) -> Path | None:
    """The folder of weights that ``path`` names: itself, or ``model/`` in a run of ``train.py``; None if it is none."""
    folder = Path(path).expanduser()
    return next((found for found in (folder, folder / IN_RUN) if (found / CONFIG).is_file()), None)


def load_network(path: str, network: Network, *, how: str = "") -> str:
    """Give ``network`` the weights in a folder, or in that of a run; returns their SHA-256.

    A network that says by ``max_habits`` how many habits it may be given is told what these weights learned from.

    ``how`` says at the end of the message where there are none how to get them.

    Raises:
        DataError: no weights there; truncated, altered or no safetensors; of another network.
    """
    folder = model_folder(path)
    if folder is None:
        missing = f"{path}: no trained weights there (no {CONFIG} and {WEIGHTS})"
        raise DataError(f"{missing}; {how}" if how else missing)
    most = _check_config(folder / CONFIG, network)
    tensors, raw = read_fitting(folder / WEIGHTS, network.state_dict())
    network.load_state_dict(tensors)
    if getattr(network, "max_habits", None) is not None:
        network.max_habits = most  # type: ignore[attr-defined]
    return sha256_bytes(raw)


def _check_config(path: Path, network: Network) -> int:
    """Refuse weights of another architecture or version of it; returns how many habits they learned from at most."""
    try:
        config = parse_json(read_verified(path, _MOST_CONFIG))
        found, number, arguments = config["architecture"], config["format"], config["arguments"]
        most = config.get("max_habits", MAX_HABITS)
    except (ValueError, LookupError, TypeError):
        raise DataError(f"{path}: does not describe a network; train it anew") from None
    if not isinstance(arguments, dict) or type(most) is not int or not 1 <= most <= _MOST_HABITS:
        raise DataError(f"{path}: does not describe a network; train it anew")
    if number != FORMAT:
        raise DataError(f"{path}: format {brief(number)}, this version reads {FORMAT}; train it anew")
    if found != network.architecture:
        raise DataError(
            f"{path}: weights of architecture {brief(found)}, expected {network.architecture}; give its own agent="
        )
    wanted = json.loads(canonical_json(dict(network.arguments)))
    for name in sorted(wanted.keys() | arguments.keys()):
        if wanted.get(name) != arguments.get(name):
            made, here = brief(arguments.get(name)), brief(wanted.get(name))
            raise DataError(f"{path}: weights made with {name}={made}, the agent has {name}={here}; use the same")
    return most
