"""The encoder that was fine-tuned for retrieval: shipped weights, or those of a training run."""

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
    """The adapted MiniLM behind the user's cache: one per process and adapter.

    Args:
        adapter: a run's folder or its ``model/retriever.safetensors``; None for the shipped one.

    Raises:
        DataError: no such file, or one that was altered.
    """
    return _encoder((ADAPTER if adapter is None else adapter_file(adapter)).resolve())


def adapter_file(name: str) -> Path:
    """The file of the adapter that ``name`` is, or that a run of that folder has left.

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
