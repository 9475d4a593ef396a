"""Hydra callback of sweeps (``eval.py -m``)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hydra.experimental.callback import Callback
from omegaconf import DictConfig

from ucon.commands.compare import print_sweep


class CompareAtEnd(Callback):
    """After a sweep, one table of all runs and the paired differences that answer its question."""

    def on_multirun_end(self, config: DictConfig, **kwargs: Any) -> None:
        """Print the tables of the sweep's folder."""
        print_sweep(Path(config.hydra.sweep.dir))
