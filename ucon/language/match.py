"""Finds the one option of a closed set that a text names, whatever its case, punctuation and other words."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from ucon.language.servers.answers import json_object, without_thoughts

#: Texts with more characters do not count as answers.
_MOST_CHARACTERS: Final = 500
#: Numbers keep their sign: turning by -90 is not turning by 90.
_WORD: Final = re.compile(r"[+-]?\d+(?:\.\d+)?|\w+")

Words = tuple[str, ...]


def chosen(text: str, names: Sequence[str], key: str = "choice") -> int:
    """The one option that a model's answer names.

    The answer is a JSON object with the option under ``key``, or a short text; see :func:`named`.

    Args:
        text: the answer.
        names: of the options.
        key: of the option in JSON.

    Returns:
        Number of the option; -1 for none or several.
    """
    said, bare = json_object(text, (key,)), without_thoughts(text)
    if said is None and "{" in bare:
        return -1  # JSON that was cut off: "sofa" may be the beginning of "sofa bed"
    value = bare if said is None else said.get(key)
    if isinstance(value, bool) or not isinstance(value, str | int):
        return -1
    return named(str(value), names)


def named(text: str, names: Sequence[str]) -> int:
    """The one option that a short text names.

    The option may be written in other case, with other punctuation, among other words, or by some of its words if no
    other option has them.

    Args:
        text: at most 500 characters.
        names: of the options.

    Returns:
        Number of the option; -1 for none or several.
    """
    text = text.strip()
    if len(text) > max(_MOST_CHARACTERS, *map(len, names)):
        return -1
    if text in names:
        return _only([i for i, name in enumerate(names) if name == text])
    said, options = _words(text), [_words(name) for name in names]
    same = [i for i, option in enumerate(options) if option and option == said]
    return _only(same or _mentioned(said, options) or _parts(said, options))


def _mentioned(said: Words, options: Sequence[Words]) -> list[int]:
    """Options whose words occur in the text outside the name of a longer option: "sofa bed" is no "sofa"."""
    spans = [(start, start + len(option), i) for i, option in enumerate(options) for start in _places(option, said)]
    widest = [(a, b, i) for a, b, i in spans if not any(c <= a and b <= d and d - c > b - a for c, d, _ in spans)]
    return sorted({i for _, _, i in widest})


def _parts(said: Words, options: Sequence[Words]) -> list[int]:
    """Options whose words contain the text: "bed" for "sofa bed"."""
    return [i for i, option in enumerate(options) if said and _places(said, option)]


def _places(part: Words, whole: Words) -> list[int]:
    if not part:
        return []
    return [i for i in range(len(whole) - len(part) + 1) if whole[i : i + len(part)] == part]


def _words(text: str) -> Words:
    return tuple(_WORD.findall(text.casefold().replace("_", " ")))


def _only(found: Sequence[int]) -> int:
    return found[0] if len(found) == 1 else -1
