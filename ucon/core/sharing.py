"""Who shares what with its copies, declared by the classes themselves.

Environments are cloned thousands of times by whoever plans ahead: a clone must own what changes in an episode, and no
more than that. Homes, habits, embeddings and episodes never change, so clones hold the same ones.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, ClassVar, TypeVar
from weakref import WeakKeyDictionary

K = TypeVar("K")
V = TypeVar("V")


class Shared:
    """What is never changed once it was made, or only remembers more: a copy of it is itself."""

    __slots__ = ()

    def __copy__(self) -> Any:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        return self


class PartlyShared:
    """A state whose deep copies share some attributes.

    ``_shared`` names those that are never written to, only replaced; ``_flat`` containers and arrays that are written
    to, of values that are not; ``_left_out`` those that a copy makes anew when it needs them, None until then. All
    others are copied in depth.
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
        """For pickles: without what is made anew."""
        return {name: None if name in self._left_out else value for name, value in self.__dict__.items()}


def is_the_one(made: Callable[[], Any], value: object) -> bool:
    """Whether ``value`` is what a cached function without arguments has made: pickles may name it then."""
    return bool(made.cache_info().currsize) and made() is value  # type: ignore[attr-defined]


class Remembered(WeakKeyDictionary[K, V]):
    """What was worked out for objects while they live; pickles leave it behind, copies begin with what is known."""

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), ()
