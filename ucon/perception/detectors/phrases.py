"""From what a grounding model says back to catalogue names, and from names to prompts that fit its text window."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

_GAPS = re.compile(r"[^a-z0-9']+")


def plain(text: str) -> str:
    """Lower case, one space between words, no other signs: "T - Shirt." and ``t_shirt`` become "t shirt"."""
    return _GAPS.sub(" ", text.lower()).strip()


class Names:
    """Finds the name that a phrase means, and counts phrases that mean none."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = {plain(name): name for name in names}
        self._longest = max((key.count(" ") + 1 for key in self._names), default=0)
        self.unmatched = 0
        """Phrases so far that no name was found in."""

    def of(self, phrase: str) -> str | None:
        """The name that a phrase is, else the longest that it contains as whole words (the first of equals)."""
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
    """Split names, in their order, into prompts of at most ``window`` tokens; a dot after each name takes one."""
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
