"""Which texts can be displayed on one line: no control characters, nothing that reverses or hides its neighbours.

``str.isprintable`` also refuses the characters that join emoji and letters of some scripts, and emoji newer than this
Python's tables. Joiners are allowed between the characters they join. Between Latin letters, where they would hide a
word from a search, they are refused.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Final

_JOINERS: Final = "\u200c\u200d"
#: Unicode categories allowed before and after a joiner: signs, marks on them, letters of scripts without capitals.
_BEFORE: Final = frozenset(("So", "Sk", "Sm", "Po", "Lo", "Mn", "Mc"))
_AFTER: Final = frozenset(("So", "Sm", "Lo"))
_EMOJI: Final = range(0x1F000, 0x1FB00)
#: Flags of parts of countries: a black flag, invisible tag letters, and an end tag.
_FLAG: Final = re.compile("\U0001f3f4[\U000e0061-\U000e007a\U000e0030-\U000e0039]{1,10}\U000e007f")


def is_shown(text: str) -> bool:
    """Whether every character of a text can be displayed on one line."""
    return text.isprintable() or shown(text) == text


def shown(text: str) -> str:
    """The text with a space in place of each character that cannot be displayed, line breaks included."""
    if text.isprintable():
        return text
    flags = {i for match in _FLAG.finditer(text) for i in range(match.start() + 1, match.end())}
    return "".join(c if _can_be_shown(text, i) or i in flags else " " for i, c in enumerate(text))


def _can_be_shown(text: str, i: int) -> bool:
    character = text[i]
    if character not in _JOINERS:
        return character.isprintable() or ord(character) in _EMOJI
    return 0 < i < len(text) - 1 and _kind(text[i - 1]) in _BEFORE and _kind(text[i + 1]) in _AFTER


def _kind(character: str) -> str:
    return "So" if ord(character) in _EMOJI else unicodedata.category(character)
