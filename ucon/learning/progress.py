"""What one sees of a training run: a progress bar; Weights & Biases or TensorBoard where they are asked for."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from ucon.core.errors import ConfigError, unknown_name
from ucon.learning.run import SCORE, OnFigures

WANDB_MODES: Final = ("offline", "online")
#: An online run without a network is given up after this long, and logged offline.
WANDB_PATIENCE_S: Final = 15


@contextmanager
def training_progress(label: str, steps: int, done: int = 0, *, visible: bool = True) -> Iterator[OnFigures]:
    """A bar on standard error with the last loss and validation score."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("loss {task.fields[loss]} val {task.fields[score]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), disable=not visible) as bar:
        task = bar.add_task(label, total=steps, completed=done, loss="-", score="-")

        def show(step: int, figures: Mapping[str, float]) -> None:
            fields = {"loss": figures.get("loss"), "score": figures.get(f"val/{SCORE}")}
            known = {name: f"{value:.3f}" for name, value in fields.items() if value is not None}
            bar.update(task, completed=step, **known)  # type: ignore[arg-type]

        yield show


@contextmanager
def wandb_log(mode: str | bool | None, folder: Path, config: Mapping[str, Any]) -> Iterator[OnFigures]:
    """Also log to Weights & Biases: false, ``offline`` (files in the run's folder) or ``online``.

    Nothing is sent and nothing imported unless asked for; ``online`` without a network falls back to ``offline``.
    """
    if not mode:
        yield lambda step, figures: None
        return
    if mode not in WANDB_MODES:
        raise ConfigError(unknown_name("wandb mode", str(mode), ("false", *WANDB_MODES)))
    run = _wandb_run(str(mode), folder, config)
    try:
        yield lambda step, figures: run.log(dict(figures), step=step)
    finally:
        run.finish()


def _wandb_run(mode: str, folder: Path, config: Mapping[str, Any]) -> Any:
    try:
        import wandb
    except ImportError:
        raise ConfigError(f"wandb={mode}: the package is not installed; `pip install wandb` or wandb=false") from None
    settings = wandb.Settings(init_timeout=WANDB_PATIENCE_S, silent=True)
    common = {"project": "ucon", "name": folder.name, "dir": str(folder), "config": dict(config), "settings": settings}
    try:
        return wandb.init(mode=mode, **common)  # type: ignore[arg-type]
    except (wandb.errors.Error, OSError) as error:
        print(f"warning: wandb={mode}: {error}; logging offline to {folder / 'wandb'}", file=sys.stderr)  # noqa: T201
        return wandb.init(mode="offline", **common)  # type: ignore[arg-type]


@contextmanager
def tensorboard_log(wanted: bool, folder: Path) -> Iterator[OnFigures]:
    """Also write for TensorBoard, to ``tensorboard/`` in the run's folder; nothing is imported unless asked for."""
    if not wanted:
        yield lambda step, figures: None
        return
    try:
        from torch.utils.tensorboard import SummaryWriter
    except ImportError:
        needed = "the package is not installed; `pip install tensorboard` or tensorboard=false"
        raise ConfigError(f"tensorboard=true: {needed}") from None
    with SummaryWriter(str(folder / "tensorboard")) as writer:  # type: ignore[no-untyped-call]

        def write(step: int, figures: Mapping[str, float]) -> None:
            for name, value in figures.items():
                writer.add_scalar(name, value, step)  # type: ignore[no-untyped-call]

        yield write
