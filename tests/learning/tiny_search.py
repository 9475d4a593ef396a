"""The environment in which a learner from decisions searches, as its configuration says."""

from __future__ import annotations

from pathlib import Path

from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from ucon.configuration.wiring import Factory

CONFIGS = Path(__file__).parents[2] / "configs"


def search_of(learner: str) -> Factory:
    """The factory of environments of ``learner=NAME``."""
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        config = compose("train", overrides=["agent=habit_policy", f"learner={learner}", "out=runs/test"])
    return Factory(OmegaConf.to_container(config.search, resolve=True))
