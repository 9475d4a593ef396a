"""The reader for JSON from untrusted sources: limited size, depth and numbers, and no duplicate keys.

Python's own reader accepts NaN, whole numbers of a thousand digits, duplicate keys, and lists nested until the
interpreter's stack overflows. This reader refuses them, for all callers.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError, brief
from ucon.core.untrusted.plain_file import read_bounded

#: Largest text by default, and deepest nesting.
MAX_BYTES: Final = 64 * 2**20
MAX_DEPTH: Final = 64
#: Largest whole number: those of 64 bits, as arrays hold them.
MAX_INT: Final = 2**63 - 1
_SURROGATE: Final = re.compile(r"\\u[dD][89a-fA-F]")


class JsonError(ValueError):
    """A JSON text that is refused.

    The message says why in a few words. ``at`` is the position: ``:3``, ``:3:14`` or "".
    """

    def __init__(self, message: str, at: str = "") -> None:
        super().__init__(message)
        self.at = at


def parse_json(
    text: str | bytes, *, max_bytes: int = MAX_BYTES, twice: list[str] | None = None, surrogates: bool = False
) -> Any:
    """The value of a JSON text.

    Args:
        text: one value, with nothing but white space around it; bytes are UTF-8, with or without a byte-order mark.
        max_bytes: largest size in bytes, or characters of a str.
        twice: duplicate keys are added to this list, and the last value counts; None refuses them.
        surrogates: whether texts may contain lone surrogates, which cannot be written to a file.

    Raises:
        JsonError: not JSON, too large, nested too deeply, or contains something that is refused.
    """
    if len(text) > max_bytes:
        raise JsonError(f"{len(text):,} bytes, expected at most {max_bytes:,}")
    try:
        plain = text.decode("utf-8-sig") if isinstance(text, bytes) else text
        value = json.loads(
            plain,
            parse_int=_whole,
            parse_float=_finite,
            parse_constant=_no_constant,
            object_pairs_hook=_object(twice),
        )
    except UnicodeDecodeError as error:
        raise JsonError(f"not UTF-8 ({error.reason})", f":{error.object.count(10, 0, error.start) + 1}") from None
    except json.JSONDecodeError as error:
        raise JsonError(f"not JSON ({error.msg})", f":{error.lineno}:{error.colno}") from None
    except RecursionError:
        raise JsonError(_TOO_DEEP) from None
    _require_shallow(plain, value)
    if not surrogates and _SURROGATE.search(plain):
        _require_whole_characters(value)
    return value


def read_json(path: Path, remedy: str, *, max_bytes: int = MAX_BYTES) -> Any:
    """The value of a JSON file.

    Args:
        path: the file.
        remedy: end of the error message.
        max_bytes: largest size.

    Raises:
        DataError: the file cannot be read, or :func:`parse_json` refuses it.
    """
    try:
        return parse_json(read_bounded(path, max_bytes), max_bytes=max_bytes)
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); {remedy}") from None
    except JsonError as error:
        raise DataError(f"{path}{error.at}: {error}; {remedy}") from None


def parse_first(text: str) -> tuple[Any, int]:
    """The JSON value at the start of a text, and its length; of duplicate keys the last value counts.

    Raises:
        JsonError: as :func:`parse_json`.
    """
    try:
        value, end = _FIRST.raw_decode(text)
    except json.JSONDecodeError as error:
        raise JsonError(f"not JSON ({error.msg})", f":{error.lineno}:{error.colno}") from None
    except RecursionError:
        raise JsonError(_TOO_DEEP) from None
    _require_shallow(text[:end], value)
    return value, end


_TOO_DEEP: Final = f"nested deeper than {MAX_DEPTH} levels"


def _whole(digits: str) -> int:
    if len(digits) > 20 or not -MAX_INT <= (number := int(digits)) <= MAX_INT:
        raise JsonError(f"the number {brief(digits)}, expected whole numbers of at most 63 bits")
    return number


def _finite(digits: str) -> float:
    if not math.isfinite(number := float(digits)):
        raise JsonError(f"the number {brief(digits)}, expected a finite one")
    return number


def _no_constant(name: str) -> Any:
    raise JsonError(f"{name}, expected finite numbers")


_FIRST: Final = json.JSONDecoder(parse_int=_whole, parse_float=_finite, parse_constant=_no_constant)


def _object(twice: list[str] | None) -> Callable[[list[tuple[str, Any]]], dict[str, Any]]:
    def made(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            names = [name for name, _ in pairs]
            again = sorted({name for name in names if names.count(name) > 1})
            if twice is None:
                raise JsonError(f"the key '{brief(again[0])}' occurs twice in one object")
            twice.extend(again)
        return found

    return made


def _require_shallow(text: str, value: Any) -> None:
    if text.count("[") + text.count("{") <= MAX_DEPTH:
        return
    level = [value]
    for _ in range(MAX_DEPTH):
        level = [child for node in level for child in _children(node) if type(child) in (dict, list)]
        if not level:
            return
    raise JsonError(_TOO_DEEP)


def _children(node: Any) -> Iterable[Any]:
    if type(node) is dict:
        return node.values()
    return node if type(node) is list else ()


def _require_whole_characters(value: Any) -> None:
    try:
        json.dumps(value, ensure_ascii=False).encode()
    except UnicodeEncodeError:
        raise JsonError("half a character (a lone surrogate), expected whole characters") from None
