"""Which categories a sentence mentions: by full name, by a synonym, by its head noun, or by part of its words.

It starts with the catalogue's names and accepts further ones (a detector's labels).
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ucon.language.words import content_stems, stems, synonyms

#: Lexical features of a (sentence, name) pair, in order.
LEXICAL = ("phrase", "synonym", "head", "share")
_PHRASE, _SYNONYM, _HEAD, _SHARE = range(len(LEXICAL))

Matches = tuple[NDArray[np.int32], NDArray[np.float32]]
"""Ids (k,) of names that share a word with a sentence, and their features (k, 4)."""


class Lexicon:
    """Names with numbers, and the names that each sentence mentions (remembered by text).

    Attributes:
        ids: number of each name.
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        """Start with some names."""
        self.ids: dict[str, int] = {}
        self._first: dict[str, list[tuple[tuple[str, ...], int, int]]] = {}
        self._share: dict[str, list[tuple[int, float]]] = {}
        self._head: dict[str, list[int]] = {}
        self._matches: dict[str, Matches] = {}
        self.add(names)

    def __len__(self) -> int:
        return len(self.ids)

    def add(self, names: Iterable[str]) -> None:
        """Add names that are not known yet; remembered sentences are scanned again."""
        new = [name for name in dict.fromkeys(names) if name not in self.ids]
        if new:
            self._matches.clear()
        for name in new:
            number = self.ids[name] = len(self.ids)
            self._phrase(stems(name), number, _PHRASE)
            for synonym in synonyms().get(name, ()):
                self._phrase(stems(synonym), number, _SYNONYM)
            words = content_stems(name) or stems(name)
            for word in sorted(set(words)):
                self._share.setdefault(word, []).append((number, 1 / len(set(words))))
            if words:
                self._head.setdefault(words[-1], []).append(number)

    def _phrase(self, words: tuple[str, ...], number: int, kind: int) -> None:
        if words:
            self._first.setdefault(words[0], []).append((words, number, kind))

    def matches(self, text: str) -> Matches:
        """Names that share a word with a sentence.

        Returns:
            Their numbers (k,) int32 and features (k, 4) float32 in the order of :data:`LEXICAL`.
        """
        found = self._matches.get(text)
        if found is None:
            if len(self._matches) > 60_000:
                self._matches.clear()
            found = self._matches[text] = self._scan(text)
        return found

    def _scan(self, text: str) -> Matches:
        words = stems(text)
        values: dict[int, list[float]] = {}

        def of(number: int) -> list[float]:
            return values.setdefault(number, [0.0] * len(LEXICAL))

        for i, word in enumerate(words):
            for sequence, number, kind in self._first.get(word, ()):
                if words[i : i + len(sequence)] == sequence:
                    of(number)[kind] = 1.0
        for word in sorted(set(words)):
            for number, share in self._share.get(word, ()):
                of(number)[_SHARE] += share
            for number in self._head.get(word, ()):
                of(number)[_HEAD] = 1.0
        ids = np.fromiter(values, np.int32, len(values))
        return ids, np.asarray(list(values.values()), np.float32).reshape(-1, len(LEXICAL))


@cache
def catalogue_lexicon() -> Lexicon:
    """The process's lexicon, which starts with all names of the catalogue."""
    from ucon.objects.catalogue import catalogue

    return Lexicon(catalogue().names)
