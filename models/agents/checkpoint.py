"""Weights of an agent's network: from a run of ``train.py``, shipped with the code, or untrained."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from ucon.core.errors import ConfigError
from ucon.core.files import sha256_file
from ucon.learning.run.network_files import WEIGHTS, Network, load_network, model_folder

#: In place of a folder: play the network's initial weights.
UNTRAINED: Final = "untrained"
#: In place of a folder: the shipped weights of this architecture.
SHIPPED: Final = "shipped"
FOLDER: Final = Path(__file__).parents[2] / "checkpoints"


class NetworkCheckpoint:
    """Where the weights of one network come from.

    Args:
        network: that the weights belong to.
        checkpoint: folder of weights or run of ``train.py``; ``shipped``; ``untrained``; None: there are none yet.
    """

    def __init__(self, network: Network, checkpoint: str | None) -> None:
        self._network = network
        self.checkpoint = None if checkpoint is None else str(checkpoint)

    @property
    def untrained(self) -> bool:
        """Whether the network is played with its initial weights."""
        return self.checkpoint == UNTRAINED

    @property
    def name(self) -> str:
        """Name for tables: the architecture, with "(untrained)" where that applies."""
        return self._network.architecture + (f" ({UNTRAINED})" if self.untrained else "")

    def sha256(self) -> str | None:
        """SHA-256 of the file of weights; "" for an untrained network, None where there is no file."""
        if self.untrained:
            return ""
        path = self._path
        folder = None if path is None else model_folder(path)
        return None if folder is None or not (folder / WEIGHTS).is_file() else sha256_file(folder / WEIGHTS)

    def load(self) -> None:
        """Load the weights into the network; nothing to do for ``untrained``.

        Raises:
            ConfigError: no checkpoint was named.
            DataError: there are no weights, they are damaged, or those of another network.
        """
        if self.untrained:
            return
        how = f"train it with `python train.py agent={self._network.architecture}` and give agent.checkpoint=RUN"
        path = self._path
        if path is None:
            raise ConfigError(f"agent {self.name}: no trained weights; {how}, or agent.checkpoint={UNTRAINED}")
        load_network(path, self._network, how=how)

    @property
    def _path(self) -> str | None:
        return str(FOLDER / self._network.architecture) if self.checkpoint == SHIPPED else self.checkpoint
