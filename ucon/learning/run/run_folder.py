"""The folder of a training run: the names of its files, and reading a folder that may come from somebody else.

Resuming a run reads, writes and deletes in its folder, so links out of it are refused.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError
from ucon.core.files import write_atomic
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.strict_json import JsonError, parse_json

CONFIG: Final = "config.yaml"
METRICS: Final = "metrics.jsonl"
CARD: Final = "MODEL_CARD.md"
SUMMARY: Final = "summary.json"
SECONDS: Final = "seconds.json"
MODEL: Final = "model"
CHECKPOINTS: Final = "checkpoints"
#: Records of an evaluation in the same folder; see :mod:`ucon.evaluation.kept.folder`.
RECORDS: Final = "episodes.jsonl"
#: Picture of the run.
CURVE: Final = "learning_curve.png"
#: Folders of the loggers.
_LOGS: Final = ("tensorboard", "wandb")
_FILES: Final = (CONFIG, METRICS, CURVE, CARD, SUMMARY, SECONDS)

#: Largest files that are read, in bytes: small ones, and the log of metrics.
_MOST_SMALL: Final = 16 << 20
_MOST_METRICS: Final = 4 << 30


def check_run_folder(folder: Path) -> None:
    """Refuse a run's folder with a link in it, or with a file where a folder belongs or vice versa.

    Args:
        folder: of the run; files that are missing are no error.

    Raises:
        DataError: naming the first such path.
    """
    for name in _FILES:
        _check(folder / name, file=True)
    for name in (MODEL, CHECKPOINTS, *_LOGS):
        _check(folder / name, file=False)
    for path in _inside(folder / MODEL):
        _check(path, file=True)
    for path in _inside(folder / CHECKPOINTS):
        of_step = path.name.startswith(("step_", ".step_"))  # the latter was left by a killed process
        _check(path, file=not of_step)
        for inner in _inside(path) if of_step else ():
            _check(inner, file=True)


def _inside(folder: Path) -> list[Path]:
    return sorted(folder.iterdir()) if folder.is_dir() else []


def _check(path: Path, *, file: bool) -> None:
    if path.is_symlink():
        raise DataError(f"{path}: is a link, which a run's folder must not hold; replace it with its target")
    if path.exists() and not (path.is_file() if file else path.is_dir()):
        raise DataError(f"{path}: expected a {'file' if file else 'folder'}; restore it, or start a new run")


def read_config(folder: Path) -> bytes:
    """Bytes of ``config.yaml``.

    Raises:
        FileNotFoundError: there is none.
        DataError: it is a link or a folder, or too large.
    """
    _check(folder / CONFIG, file=True)
    return read_plain(folder / CONFIG, _MOST_SMALL)


def read_metrics(folder: Path) -> list[dict[str, Any]]:
    """Lines of ``metrics.jsonl`` as mappings with ``step``; a last line that is being written is left out.

    Args:
        folder: of the run.

    Raises:
        DataError: naming a line that is no JSON with a step.
    """
    path = folder / METRICS
    text = read_plain(path, _MOST_METRICS).decode("utf-8", errors="replace")
    lines = text[: text.rfind("\n") + 1].split("\n")[:-1]
    return [_row_of(line, f"{path}:{number}") for number, line in enumerate(lines, 1)]


def read_text(path: Path) -> str:
    """Text of a small file of a run's folder.

    Raises:
        DataError: it is a link or a folder, or too large.
    """
    _check(path, file=True)
    return read_plain(path, _MOST_SMALL).decode("utf-8", errors="replace")


def read_seconds(folder: Path) -> float:
    """Seconds that earlier calls of the run took; 0 where ``seconds.json`` is missing or unreadable."""
    try:
        found: Any = parse_json(read_plain(folder / SECONDS, _MOST_SMALL))["seconds"]
    except (OSError, DataError, JsonError, LookupError, TypeError):
        return 0.0
    return float(found) if type(found) in (int, float) and found >= 0 else 0.0


def cut_metrics(folder: Path, step: int) -> None:
    """Drop the lines of ``metrics.jsonl`` after a step, and an incomplete last line.

    Args:
        folder: of the run.
        step: last step whose lines are kept.

    Raises:
        DataError: naming a line that is no JSON with a step.
    """
    path = folder / METRICS
    try:
        text = read_plain(path, _MOST_METRICS).decode("utf-8", errors="replace")
    except FileNotFoundError:
        text = ""
    kept = []
    for number, line in enumerate(text[: text.rfind("\n") + 1].split("\n")[:-1], 1):
        if _row_of(line, f"{path}:{number}")["step"] <= step:
            kept.append(line + "\n")
    write_atomic(path, "".join(kept))


def _row_of(line: str, where: str) -> dict[str, Any]:
    """Values of a line, ``step`` among them. Its figures are not checked: those of a diverged run may be NaN."""
    try:
        row = json.loads(line)
        step = row["step"]
    except (ValueError, LookupError, TypeError, RecursionError):
        row, step = {}, None
    if type(step) is not int or step < 0:
        raise DataError(f"{where}: not a line of metrics; restore it, or start a new run")
    return dict(row)
