"""How kernels are compiled, and the array types they take.

Strict IEEE arithmetic (no fastmath) gives the same bits on every machine of one instruction set.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np
from numba import njit
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array
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


def _borrowed(_context: Any, array: Any) -> Any:
    """The same array without its reference count.

    Counting references (atomically, at each view and each call) would cost more than drawing a small part. The owner
    must outlive the borrower, which holds for the arguments and locals of a kernel that calls helpers.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = make_array(signature.args[0])(context, builder, arguments[0])
        view.meminfo = cgutils.get_null_value(view.meminfo.type)
        view.parent = cgutils.get_null_value(view.parent.type)
        return view._getvalue()

    return array(array), generate


borrowed: Any = intrinsic(_borrowed)
