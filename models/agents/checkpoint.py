"""Where an agent's network takes its weights from: a run of ``train.py``, what is shipped, or nobody trained it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from ucon.core.errors import ConfigError
from ucon.core.files import sha256_file
from ucon.learning.run.network_files import WEIGHTS, Network, load_network, model_folder

#: In place of a folder: play the weights that training would begin with.
UNTRAINED: Final = "untrained"
#: In place of a folder: the weights of this architecture that come with the code.
SHIPPED: Final = "shipped"
FOLDER: Final = Path(__file__).parents[2] / "checkpoints"


class NetworkCheckpoint:
    """Of one network.

    Args:
        network: whose weights.
        checkpoint: folder of them, or a run of ``train.py``; ``shipped``; ``untrained``; None: still to be trained.
    """

    def __init__(self, network: Network, checkpoint: str | None) -> None:
        self._network = network
        self.checkpoint = None if checkpoint is None else str(checkpoint)

    @property
    def untrained(self) -> bool:
        """Whether the network is to be played as it is."""
        return self.checkpoint == UNTRAINED

    @property
    def name(self) -> str:
        """The architecture, and whether nobody trained it."""
        return self._network.architecture + (f" ({UNTRAINED})" if self.untrained else "")

    def sha256(self) -> str | None:
        """Hash of the file of weights; "" where nobody trained them, None where there is none."""
        if self.untrained:
            return ""
        path = self._path
        folder = None if path is None else model_folder(path)
        return None if folder is None or not (folder / WEIGHTS).is_file() else sha256_file(folder / WEIGHTS)

    def load(self) -> None:
        """Give them to the network.

        Raises:
            ConfigError: none were named.
            DataError: there are none, they are damaged, or those of another network.
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
