"""Categories that an unknown word may stand for, by spelling and by meaning."""

from __future__ import annotations

import contextlib
import difflib
from typing import Final

import numpy as np

from ucon.core.errors import DataError, unknown_name
from ucon.language.phrases import phrase
from ucon.language.store import default_encoder
from ucon.objects.catalogue import catalogue

#: Least cosine of two names that are near in meaning.
_NEAR: Final = 0.45
#: Similarity of spelling (by difflib) from which a word counts as misspelt; its meaning is then not looked up.
_MISSPELT: Final = 0.83
#: Longest word that is encoded.
_LONGEST: Final = 60


def near_in_meaning(word: str, n: int = 3) -> tuple[str, ...]:
    """Categories of the catalogue whose names mean something like a word, nearest first.

    Args:
        word: a word that is no category.
        n: largest number of names.

    Returns:
        Names; () where none is near, or the sentence encoder is not installed.
    """
    names = catalogue().names
    with contextlib.suppress(DataError):
        known = default_encoder().encode([phrase(name) for name in names])
        (vector,) = default_encoder().encode([phrase(word)])
        cosine = known @ vector
        return tuple(names[k] for k in np.argsort(-cosine, kind="stable")[:n] if cosine[k] >= _NEAR)
    return ()


def unknown_category(kind: str, name: str) -> str:
    """The message for a name that is no category, with those near in spelling or in meaning.

    Args:
        kind: what the name should denote, such as ``object``.
        name: the unknown name.
    """
    names = catalogue().names
    misspelt = bool(difflib.get_close_matches(name, names, n=1, cutoff=_MISSPELT))
    meant = () if misspelt or not name.strip() or len(name) > _LONGEST else near_in_meaning(name)
    return unknown_name(kind, name, names, meant=meant)
