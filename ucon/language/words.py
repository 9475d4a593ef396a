"""Words of texts: tokens, light stemming, stop words, and synonyms of categories."""

from __future__ import annotations

import json
import re
from functools import cache, lru_cache
from pathlib import Path
from typing import Final

STOP_WORDS: Final = frozenset((Path(__file__).parent / "data" / "stop_words.txt").read_text().split())
_WORD: Final = re.compile(r"[a-z]+")
_VOWELS: Final = frozenset("aeiouy")


def tokens(text: str) -> list[str]:
    """Lower-case words in order; an underscore separates, a possessive ending is dropped."""
    return _WORD.findall(text.lower().replace("'s", "").replace("’s", ""))


@lru_cache(maxsize=200_000)
def stem(word: str) -> str:
    """A light stem: removes plurals, -ing, -ed and a final e. Enough to map "shelves" to "shelf"."""
    if len(word) <= 3:
        return word
    irregular = _IRREGULAR.get(word)
    if irregular is not None:
        return irregular
    word = _singular(word)
    for ending in ("ing", "ed"):
        base = word[: -len(ending)]
        if word.endswith(ending) and len(base) >= 3 and _VOWELS & set(base):
            if base[-1] == base[-2] and base[-1] not in "lsz":
                base = base[:-1]
            word = base
            break
    if len(word) > 3 and word.endswith("e"):
        word = word[:-1]
    return word[:-1] + "i" if len(word) > 3 and word.endswith("y") else word


def _singular(word: str) -> str:
    if word.endswith("ies") and len(word) > 4:
        return word[:-3] + "y"
    if word.endswith("ves") and len(word) > 4:
        return word
    if word.endswith(("sses", "shes", "ches", "xes", "zes")):
        return word[:-2]
    if word.endswith("s") and not word.endswith(("ss", "us", "is")):
        return word[:-1]
    return word


_IRREGULAR: Final = {
    "shelves": "shelf",
    "knives": "knif",
    "loaves": "loaf",
    "halves": "half",
    "leaves": "leav",
    "leaf": "leav",
    "scarves": "scarf",
    "wives": "wif",
    "children": "child",
    "mice": "mous",
    "feet": "foot",
    "teeth": "tooth",
    "men": "man",
    "women": "woman",
    "hung": "hang",
    "kept": "keep",
    "slept": "sleep",
    "stood": "stand",
    "lay": "lie",
    "lain": "lie",
    "lying": "lie",
    "lies": "lie",
    "hidden": "hid",
    "hides": "hid",
    "washing": "wash",
}


@lru_cache(maxsize=60_000)
def stems(text: str) -> tuple[str, ...]:
    """Stems of all words, in order."""
    return tuple(stem(word) for word in tokens(text))


@lru_cache(maxsize=100_000)
def content_stems(text: str) -> tuple[str, ...]:
    """Stems of the words that carry meaning, in order."""
    return tuple(stem(word) for word in tokens(text) if word not in STOP_WORDS and len(word) > 1)


@cache
def synonyms() -> dict[str, tuple[str, ...]]:
    """Other names of each category: ``sofa`` -> couch, settee, ...; read once."""
    path = Path(__file__).parent / "data" / "synonyms.json"
    return {name: tuple(phrases) for name, phrases in json.loads(path.read_text()).items()}
