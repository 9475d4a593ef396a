"""Weights of a network as a folder: what ``train.py`` leaves in ``model/``, and what agents take as ``checkpoint``.

policy.safetensors   all trained tensors, in float32, or rounded to float16
config.json          format, architecture and arguments of the network that the weights belong to; for a network that
                     reads habits also max_habits, the longest list in training (absent: MAX_HABITS)
MANIFEST.json        sizes and SHA-256 of both, added by the caller that writes the files

No network is built from these files. It is built from its configuration, and then the files either fit it or are
refused, so nothing in a folder decides which code runs.
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
from ucon.learning.run.run_folder import CHECKPOINTS

if TYPE_CHECKING:
    from torch import Tensor

WEIGHTS: Final = "policy.safetensors"
CONFIG: Final = "config.json"
#: Name of the folder in a run of ``train.py``.
IN_RUN: Final = "model"
FORMAT: Final = 1
#: Longest list of habits that environments give by default, in training too.
MAX_HABITS: Final = 1024
#: Upper bound for the check of ``max_habits``; no environment gives as many.
_MOST_HABITS: Final = 1 << 20
_MOST_CONFIG: Final = 1 << 20


class Network(Protocol):
    """A torch module that names its architecture and the arguments that its weights depend on."""

    architecture: str

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Plain values that must be equal for weights to fit: sizes, and hashes of frozen networks."""
        ...

    def state_dict(self) -> dict[str, Tensor]:
        """The trained tensors by name; frozen networks are left out."""
        ...

    def load_state_dict(self, state_dict: Mapping[str, Any], strict: bool = True) -> Any:
        """Copy tensors into the network; as in torch."""
        ...


def network_files(network: Network, *, half: bool = False) -> dict[str, bytes]:
    """Files of a network by name; the caller writes them with a manifest.

    Args:
        network: whose weights.
        half: store floating-point tensors as float16; integers stay as they are.

    Raises:
        DataError: a weight that is not finite, or too large for float16.
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


def set_max_habits(network: Any, env: Any) -> None:
    """Set ``network.max_habits`` to the longest list of habits that the training environment gives.

    Does nothing for a network without ``max_habits``, which reads no habits.

    Args:
        network: what is trained.
        env: has ``max_habits``.
    """
    if getattr(network, "max_habits", None) is not None:
        network.max_habits = env.max_habits


def model_folder(path: str) -> Path | None:
    """Folder of weights that a path names.

    Args:
        path: the folder itself, or a run of ``train.py`` with ``model/`` in it.

    Returns:
        The folder, or None where neither has a ``config.json``.
    """
    folder = Path(path).expanduser()
    return next((found for found in (folder, folder / IN_RUN) if (found / CONFIG).is_file()), None)


def load_network(path: str, network: Network, *, how: str = "") -> str:
    """Load the weights in a folder into a network, and set its ``max_habits`` if it has one.

    Args:
        path: folder of weights, or run of ``train.py``.
        network: is changed in place.
        how: advice at the end of the error where there are no weights.

    Returns:
        SHA-256 of the file of weights.

    Raises:
        DataError: no weights there; truncated, altered or not safetensors; of another network.
    """
    folder = model_folder(path)
    if folder is None:
        missing = f"{path}: no trained weights there (no {CONFIG} and {WEIGHTS})"
        if (Path(path).expanduser() / CHECKPOINTS).is_dir():
            missing, how = f"{path}: its training has not ended", f"continue with `python train.py resume={path}`"
        raise DataError(f"{missing}; {how}" if how else missing)
    most = _check_config(folder / CONFIG, network)
    tensors, raw = read_fitting(folder / WEIGHTS, network.state_dict())
    network.load_state_dict(tensors)
    if getattr(network, "max_habits", None) is not None:
        network.max_habits = most  # type: ignore[attr-defined]
    return sha256_bytes(raw)


def _check_config(path: Path, network: Network) -> int:
    """Refuse weights of another architecture, format or arguments.

    Returns:
        Longest list of habits that the weights were trained with.
    """
    try:
        config = parse_json(read_verified(path, _MOST_CONFIG))
        found, number, arguments = config["architecture"], config["format"], config["arguments"]
        most = config.get("max_habits", MAX_HABITS)
    except (ValueError, LookupError, TypeError):
        raise DataError(f"{path}: does not describe a network; train it again") from None
    if not isinstance(arguments, dict) or type(most) is not int or not 1 <= most <= _MOST_HABITS:
        raise DataError(f"{path}: does not describe a network; train it again")
    if number != FORMAT:
        raise DataError(f"{path}: format {brief(number)}, this version reads {FORMAT}; train it again")
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
