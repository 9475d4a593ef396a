"""Computes the shipped tables of vectors for the habit book and the catalogue: ``python -m ucon data text-tables``.

Rows of ``embeddings``: the book's habits by row number, each catalogue name, then the retrieval query of each of the
book's categories. The words of all these texts go to ``words.npz``. About ten minutes on one core; vectors in the cache
are not computed again.
"""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Sequence

import numpy as np

from ucon.core.files import write_atomic
from ucon.habits.book import book
from ucon.language.encoder import MiniLM
from ucon.language.pairs import content_words
from ucon.language.quantise import quantise
from ucon.language.store import DATA, StoredEncoder, write_manifest_of, write_table
from ucon.language.words import tokens
from ucon.objects.catalogue import catalogue

#: The paper's query; equal to ``ucon.retrieval.QUERY`` (a test compares them).
QUERY = "Please retrieve the habit about {target}."


def table_texts() -> list[str]:
    """Texts of the table, in order."""
    names = [name.replace("_", " ") for name in catalogue().names]
    targets = [name.replace("_", " ") for name in book().categories]
    return [*book().texts, *names, *(QUERY.format(target=name) for name in targets)]


def vocabulary() -> list[str]:
    """Words of the word table, sorted."""
    names = [name.replace("_", " ") for name in catalogue().names]
    words = {word for text in book().texts for word in content_words(text)}
    return sorted(words | {word for name in names for word in tokens(name)} | {"thing"})


def main(words: Sequence[str]) -> None:
    """Encode all texts and write the tables.

    Args:
        words: of the command line.
    """
    argparse.ArgumentParser(prog="ucon data text-tables").parse_args(words)
    encoder = StoredEncoder(MiniLM())
    texts, words = table_texts(), vocabulary()
    write_table(texts, encoder.encode_half(texts, _show), DATA / "embeddings")
    vectors = quantise(encoder.encode_half(words, _show))
    buffer = io.BytesIO()
    np.savez(
        buffer,
        words=np.frombuffer("\n".join(words).encode(), np.uint8),
        codes=vectors.codes,
        scale=vectors.scale,
    )
    write_atomic(DATA / "words.npz", buffer.getvalue())
    write_manifest_of(DATA)


def _show(done: int, total: int) -> None:
    end = "\n" if done == total else "\r"
    print(f"encoded {done} of {total} texts", end=end, file=sys.stderr, flush=True)  # noqa: T201
