"""How kernels are compiled, and the array types they take.

Strict IEEE arithmetic (no fastmath) gives the same bits on every machine of one instruction set.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

_Function = TypeVar("_Function", bound=Callable[..., Any])

F64: TypeAlias = NDArray[np.float64]
F32: TypeAlias = NDArray[np.float32]
I32: TypeAlias = NDArray[np.int32]
I16: TypeAlias = NDArray[np.int16]
U32: TypeAlias = NDArray[np.uint32]
U8: TypeAlias = NDArray[np.uint8]


def jit(function: _Function) -> _Function:
    """Compile once and keep on disk; releases the interpreter lock."""
    compiled: Any = njit(cache=True, nogil=True, error_model="numpy")(function)
    return cast(_Function, compiled)


def leaf(function: _Function) -> _Function:
    """Like :func:`jit` for a kernel that allocates nothing: it counts no references to the arrays it is given.

    Counting (atomically, for each array at each call and view) would cost more than drawing a small part.
    """
    return _leaf(function, forceinline=False)


def inlined(function: _Function) -> _Function:
    """Like :func:`leaf` for what is called thousands of times a picture, from one place or two.

    Left to itself the compiler passes some twenty words for three arrays, which takes longer than to draw a small face.
    Elsewhere it would only lengthen compilation.
    """
    return _leaf(function, forceinline=True)


def _leaf(function: _Function, *, forceinline: bool) -> _Function:
    options: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}
    compiled: Any = njit(**options, forceinline=forceinline)(function)
    return cast(_Function, compiled)
