"""Prompts for grounding models that fit a text window, and the mapping of their phrases back to catalogue names."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

_GAPS = re.compile(r"[^a-z0-9']+")


def plain(text: str) -> str:
    """Text in lower case with single spaces: "T - Shirt." and ``t_shirt`` become "t shirt".

    Characters other than letters, digits and apostrophes separate words.
    """
    return _GAPS.sub(" ", text.lower()).strip()


class Names:
    """Maps a model's phrases to the names of a vocabulary."""

    def __init__(self, names: Sequence[str]) -> None:
        """``names``: the vocabulary, as the catalogue writes it."""
        self._names = {plain(name): name for name in names}
        self._longest = max((key.count(" ") + 1 for key in self._names), default=0)
        self.unmatched = 0
        """Number of phrases so far that contained no name."""

    def of(self, phrase: str) -> str | None:
        """The name equal to a phrase, else the longest name that the phrase contains as whole words.

        Args:
            phrase: what the model reported, such as "coffee mug handle".

        Returns:
            A name of the vocabulary; None, counted in ``unmatched``, if there is none.
        """
        words = plain(phrase).split()
        for length in range(min(len(words), self._longest), 0, -1):
            spans = [" ".join(words[k : k + length]) for k in range(len(words) - length + 1)]
            found = [self._names[span] for span in spans if span in self._names]
            if found:
                # Longest by letters among those of equally many words.
                return max(found, key=len)
        self.unmatched += 1
        return None


def chunks(names: Sequence[str], tokens_of: Callable[[str], int], window: int) -> list[tuple[str, ...]]:
    """Split names, in their order, into groups that fit a text window.

    Args:
        names: the vocabulary.
        tokens_of: number of tokens of a text.
        window: most tokens of a group; the full stop after each name takes one.

    Returns:
        Groups of names, at least one name each.
    """
    parts: list[list[str]] = []
    used = window
    for name in names:
        cost = tokens_of(plain(name)) + 1
        if used + cost > window:
            parts.append([])
            used = 0
        parts[-1].append(name)
        used += cost
    return [tuple(part) for part in parts]
