"""The judge of suspects that an agent is configured with, loaded when the first suspect is judged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, brief
from ucon.core.sharing import Shared

if TYPE_CHECKING:
    from models.nets.judge import TrainedJudge


class ConfiguredJudge(Shared):
    """A trained judge by name or folder; never loaded where the detector makes no errors."""

    def __init__(self, folder: str | None) -> None:
        """Name the judge.

        Args:
            folder: of a run of ``learner=judge``; None: the shipped judge.
        """
        self._folder = folder
        self._trained: TrainedJudge | None = None

    def check(self) -> None:
        """Raise a one-line error where the judge is missing or damaged.

        Raises:
            ConfigError: no such folder.
            DataError: no judge there.
        """
        self._load()

    def fingerprint(self) -> str:
        """Hash of the judge's files; see :mod:`ucon.evaluation.playing.needed_weights`."""
        return self._load().fingerprint()

    def __call__(self, evidence: NDArray[np.float32]) -> NDArray[np.float64]:
        """Probabilities (m,) of suspects by their evidence (m, F)."""
        return self._load()(evidence)

    def __getstate__(self) -> dict[str, Any]:
        """State for pickles: the name alone."""
        return {"_folder": self._folder, "_trained": None}

    def _load(self) -> TrainedJudge:
        if self._trained is None:
            from models.nets.judge import TrainedJudge

            if self._folder is not None and not Path(self._folder).expanduser().is_dir():
                raise ConfigError(f"agent.judge={self._folder}: no such folder; expected a run of learner=judge")
            self._trained = TrainedJudge.load(self._folder)
        return self._trained


def judge_of(name: str | None) -> ConfiguredJudge | None:
    """The judge that an option names.

    Args:
        name: ``shipped``; a folder; None: the arithmetic posterior alone, without a judge.

    Raises:
        ConfigError: another type.
    """
    if name is None:
        return None
    if not isinstance(name, str):
        raise ConfigError(f"agent.judge={brief(name)}: expected shipped, a folder, or null")
    return ConfiguredJudge(None if name == "shipped" else name)
