"""Copies a trained retriever into the package: ``python -m ucon data ship-retriever RUN``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from ucon.core.errors import DataError
from ucon.core.files import read_verified, write_atomic
from ucon.language.store import write_manifest_of
from ucon.retrieval.tuned import ADAPTER

CARD = "retriever.md"
MAX_BYTES = 5_000_000


def ship(run: Path) -> None:
    """Copy adapter and model card of a finished run into the package's data.

    Args:
        run: folder of the run.

    Raises:
        DataError: no finished run there, a file was altered, or the adapter is over 5 MB.
    """
    raw = read_verified(run / "model" / ADAPTER.name)
    card = run / "MODEL_CARD.md"
    if not card.is_file():
        raise DataError(f"{card}: missing; give the folder of a finished run")
    if len(raw) > MAX_BYTES:
        raise DataError(f"{run}: an adapter of {len(raw):,} bytes, expected at most {MAX_BYTES:,}; lower its rank")
    write_atomic(ADAPTER, raw)
    write_atomic(ADAPTER.parent / CARD, card.read_bytes())
    write_manifest_of(ADAPTER.parent)


def main(words: Sequence[str]) -> None:
    """Ship the run named on the command line.

    Args:
        words: of the command line.
    """
    parser = argparse.ArgumentParser(prog="ucon data ship-retriever")
    parser.add_argument("run", type=Path, help="folder of a finished run of learner=retriever")
    ship(parser.parse_args(words).run)
