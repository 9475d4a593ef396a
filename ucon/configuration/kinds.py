"""Kinds of option values: each can test a value, and has a description for messages.

They are derived from annotations (``float | None``, ``Sequence[str]``, ``Literal["a", "b"]``) or composed here, with
bounds. A class that is not one of Python's own means a part: a mapping with ``_target_``.
"""

from __future__ import annotations

import ast
import math
import types
import typing
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

#: Upper bounds: of whole numbers, so that they fit into arrays, and of the length of names and texts.
_MOST: Final = 2**63
_LONGEST_NAME: Final = 255
_LONGEST: Final = 4096


@dataclass(frozen=True)
class Kind:
    """A kind of values."""

    expected: str
    """Description in messages, such as "a whole number from 1 up"."""
    takes: Callable[[Any], bool]


def whole(least: int = 1 - _MOST, most: int = _MOST - 1) -> Kind:
    """Whole numbers within bounds; bool does not count as one.

    Args:
        least: smallest.
        most: largest.
    """
    bounds = "" if least == 1 - _MOST else f" from {least} up" if most == _MOST - 1 else f" from {least} to {most}"
    return Kind(f"a whole number{bounds}", lambda value: type(value) is int and least <= value <= most)


def one_of(*values: Any) -> Kind:
    """One of the given texts or numbers, of the same type."""
    return Kind(" or ".join(map(str, values)), lambda value: any(value == v and type(value) is type(v) for v in values))


def either(kinds: Iterable[Kind]) -> Kind:
    """Values of any of several kinds."""
    several = tuple(kinds)
    descriptions = list(dict.fromkeys(kind.expected for kind in several))
    return Kind(" or ".join(descriptions), lambda value: any(kind.takes(value) for kind in several))


def _is_number(value: Any) -> bool:
    """Whether a value is a finite number below 2 ** 63."""
    return (type(value) is float and math.isfinite(value)) or (type(value) is int and abs(value) < _MOST)


def is_text(value: Any) -> bool:
    """Whether a value is a text of one line that could be a path.

    It has no control characters, at most 4,096 characters, and names of at most 255 bytes.
    """
    if type(value) is not str or len(value) > _LONGEST or any(unicodedata.category(letter) == "Cc" for letter in value):
        return False
    return all(len(name.encode("utf-8", "replace")) <= _LONGEST_NAME for name in value.split("/"))


def is_part(value: Any) -> bool:
    """Whether a value is a mapping with ``_target_``, which a configuration builds."""
    return isinstance(value, Mapping) and isinstance(value.get("_target_"), str)


def sequence(of: Kind, length: int | None = None) -> Kind:
    """Lists of values of one kind.

    Args:
        of: kind of the values.
        length: of the list; None: any.
    """
    counted = "a list" if length is None else f"a list of {length}"
    return Kind(
        f"{counted}, each {of.expected}",
        lambda value: isinstance(value, list | tuple) and length in (None, len(value)) and all(map(of.takes, value)),
    )


def mapping(of: Kind) -> Kind:
    """Mappings from names to values of one kind; no parts."""
    return Kind(
        f"names, each with {of.expected}",
        lambda value: (
            isinstance(value, Mapping)
            and "_target_" not in value
            and all(is_text(name) and of.takes(inner) for name, inner in value.items())
        ),
    )


SWITCH: Final = Kind("true or false", lambda value: type(value) is bool)
NUMBER: Final = Kind("a number", _is_number)
TEXT: Final = Kind(f"a text of one line, with file names of at most {_LONGEST_NAME} bytes", is_text)
PLACE: Final = Kind("the path of a folder", lambda value: is_text(value) and bool(value.strip()))
SECONDS: Final = Kind("seconds above 0", lambda value: _is_number(value) and value > 0)
NOTHING: Final = Kind("null", lambda value: value is None)
PART: Final = Kind("a part (_target_: ...)", is_part)
ANYTHING: Final = Kind("anything", lambda value: True)
_NAMED: Final = {
    "int": whole(),
    "float": NUMBER,
    "bool": SWITCH,
    "str": TEXT,
    "Path": TEXT,
    "None": NOTHING,
    "Any": ANYTHING,
    "dict": PART,
    "Callable": PART,
}


def kind_of(annotation: Any, names: Mapping[str, Any]) -> Kind | None:
    """The kind that an annotation describes; None where there is no annotation, or it cannot be interpreted.

    Args:
        annotation: a text, as with postponed evaluation, or an evaluated annotation.
        names: of its module, to resolve aliases such as ``Mode = Literal[...]``.
    """
    if not isinstance(annotation, str):
        return _of_object(annotation)
    try:
        return _of_node(ast.parse(annotation, mode="eval").body, names)
    except (SyntaxError, ValueError):
        return None


def _of_node(node: ast.expr, names: Mapping[str, Any]) -> Kind | None:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
        return _either([_of_node(side, names) for side in (node.left, node.right)])
    if isinstance(node, ast.Constant):
        return NOTHING if node.value is None else kind_of(node.value, names) if isinstance(node.value, str) else None
    if isinstance(node, ast.Subscript):
        inside = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        name = ast.unparse(node.value).rpartition(".")[2]
        if name == "Literal":
            return one_of(*(ast.literal_eval(item) for item in inside))
        endless = name == "tuple" and ast.unparse(inside[-1]) == "..."
        if endless:
            return _generic("Sequence", [_of_node(inside[0], names)])
        return _generic(name, [_of_node(item, names) for item in inside])
    if not isinstance(node, ast.Name | ast.Attribute):
        return None
    name = ast.unparse(node).rpartition(".")[2]
    if name in _NAMED:
        return _NAMED[name]
    meant = names.get(name)
    if typing.get_origin(meant) in (typing.Literal, typing.Union, types.UnionType):
        return _of_object(meant)
    return PART


def _generic(name: str, inside: Sequence[Kind | None]) -> Kind | None:
    if name in ("dict", "Callable", "type", "NDArray"):
        return PART
    if any(kind is None for kind in inside):
        return None
    kinds = [kind for kind in inside if kind is not None]
    if name in ("Sequence", "list", "Iterable"):
        return sequence(kinds[0])
    if name == "tuple":
        return sequence(kinds[0], len(kinds))
    if name == "Mapping":
        return mapping(kinds[1])
    return {"Optional": either([*kinds, NOTHING]), "Union": either(kinds)}.get(name, PART)


def _of_object(annotation: Any) -> Kind | None:
    """Kind of an evaluated annotation."""
    origin = typing.get_origin(annotation)
    if origin is typing.Literal:
        return one_of(*typing.get_args(annotation))
    if origin in (typing.Union, types.UnionType):
        return _either([_of_object(inner) for inner in typing.get_args(annotation)])
    if annotation in (None, type(None)):
        return NOTHING
    if isinstance(annotation, type) and origin is None:
        return None if annotation.__name__ == "_empty" else _NAMED.get(annotation.__name__, PART)
    return kind_of(str(annotation), {}) if origin is not None else None


def _either(kinds: Sequence[Kind | None]) -> Kind | None:
    return None if any(kind is None for kind in kinds) else either([kind for kind in kinds if kind is not None])
