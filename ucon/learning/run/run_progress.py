"""Progress of a training run on the terminal, and optional logs for Weights & Biases and TensorBoard."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import ConfigError, unknown_name
from ucon.core.progress import Progress
from ucon.learning.run.trainer_state import SCORE
from ucon.learning.run.training_run import OnFigures

WANDB_MODES: Final = ("offline", "online")
#: Seconds after which an online run without a network is logged offline instead.
WANDB_PATIENCE_S: Final = 15
#: Seconds that uploading may take after training; what is left stays in the run's folder.
WANDB_UPLOAD_S: Final = 120


@contextmanager
def training_progress(
    label: str, steps: int, done: int = 0, *, best: float | None = None, visible: bool = True
) -> Iterator[OnFigures]:
    """Context manager that shows a progress line with the last loss and validation score.

    Args:
        label: what the line begins with.
        steps: length of the run.
        done: steps done before, for a resumed run.
        best: its best validation score so far.
        visible: False shows nothing.

    Yields:
        A function of step and figures that updates the line.
    """
    last: dict[str, float | None] = {"loss": None, f"val/{SCORE}": best}

    def note() -> str:
        return f"loss {_shown(last['loss'])} val {_shown(last[f'val/{SCORE}'])}"

    with Progress(label, steps, unit="steps", done=done, note=note(), visible=visible) as progress:

        def show(step: int, figures: Mapping[str, float]) -> None:
            last.update((name, figures[name]) for name in last if name in figures)
            progress.update(step, note())

        yield show


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def check_wandb(mode: str | bool | None) -> None:
    """Refuse an unknown mode, and a mode without the package ``wandb``.

    Args:
        mode: ``offline``, ``online``, or false, None or "" for no log.

    Raises:
        ConfigError: naming what to give.
    """
    if not mode:
        return
    if mode not in WANDB_MODES:
        raise ConfigError(unknown_name("wandb mode", str(mode), ("false", *WANDB_MODES)))
    try:
        import wandb  # noqa: F401
    except ImportError:
        raise ConfigError(f"wandb={mode}: the package is not installed; `pip install wandb` or wandb=false") from None


@contextmanager
def wandb_log(mode: str | bool | None, folder: Path, config: Mapping[str, Any]) -> Iterator[OnFigures]:
    """Context manager that logs to Weights & Biases.

    Nothing is imported or sent unless asked for. ``online`` falls back to ``offline``, with one warning, where there is
    no network or nobody is logged in. It never asks for a key, so it cannot hang where nobody is there to answer.

    Args:
        mode: false or None for no log, ``offline`` (files in the run's folder) or ``online``.
        folder: of the run; its name is the name of the log.
        config: configuration, stored with the log.

    Yields:
        A function of step and figures that logs them.

    Raises:
        ConfigError: see :func:`check_wandb`.
    """
    check_wandb(mode)
    if not mode:
        yield lambda step, figures: None
        return
    run = _wandb_run(str(mode), folder, config)
    try:
        yield lambda step, figures: run.log(dict(figures), step=step)
    finally:
        _finish(run, folder)


def _wandb_run(mode: str, folder: Path, config: Mapping[str, Any]) -> Any:
    import wandb

    settings = wandb.Settings(
        init_timeout=WANDB_PATIENCE_S, finish_timeout=WANDB_UPLOAD_S, finish_timeout_raises=True, silent=True
    )
    common = {"project": "ucon", "name": folder.name, "dir": str(folder), "config": dict(config), "settings": settings}
    if mode == "online":
        try:
            # init() would ask at a terminal: its login_timeout leaves no log at all, and the first key cancels it.
            if wandb.login(prompt=False, verify=False):
                return wandb.init(mode="online", **common)  # type: ignore[arg-type]
            reason = "nobody is logged in (`wandb login`, or WANDB_API_KEY)"
        except (wandb.errors.Error, OSError) as error:
            reason = str(error).splitlines()[0]
        _warn(f"wandb=online: {reason}; logging offline to {folder / 'wandb'}, `wandb sync` sends it later")
    return wandb.init(mode="offline", **common)  # type: ignore[arg-type]


def _finish(run: Any, folder: Path) -> None:
    """End a log; warn where the upload takes too long."""
    try:
        run.finish()
    except TimeoutError:
        where = folder / "wandb"
        _warn(f"wandb=online: not everything was sent within {WANDB_UPLOAD_S} s; `wandb sync` sends what is in {where}")


def _warn(text: str) -> None:
    print(f"warning: {text}", file=sys.stderr)  # noqa: T201


@contextmanager
def tensorboard_log(wanted: bool, folder: Path) -> Iterator[OnFigures]:
    """Context manager that writes figures to ``tensorboard/`` in the run's folder; imports nothing unless asked for.

    Args:
        wanted: False for no log.
        folder: of the run.

    Yields:
        A function of step and figures that writes them.

    Raises:
        ConfigError: the package is not installed.
    """
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
