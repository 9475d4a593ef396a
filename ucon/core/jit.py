"""How kernels are compiled, where they are kept, and the array types they take.

Strict IEEE arithmetic (no fastmath) gives the same bits on every machine of one instruction set.

Numba keeps a compiled kernel as long as its own file stays as it is, though the kernels that it calls are compiled into
it, and the constants that it takes from other modules, may live in other files. So all of them are kept in a folder
named by the hash of all files that define kernels and of those that these import.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

from ucon.core.files import user_cache

_Function = TypeVar("_Function", bound=Callable[..., Any])

F64: TypeAlias = NDArray[np.float64]
F32: TypeAlias = NDArray[np.float32]
I32: TypeAlias = NDArray[np.int32]
I16: TypeAlias = NDArray[np.int16]
U32: TypeAlias = NDArray[np.uint32]
U16: TypeAlias = NDArray[np.uint16]
U8: TypeAlias = NDArray[np.uint8]
Flags: TypeAlias = NDArray[np.bool_]

_PACKAGE = Path(__file__).resolve().parents[1]
_MARK = b"ucon.core.jit import"
_IMPORT = re.compile(rb"^from ucon\.([\w.]+) import", re.MULTILINE)


def jit(function: _Function) -> _Function:
    """Compile once and keep on disk; releases the interpreter lock."""
    return _compiled(function)


def merged(function: _Function) -> _Function:
    """Like :func:`jit` for a few lines that are written into their callers before those are compiled."""
    return _compiled(function, inline="always")


def leaf(function: _Function) -> _Function:
    """Like :func:`jit` for a kernel that allocates nothing: it counts no references to the arrays it is given.

    Counting (atomically, for each array at each call and view) would cost more than drawing a small part.
    """
    return _compiled(function, _nrt=False, forceinline=False)


def inlined(function: _Function) -> _Function:
    """Like :func:`leaf` for what is called thousands of times a picture, from one place or two.

    Left to itself the compiler passes some twenty words for three arrays, which takes longer than to draw a small face.
    Elsewhere it would only lengthen compilation.
    """
    return _compiled(function, _nrt=False, forceinline=True)


def _compiled(function: _Function, **options: Any) -> _Function:
    config: Any = numba.config
    before = config.CACHE_DIR
    # Numba picks the folder while it decorates. A user's own choice (NUMBA_CACHE_DIR) goes first.
    config.CACHE_DIR = before or str(kernel_folder())
    try:
        return cast(_Function, numba.njit(cache=True, nogil=True, error_model="numpy", **options)(function))
    finally:
        config.CACHE_DIR = before


@lru_cache(maxsize=1)
def kernel_folder() -> Path:
    """Where compiled kernels are kept: beside the code, or in the user's cache where that is read-only."""
    name = f"kernels-{sources_hash(_PACKAGE)[:16]}"
    beside = _PACKAGE / "__pycache__"
    usable = os.access(beside if beside.is_dir() else _PACKAGE, os.W_OK)
    return (beside if usable else user_cache()) / name


def sources_hash(package: Path) -> str:
    """SHA-256 over the files of a package that define kernels, and those that they import, by name and content."""
    files = {path.relative_to(package).as_posix(): path.read_bytes() for path in package.rglob("*.py")}
    chosen = {name for name, content in files.items() if _MARK in content}
    for name in tuple(chosen):
        modules = (match.decode().replace(".", "/") for match in _IMPORT.findall(files[name]))
        chosen |= {f"{module}.py" for module in modules} & files.keys()
    digest = hashlib.sha256()
    for name in sorted(chosen):
        digest.update(f"{name} {len(files[name])}\n".encode() + files[name])
    return digest.hexdigest()
