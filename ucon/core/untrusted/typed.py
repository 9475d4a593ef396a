"""Reads JSON into dataclasses by their annotations: exactly the declared fields, each of its exact type.

Nothing is converted: ``true`` is not a number, ``1`` not a float, ``"no"`` not a boolean; NaN and infinity are refused.
"""

from __future__ import annotations

import math
import types
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from ucon.core.errors import DataError, brief
from ucon.core.untrusted.strict_json import JsonError, parse_json

T = TypeVar("T")
#: Largest whole number, the largest that floats hold exactly.
_LARGEST = 1 << 53
_ALTERED = "the file is altered, evaluate again"


def parse_line(raw: bytes | str, where: str, remedy: str = _ALTERED) -> Any:
    """The value of a JSON text, such as a line of records.

    Args:
        raw: see :func:`ucon.core.untrusted.strict_json.parse_json`.
        where: file and line, for errors.
        remedy: end of the error message.

    Raises:
        DataError: it is not JSON, or is refused.
    """
    try:
        return parse_json(raw)
    except JsonError as error:
        raise DataError(f"{where}: not JSON ({error}); {remedy}") from None


def read_as(cls: type[T], data: Any, where: str, what: str, *, without: tuple[str, ...] = (), remedy: str = "") -> T:
    """An instance of a dataclass from a JSON object with exactly its fields.

    Fields may be ``str``, ``bool``, ``int``, ``float``, such a dataclass, one of these or None, or a tuple of them.

    Args:
        cls: the dataclass.
        data: the JSON value.
        where: file and line, for errors.
        what: the class in words, for errors.
        without: fields that the object does not have.
        remedy: what to do about an object that is refused; by default, for records of runs, to evaluate again.

    Raises:
        DataError: naming a field that is missing, unknown, or of another type.
    """
    readers = _readers(cls)  # type: ignore[arg-type]  # mypy takes no class for hashable
    names = readers.keys() - set(without)
    if not isinstance(data, dict) or data.keys() != names:
        found = data.keys() if isinstance(data, dict) else set()
        missing, extra = sorted(names - found), sorted(map(brief, found - names))
        raise DataError(
            f"{where}: not {what} (missing {missing or 'nothing'}, unknown {extra[:5] or 'nothing'}); "
            f"{remedy or 'was it written by another version? evaluate again'}"
        )
    values = {}
    for name, value in data.items():
        try:
            values[name] = readers[name](value)
        except _WrongTypeError as error:
            raise DataError(f"{where}: {name}={brief(value)}: expected {error}; {remedy or _ALTERED}") from None
    return cls(**values)


class _WrongTypeError(Exception):
    """A value has the wrong type; the message says what was expected."""


@lru_cache
def _readers(cls: type[Any]) -> dict[str, Callable[[Any], Any]]:
    hints = get_type_hints(cls)
    return {field.name: _reader(hints[field.name]) for field in fields(cls)}


def _reader(kind: Any) -> Callable[[Any], Any]:
    """A function that returns values of ``kind`` unchanged and raises :class:`_WrongTypeError` for others."""
    if kind in _SIMPLE:
        return _SIMPLE[kind]
    inner = get_args(kind)
    if get_origin(kind) is tuple and inner[1:] == (...,):
        return _sequence(_reader(inner[0]))
    if is_dataclass(kind):
        return _nested(kind)
    if get_origin(kind) in (Union, types.UnionType) and len(inner) == 2 and type(None) in inner:
        return _or_none(_reader(next(one for one in inner if one is not type(None))))
    raise TypeError(f"no reader for {kind}")


def _sequence(read: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def inner(value: Any) -> Any:
        if type(value) is not list:
            raise _WrongTypeError("a list")
        return tuple(map(read, value))

    return inner


def _nested(kind: Any) -> Callable[[Any], Any]:
    def inner(value: Any) -> Any:
        try:
            return read_as(kind, value, kind.__name__, "one")
        except DataError:
            raise _WrongTypeError(f"an object with {', '.join(_readers(kind))}") from None

    return inner


def _or_none(read: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda value: None if value is None else read(value)


def _str(value: Any) -> str:
    if type(value) is not str or not (value.isascii() or _is_text(value)):
        raise _WrongTypeError("a text")
    return value


def _is_text(value: str) -> bool:
    """Whether it can be written: half a surrogate pair cannot."""
    try:
        value.encode()
    except UnicodeEncodeError:
        return False
    return True


def _bool(value: Any) -> bool:
    if type(value) is not bool:
        raise _WrongTypeError("true or false")
    return value


def _int(value: Any) -> int:
    if type(value) is not int or not -_LARGEST < value < _LARGEST:
        raise _WrongTypeError("a whole number of at most 15 digits")
    return value


def _float(value: Any) -> float:
    if type(value) is not float or not math.isfinite(value):
        raise _WrongTypeError("a finite number with a decimal point")
    return value


_SIMPLE: dict[Any, Callable[[Any], Any]] = {str: _str, bool: _bool, int: _int, float: _float}
