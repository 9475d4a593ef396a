"""An episode's text as arrays: embeddings of the target's name and of the habits that say most about its place."""

from __future__ import annotations

from functools import cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.language.phrases import phrase
from ucon.language.store import StoredEncoder, default_encoder
from ucon.objects.catalogue import catalogue
from ucon.perception.belief.target_belief import Locations, TargetBelief


class TextTokens(Shared):
    """Embeds names and habits."""

    def __init__(self, encoder: StoredEncoder | None = None, n_habits: int = 8) -> None:
        """Choose the encoder.

        Args:
            encoder: embeds sentences; the shipped one by default, loaded at first use.
            n_habits: P, rows for habits.
        """
        self._encoder, self.n_habits = encoder, n_habits

    @property
    def encoder(self) -> StoredEncoder:
        """The sentence encoder, loaded at first use."""
        if self._encoder is None:
            self._encoder = default_encoder()
        return self._encoder

    def read(self, name: str, locations: Locations) -> dict[str, NDArray[Any]]:
        """The arrays of an episode.

        Args:
            name: category of the target.
            locations: what was read from the habits, with their relevance.

        Returns:
            ``target`` (D,) and ``habits`` (P, D) float32 embeddings, ``habits_relevance`` (P,) float32 in [0, 1] and
            ``habits_mask`` (P,) int8. The most relevant habits come first; unused rows are zero.
        """
        target = self.encoder.encode_half([phrase(name)])[0].astype(np.float32)
        habits = np.zeros((self.n_habits, len(target)), np.float32)
        relevance, mask = np.zeros(self.n_habits, np.float32), np.zeros(self.n_habits, np.int8)
        texts, telling = locations.habits, locations.relevance
        if texts and telling is not None:
            top = np.argsort(-telling, kind="stable")[: self.n_habits]
            habits[: len(top)] = self.encoder.encode_half([texts[k] for k in top])
            relevance[: len(top)], mask[: len(top)] = telling[top], 1
        return {"target": target, "habits": habits, "habits_relevance": relevance, "habits_mask": mask}


class EpisodeTextTokens(PartlyShared):
    """The text arrays of one episode; read again when the list of habits changes (habit level ``context``)."""

    _shared: ClassVar[frozenset[str]] = frozenset({"_read"})

    def __init__(self, text: TextTokens, name: str, believing: TargetBelief) -> None:
        """Start an episode.

        Args:
            text: makes the arrays.
            name: category of the target.
            believing: the belief, whose ``locations`` hold the habits.
        """
        self._text, self._name, self._believing = text, name, believing
        self._read: tuple[Locations, dict[str, NDArray[Any]]] | None = None

    def __call__(self) -> dict[str, NDArray[Any]]:
        """The current arrays, see :meth:`TextTokens.read`. They are shared: do not write to them."""
        locations = self._believing.locations
        if self._read is None or self._read[0] is not locations:
            self._read = locations, self._text.read(self._name, locations)
        return self._read[1]


def name_table(encoder: StoredEncoder) -> NDArray[np.float32]:
    """Embeddings of the catalogue's n names, indexed by ``thing_rows``.

    Args:
        encoder: embeds sentences.

    Returns:
        (n + 1, D) float32; the last row, which -1 addresses, is zero.
    """
    names = encoder.encode_half([phrase(name) for name in category_rows()]).astype(np.float32)
    return np.vstack([names, np.zeros((1, names.shape[1]), np.float32)])


@cache
def category_rows() -> dict[str, int]:
    """Row of every category in the catalogue's order, the numbering of ``thing_rows``."""
    return {name: row for row, name in enumerate(catalogue().names)}
