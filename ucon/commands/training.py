"""What ``train.py`` is asked to do: a new run, or one to go on with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ucon.core.errors import ConfigError
from ucon.core.files import canonical_json, sha256_bytes

if TYPE_CHECKING:
    from omegaconf import DictConfig

#: Options that say where and how a run is watched, not what is learned.
NEUTRAL_OPTIONS = ("out", "resume", "progress", "wandb")


@dataclass(frozen=True)
class ChosenRun:
    """A run's configuration and folder; ``checkpoint`` is what it goes on from, empty for a new run."""

    config: dict[str, Any]
    folder: Path
    checkpoint: str = ""


def chosen_run(cfg: DictConfig, overrides: Sequence[str], swept: Path | None) -> ChosenRun:
    """The new run that ``cfg`` describes, or the one in ``cfg.resume``: a run's folder or one of its checkpoints.

    Raises:
        ConfigError: nothing to resume there, or options beside ``resume`` that would make it another run.
    """
    from omegaconf import OmegaConf

    if not cfg.resume:
        if cfg.learner is None:
            raise ConfigError("learner has no value; give learner=retriever")
        config: Any = OmegaConf.to_container(cfg, resolve=True, throw_on_missing=True)
        return ChosenRun(config, swept or Path(config["out"]))
    odd = [word for word in overrides if word.split("=")[0].lstrip("+~") not in NEUTRAL_OPTIONS[1:]]
    if odd:
        raise ConfigError(f"resume={cfg.resume}: a run goes on with its own configuration; leave out {' '.join(odd)}")
    path = Path(cfg.resume).expanduser()
    folder, checkpoint = (path.parents[1], path.name) if path.name.startswith("step_") else (path, "latest")
    try:
        config = OmegaConf.to_container(OmegaConf.load(folder / "config.yaml"))
    except OSError:
        raise ConfigError(f"resume={cfg.resume}: no run there (no config.yaml); give the folder of a run") from None
    return ChosenRun({**config, "progress": cfg.progress, "wandb": cfg.wandb}, folder, checkpoint)


def run_identity(config: Mapping[str, Any]) -> dict[str, str]:
    """Hash of what is learned; the learner adds those of its data."""
    learned = {key: value for key, value in config.items() if key not in NEUTRAL_OPTIONS}
    return {"config": sha256_bytes(canonical_json(learned).encode())}


def use_threads(threads: int) -> None:
    """Let torch use ``threads`` threads. Sums depend on their number, so it is part of the configuration."""
    import torch

    torch.set_num_threads(threads)
