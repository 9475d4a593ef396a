"""The result of one check, and the byte-exact comparison of observations and infos."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Finding:
    """The result of one check.

    Attributes:
        check: name of the check.
        ok: whether the promise is kept.
        expected: what the task promises.
        found: what the environment did.
    """

    check: str
    ok: bool
    expected: str
    found: str

    def line(self) -> str:
        """The result as one printed line."""
        return f"{'pass' if self.ok else 'FAIL'}  {self.check}: expected {self.expected}; found {self.found}"


def same(a: Any, b: Any) -> bool:
    """Whether two observations, infos or parts of them are equal; arrays must agree in dtype, shape and bytes.

    Objects of the same type that does not define equality count as equal.
    """
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, tuple | list):
        return isinstance(b, tuple | list) and len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if type(a) is not type(b):
        return isinstance(a, int | float | np.generic) and isinstance(b, int | float | np.generic) and bool(a == b)
    if is_dataclass(a) and not isinstance(a, type):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if hasattr(a, "rows") and hasattr(a, "texts"):  # the re-ranked habits of level ``context``
        return same(tuple(a.texts), tuple(b.texts))
    return type(a).__eq__ is object.__eq__ or bool(a == b)


def difference(a: Mapping[str, Any], b: Mapping[str, Any]) -> str:
    """Names of the keys in which two mappings differ, as text; "nothing" where they are equal."""
    names = sorted(name for name in {*a, *b} if name not in a or name not in b or not same(a[name], b[name]))
    return ", ".join(names) or "nothing"
