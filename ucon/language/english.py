"""Detects whether habits are English: the shipped encoder and word tables know no other language.

It is a cheap rule for a warning only. A sentence looks English if most of its letters are ASCII and at least one word
in four is an English function word. About 1 in 100 habits of the book and 3 in 100 of the official release fail it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from ucon.language.words import STOP_WORDS

_ASCII_SHARE: Final = 0.7
_SMALL_WORDS: Final = 1 / 4
#: Largest number of sentences of a dataset that are tested, spread evenly over it.
_SAMPLE: Final = 400
_WORD: Final = re.compile(r"[^\W\d_]+")


def is_english(sentence: str) -> bool:
    """Whether a sentence looks English; one without letters does."""
    words = _WORD.findall(sentence.lower().replace("’s", "").replace("'s", ""))
    letters = "".join(words)
    if not letters:
        return True
    ascii_share = sum(letter.isascii() for letter in letters) / len(letters)
    small = sum(word in STOP_WORDS for word in words) / len(words)
    return ascii_share >= _ASCII_SHARE and small >= _SMALL_WORDS


def foreign_share(sentences: Sequence[str]) -> float:
    """Share of the sentences that do not look English, estimated from about 400 of them; 0 of none."""
    sample = sentences[:: max(1, len(sentences) // _SAMPLE)]
    return sum(not is_english(sentence) for sentence in sample) / len(sample) if sample else 0.0


def language_warning(name: str, sentences: Sequence[str]) -> str | None:
    """A warning about a dataset most of whose sentences do not look English.

    Args:
        name: of the dataset.
        sentences: its habits.

    Returns:
        One line, or None.
    """
    share = foreign_share(sentences)
    if share <= 0.5:
        return None
    return (
        f"warning: dataset '{name}': {share:.0%} of its sentences do not look English; the shipped encoder and readers "
        "know English only, so retrieval and search by habits will be poor (retriever=bge_m3 reads other languages)"
    )
