"""What a policy over tokens reads of an episode's text: the target's name, and the habits that tell most about it."""

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
    """Embeds names and habits; what it has embedded the encoder remembers."""

    def __init__(self, encoder: StoredEncoder | None = None, n_habits: int = 8) -> None:
        """``n_habits``: rows for habits; those that tell most come first."""
        self._encoder, self.n_habits = encoder, n_habits

    @property
    def encoder(self) -> StoredEncoder:
        """By default the embedded one, loaded when it is first needed."""
        if self._encoder is None:
            self._encoder = default_encoder()
        return self._encoder

    def read(self, name: str, locations: Locations) -> dict[str, NDArray[Any]]:
        """Arrays of an episode, from the target's name and what was read of its habits.

        Returns:
            ``target`` (D,) and ``habits`` (P, D) float32 embeddings, ``habits_relevance`` (P,) float32 in [0, 1] and
            ``habits_mask`` (P,) int8.
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


class SaidTokens(PartlyShared):
    """The text arrays of one search, read again when the list of habits changes (level ``context``)."""

    _shared: ClassVar[frozenset[str]] = frozenset({"_read"})

    def __init__(self, text: TextTokens, name: str, believing: TargetBelief) -> None:
        """``name`` of the target, and who reads its habits."""
        self._text, self._name, self._believing = text, name, believing
        self._read: tuple[Locations, dict[str, NDArray[Any]]] | None = None

    def __call__(self) -> dict[str, NDArray[Any]]:
        """See :meth:`TextTokens.read`; not to be written to."""
        locations = self._believing.locations
        if self._read is None or self._read[0] is not locations:
            self._read = locations, self._text.read(self._name, locations)
        return self._read[1]


def name_table(encoder: StoredEncoder) -> NDArray[np.float32]:
    """(n + 1, D) embeddings of the catalogue's names, what ``thing_rows`` numbers; row -1, the last, is zero."""
    names = encoder.encode_half([phrase(name) for name in category_rows()]).astype(np.float32)
    return np.vstack([names, np.zeros((1, names.shape[1]), np.float32)])


@cache
def category_rows() -> dict[str, int]:
    """Row of every category of the catalogue, in its order: what ``thing_rows`` numbers."""
    return {name: row for row, name in enumerate(catalogue().names)}
