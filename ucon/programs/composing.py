"""Configurations of ``eval.py`` and ``train.py`` for commands that make their agents, environments and learners."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import ucon
from ucon.core.errors import ConfigError
from ucon.programs.errors import explain


def eval_config(*words: str) -> dict[str, Any]:
    """Configuration of ``eval.py`` with some options.

    Args:
        *words: as on its command line, such as ``agent=belief``.

    Raises:
        ConfigError: there is no folder ``configs``, or an option does not exist.
    """
    return _composed("eval", words)


def train_config(*words: str) -> dict[str, Any]:
    """Configuration of ``train.py`` with some options.

    Args:
        *words: as on its command line, such as ``learner=judge``.

    Raises:
        ConfigError: as :func:`eval_config`.
    """
    return _composed("train", words)


def _composed(program: str, words: Sequence[str]) -> dict[str, Any]:
    from hydra import compose, initialize_config_dir
    from hydra.errors import HydraException
    from omegaconf import OmegaConf

    configs = Path(ucon.__file__).parents[1] / "configs"
    if not configs.is_dir():
        raise ConfigError(f"{configs}: no such folder; agents are in a clone, not in the package: run this in one")
    try:
        with initialize_config_dir(str(configs), version_base="1.3"):
            config: dict[str, Any] = OmegaConf.to_container(compose(program, overrides=list(words)), resolve=True)  # type: ignore[assignment]
    except HydraException as error:
        raise ConfigError(explain(error, configs, program, words)) from None
    return config
