"""YAML that people write, read with the line of every value: plain data only, of limited size, in the core schema.

Aliases, anchors, tags, a second document, duplicate keys, control characters and numbers too large for arrays are
refused. An unquoted word that looks like a number, ``true``, ``false`` or ``null`` is read as one; everything else is
text, including ``yes`` and ``2026-01-01``. Nothing is constructed, so nothing in a text decides what code runs.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import yaml

from ucon.core.errors import DataError, brief
from ucon.core.text import is_shown
from ucon.core.untrusted.plain_file import read_bounded

#: Largest file in bytes, most values in it, and deepest nesting.
MOST_BYTES: Final = 1 << 18
MOST_VALUES: Final = 20_000
MOST_DEPTH: Final = 12
#: Longest text, characters.
MOST_LETTERS: Final = 4096

_WHOLE: Final = re.compile(r"[-+]?[0-9]+")
_DECIMAL: Final = re.compile(r"[-+]?(?:[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+)(?:[eE][-+]?[0-9]{1,3})?")
_WORDS: Final = {"true": True, "false": False, "null": None, "~": None, "": None}
_MOST_DIGITS: Final = 15


@dataclass(frozen=True)
class Marked:
    """A value and where it comes from.

    Attributes:
        value: a text, a number, True, False, None, a list of :class:`Marked`, or a dict of them by text.
        where: file and line, for messages.
        keys: for a dict, the ``where`` of each key.
    """

    value: Any
    where: str
    keys: Mapping[str, str]

    @property
    def told(self) -> str:
        """The value as messages show it."""
        if isinstance(self.value, dict):
            return "names with values"
        return "a list" if isinstance(self.value, list) else f"'{brief(self.value)}'"


def read_marked(path: Path) -> Marked:
    """Read a file.

    Args:
        path: the file.

    Raises:
        DataError: it cannot be read, or something in it is refused; names file and line.
    """
    try:
        raw = read_bounded(path, MOST_BYTES)
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); give the path of a YAML file") from None
    if len(raw) > MOST_BYTES:
        raise DataError(f"{path}: more than {MOST_BYTES:,} bytes; expected a short text")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        bad = raw.count(b"\n", 0, error.start) + 1
        raise DataError(f"{path}:{bad}: not UTF-8 ({error.reason}); save the file as UTF-8") from None
    return parse_marked(text, str(path))


def parse_marked(text: str, name: str) -> Marked:
    """Read a text.

    Args:
        text: one YAML document.
        name: of its file, for messages.

    Raises:
        DataError: something in it is refused; names file and line.
    """
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        return _Reader(yaml.parse(text, Loader=loader), name).document()
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = mark.line + 1 if mark else text.count("\n", 0, getattr(error, "position", 0)) + 1
        why = getattr(error, "problem", None) or getattr(error, "reason", None) or "it cannot be read"
        raise DataError(f"{name}:{line}: not YAML ({brief(str(why))}); fix this line or the one before") from None


def marked(value: Any, where: str) -> Marked:
    """Plain data of a program (dicts, lists, texts, numbers) as :class:`Marked`, under the same limits.

    Args:
        value: the data.
        where: what it is, such as ``home``; keys are added to it.

    Raises:
        DataError: too deep or too much, a key that is blank or not text, or an object of another kind.
    """
    return _of_data(value, where, 0, iter(range(MOST_VALUES)))


def _of_data(value: Any, where: str, depth: int, left: Iterator[int]) -> Marked:
    if depth > MOST_DEPTH or next(left, None) is None:
        raise DataError(f"{where}: nested too deeply or too long; expected a short description")
    if isinstance(value, Mapping):
        if odd := [key for key in value if not isinstance(key, str) or not key.strip() or not is_shown(key)]:
            raise DataError(f"{where}: key {brief(repr(odd[0]))}; expected texts of one line as keys")
        inner = {key: _of_data(one, f"{where}.{key}", depth + 1, left) for key, one in value.items()}
        return Marked(inner, where, {key: f"{where}.{key}" for key in inner})
    if isinstance(value, Sequence) and not isinstance(value, str | bytes | bytearray):
        return Marked([_of_data(one, f"{where}[{k}]", depth + 1, left) for k, one in enumerate(value)], where, {})
    if isinstance(value, str):
        return Marked(_checked_text(value, where), where, {})
    if value is None or type(value) in (bool, int, float):
        if type(value) is not bool and value is not None and not abs(value) < 10**_MOST_DIGITS:
            raise DataError(f"{where}: {brief(repr(value))}; expected a number of at most {_MOST_DIGITS} digits")
        return Marked(value, where, {})
    raise DataError(f"{where}: {brief(type(value).__name__)}; expected texts, numbers, lists and dicts")


class _Reader:
    """Turns the events of a document into marked values."""

    def __init__(self, events: Iterator[Any], name: str) -> None:
        self._events, self._name, self._left = events, name, MOST_VALUES

    def document(self) -> Marked:
        """The only document."""
        next(self._events)  # the stream's start
        event = next(self._events)
        if isinstance(event, yaml.StreamEndEvent):
            return Marked(None, f"{self._name}:1", {})
        found = self._value(next(self._events), 0)
        next(self._events)  # the document's end
        if not isinstance(event := next(self._events), yaml.StreamEndEvent):
            raise DataError(f"{self._where(event)}: a second document; expected one (no line '---' within it)")
        return found

    def _where(self, event: Any) -> str:
        return f"{self._name}:{event.start_mark.line + 1}"

    def _value(self, event: Any, depth: int) -> Marked:
        where, self._left = self._where(event), self._left - 1
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            raise DataError(f"{where}: aliases and anchors (* and &) are not read; write the value out, or quote it")
        if event.tag not in (None, "!"):
            raise DataError(f"{where}: tag {brief(event.tag)}; tags (!) are not read, write plain values")
        if depth > MOST_DEPTH or self._left < 0:
            raise DataError(f"{where}: nested too deeply or too long; expected a short description")
        if isinstance(event, yaml.ScalarEvent):
            text = _checked_text(event.value, where)
            return Marked(_plain(text, where) if event.implicit[0] else text, where, {})
        if isinstance(event, yaml.SequenceStartEvent):
            return Marked(list(self._items(depth)), where, {})
        return self._mapping(where, depth)

    def _items(self, depth: int) -> Iterator[Marked]:
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            yield self._value(event, depth + 1)

    def _mapping(self, where: str, depth: int) -> Marked:
        found: dict[str, Marked] = {}
        keys: dict[str, str] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            at = self._where(event)
            key = self._value(event, depth + 1).value if isinstance(event, yaml.ScalarEvent) else None
            if not isinstance(event, yaml.ScalarEvent) or not event.value.strip() or isinstance(key, bool):
                raise DataError(f"{at}: a key that is not text; expected name: value")
            if event.value in found:
                raise DataError(f"{at}: '{brief(event.value)}' is there twice (first at {keys[event.value]}); keep one")
            keys[event.value] = at
            found[event.value] = self._value(next(self._events), depth + 1)
        return Marked(found, where, keys)


def _checked_text(text: str, where: str) -> str:
    if len(text) > MOST_LETTERS:
        raise DataError(f"{where}: a text of {len(text):,} letters, expected at most {MOST_LETTERS:,}")
    if not is_shown(text):
        raise DataError(f"{where}: '{brief(text)}' has a control character or a line break; expected plain text")
    return text


def _plain(text: str, where: str) -> Any:
    """The value of a word without quotes."""
    if text.lower() in _WORDS:
        return _WORDS[text.lower()]
    if not _DECIMAL.fullmatch(text):
        return text
    number = int(text) if len(text) <= _MOST_DIGITS + 1 and _WHOLE.fullmatch(text) else float(text)
    if not abs(number) < 10**_MOST_DIGITS:
        raise DataError(f"{where}: {brief(text)}; expected a number of at most {_MOST_DIGITS} digits")
    return number
