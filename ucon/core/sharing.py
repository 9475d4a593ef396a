"""Sharing between an object and its deep copies; classes declare what is shared.

Planners clone environments thousands of times. A clone must own what changes in an episode, and no more. Homes, habits,
embeddings and episodes never change, so clones share them.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, ClassVar, TypeVar
from weakref import WeakKeyDictionary

K = TypeVar("K")
V = TypeVar("V")


class Shared:
    """Base of objects that never change (or only cache more results): a copy is the object itself."""

    __slots__ = ()

    def __copy__(self) -> Any:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        return self


class PartlyShared:
    """Base of states whose deep copies share some attributes.

    ``_shared`` names attributes that are replaced but never written to; copies share them. ``_flat`` names containers
    and arrays that are written to but whose values are not; they are copied one level deep. ``_left_out`` names
    attributes that are None in a copy, which computes them again when needed. All others are copied deeply.
    """

    _shared: ClassVar[frozenset[str]] = frozenset()
    _flat: ClassVar[frozenset[str]] = frozenset()
    _left_out: ClassVar[frozenset[str]] = frozenset()

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        cls = type(self)
        memo[id(self)] = new = cls.__new__(cls)
        own = new.__dict__
        for name, value in self.__dict__.items():
            if name in cls._shared:
                own[name] = value
            elif name in cls._left_out:
                own[name] = None
            elif name in cls._flat and value is not None:
                own[name] = value.copy()
            else:
                own[name] = deepcopy(value, memo)
        return new

    def __getstate__(self) -> dict[str, Any]:
        """State for pickles, without the attributes that are computed again."""
        return {name: None if name in self._left_out else value for name, value in self.__dict__.items()}


def is_the_one(made: Callable[[], Any], value: object) -> bool:
    """Whether a value is the result of a cached function without arguments, so that pickles may name the function.

    Args:
        made: the cached function.
        value: the object.
    """
    return bool(made.cache_info().currsize) and made() is value  # type: ignore[attr-defined]


class Remembered(WeakKeyDictionary[K, V]):
    """A weak dictionary of values computed for live objects. Its pickles are empty."""

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), ()
