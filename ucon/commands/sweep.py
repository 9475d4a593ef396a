"""Hydra callback for sweeps (``eval.py -m``)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hydra.experimental.callback import Callback
from omegaconf import DictConfig

from ucon.commands.compare import print_sweep


class CompareAtEnd(Callback):
    """Prints a table of all runs and their paired differences after a sweep."""

    def on_multirun_end(self, config: DictConfig, **kwargs: Any) -> None:
        """Print the tables of the sweep's folder. Called by Hydra.

        Args:
            config: of the sweep.
            kwargs: unused.
        """
        print_sweep(Path(config.hydra.sweep.dir))
