"""Compilation of numba kernels, their cache on disk, and the array types they take.

Strict IEEE arithmetic (no fastmath) gives the same bits on every machine of one instruction set.

Numba recompiles a kernel only when its own file changes. But kernels that it calls, and constants of other modules, are
compiled into it and may be in other files. So the compiled kernels of a package are kept in a folder named by a hash
over all its files that define kernels and the files that these import. For packages other than ``ucon``, the hash also
covers that of ``ucon``.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
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


def jit(function: _Function) -> _Function:
    """Compile a kernel and keep it on disk; it releases the interpreter lock."""
    return _compiled(function)


def merged(function: _Function) -> _Function:
    """As :func:`jit`, for a few lines that are inlined into their callers before compilation."""
    return _compiled(function, inline="always")


def leaf(function: _Function) -> _Function:
    """As :func:`jit`, for a kernel that allocates nothing: it does not count references to its arrays.

    Counting (atomically, for each array at each call and view) would cost more than drawing a small part.
    """
    return _compiled(function, _nrt=False, forceinline=False)


def inlined(function: _Function) -> _Function:
    """As :func:`leaf`, for a kernel that is called thousands of times per image from one or two places.

    Otherwise the compiler passes some twenty words for three arrays, which takes longer than drawing a small face. With
    more callers, inlining would only lengthen compilation.
    """
    return _compiled(function, _nrt=False, forceinline=True)


def _compiled(function: _Function, **options: Any) -> _Function:
    config: Any = numba.config
    before = config.CACHE_DIR
    # Numba reads the folder while it decorates. The user's NUMBA_CACHE_DIR takes precedence.
    config.CACHE_DIR = before or str(kernel_folder(_package_of(function)))
    try:
        return cast(_Function, numba.njit(cache=True, nogil=True, error_model="numpy", **options)(function))
    finally:
        config.CACHE_DIR = before


def _package_of(function: Callable[..., Any]) -> Path:
    """Folder of the package that defines a function; this package's for a function in a script."""
    top = sys.modules.get(function.__module__.partition(".")[0])
    file = getattr(top, "__file__", None)
    return Path(file).resolve().parent if file and Path(file).name == "__init__.py" else _PACKAGE


@lru_cache
def kernel_folder(package: Path = _PACKAGE) -> Path:
    """Folder of a package's compiled kernels: in its ``__pycache__``, or in the user's cache if that is read-only."""
    own = sources_hash(package)
    digest = own if package == _PACKAGE else hashlib.sha256((own + sources_hash(_PACKAGE)).encode()).hexdigest()
    name = f"kernels-{digest[:16]}"
    beside = package / "__pycache__"
    usable = os.access(beside if beside.is_dir() else package, os.W_OK)
    return (beside if usable else user_cache()) / name


def sources_hash(package: Path) -> str:
    """SHA-256 over the files of a package that define kernels or that these import, by name and content."""
    imports = re.compile(rb"^from %s\.([\w.]+) import" % re.escape(package.name.encode()), re.MULTILINE)
    files = {path.relative_to(package).as_posix(): path.read_bytes() for path in package.rglob("*.py")}
    chosen = {name for name, content in files.items() if _MARK in content}
    for name in tuple(chosen):
        modules = (match.decode().replace(".", "/") for match in imports.findall(files[name]))
        chosen |= {f"{module}.py" for module in modules} & files.keys()
    digest = hashlib.sha256()
    for name in sorted(chosen):
        digest.update(f"{name} {len(files[name])}\n".encode() + files[name])
    return digest.hexdigest()
