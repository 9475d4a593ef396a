"""Which texts can be shown on one line: no control character, nothing that turns or hides what stands beside it.

``str.isprintable`` also refuses what joins emoji and the letters of some scripts, and emoji that are younger than this
Python's tables. Those are no control characters where they stand between what they join; between Latin letters, where
they would hide a word from whoever looks for it, they stay refused.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Final

_JOINERS: Final = "\u200c\u200d"
#: What a joiner stands between: signs, marks on them, and letters of scripts without capitals.
_BEFORE: Final = frozenset(("So", "Sk", "Sm", "Po", "Lo", "Mn", "Mc"))
_AFTER: Final = frozenset(("So", "Sm", "Lo"))
_EMOJI: Final = range(0x1F000, 0x1FB00)
#: Flags of parts of countries: a black flag, letters that cannot be seen by themselves, and their end.
_FLAG: Final = re.compile("\U0001f3f4[\U000e0061-\U000e007a\U000e0030-\U000e0039]{1,10}\U000e007f")


def is_shown(text: str) -> bool:
    """Whether every character of a text can be shown on one line."""
    return text.isprintable() or shown(text) == text


def shown(text: str) -> str:
    """A text with a blank in place of each character that cannot be shown, a line break among them."""
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
