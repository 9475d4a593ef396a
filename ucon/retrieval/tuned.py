"""The sentence encoder fine-tuned for retrieval: with the shipped adapter, or with that of a training run."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Final

from ucon.core.errors import DataError
from ucon.language.adapted import AdaptedMiniLM
from ucon.language.store import StoredEncoder

#: Made by ``python train.py learner=retriever``: the run's ``model/retriever.safetensors``.
ADAPTER: Final = Path(__file__).parent / "data" / "retriever.safetensors"


def tuned_encoder(adapter: str | None = None) -> StoredEncoder:
    """MiniLM with an adapter, its vectors cached on disk; one per process and adapter.

    Args:
        adapter: a run's folder, or its ``model/retriever.safetensors``; None: the shipped one.

    Raises:
        DataError: no such file, or one that was altered.
    """
    return _encoder((ADAPTER if adapter is None else adapter_file(adapter)).resolve())


def adapter_file(name: str) -> Path:
    """Path of an adapter.

    Args:
        name: the file itself, or a run's folder.

    Raises:
        DataError: there is none.
    """
    path = Path(name).expanduser()
    if path.is_dir():
        folder = path / "model" if (path / "model").is_dir() else path
        path = folder / ADAPTER.name
    if not path.is_file():
        raise DataError(f"{path}: no adapter there; give a run of `train.py learner=retriever`, or none at all")
    return path


@cache
def _encoder(path: Path) -> StoredEncoder:
    return StoredEncoder(AdaptedMiniLM(path))
