"""Unpacking compressed files from untrusted sources, never beyond a given limit, whatever the file claims.

A few hundred kilobytes of xz or zlib can hold gigabytes, and the header of an array may claim any number of elements.
So data are unpacked piece by piece up to the limit, and arrays are created only if their bytes are present.
"""

from __future__ import annotations

import io
import lzma
import math
import zipfile
import zlib
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from ucon.core.errors import brief

#: Default limit for the arrays of one file.
MAX_BYTES: Final = 256 * 2**20
_PIECE: Final = 1 << 20
#: Memory limit of one xz stream; the highest preset needs 65 MB.
_XZ_MEMORY: Final = 128 * 2**20
_NPY_VERSIONS: Final = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


class UnpackError(ValueError):
    """Packed data that are incomplete or larger than allowed; the message says why, without naming the file."""


def unpack_xz(raw: bytes, max_bytes: int) -> bytes:
    """The content of one or several concatenated xz streams.

    Args:
        raw: the packed data.
        max_bytes: largest content.

    Raises:
        UnpackError: not xz, cut off, followed by something else, or larger than ``max_bytes``.
    """
    pieces: list[bytes] = []
    size, left = 0, raw
    try:
        while True:
            stream = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_XZ_MEMORY)
            for piece in _pieces(stream, left):
                pieces.append(piece)
                size = _within(size + len(piece), max_bytes)
            if not stream.eof:
                raise UnpackError("it ends too early")
            left = stream.unused_data.lstrip(b"\0")  # padding between streams
            if not left:
                return b"".join(pieces)
    except (lzma.LZMAError, EOFError) as error:
        raise UnpackError(f"not complete xz data: {error}") from None


def unpack_zlib(raw: bytes, max_bytes: int) -> bytes:
    """The content of zlib data.

    Args:
        raw: the packed data.
        max_bytes: largest content.

    Raises:
        UnpackError: not zlib, cut off, followed by something else, or larger than ``max_bytes``.
    """
    stream = zlib.decompressobj()
    try:
        found = stream.decompress(raw, max_bytes + 1)
        _within(len(found), max_bytes)
    except zlib.error as error:
        raise UnpackError(f"not complete zlib data: {error}") from None
    if not stream.eof:
        raise UnpackError("it ends too early")
    if stream.unused_data:
        raise UnpackError("there is more data after its end")
    return found


def read_arrays(raw: bytes, max_bytes: int) -> dict[str, NDArray]:
    """The arrays of an ``.npz`` file, by name; arrays of objects (pickles) are refused.

    Args:
        raw: bytes of the file.
        max_bytes: largest size of all arrays.

    Raises:
        UnpackError: not an ``.npz`` file, incomplete, or larger than ``max_bytes``.
    """
    found: dict[str, NDArray] = {}
    left = max_bytes
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as file:
            for entry in file.infolist():
                name = entry.filename.removesuffix(".npy")
                if name in found:
                    raise UnpackError("an array is there twice")
                if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                    raise UnpackError("packed in a way that has no limit")  # zipfile unpacks bzip2 and LZMA at once
                left -= _within(entry.file_size, left)
                with file.open(entry) as packed:
                    found[name] = read_array(packed.read(entry.file_size + 1))
    except UnpackError:
        raise
    except _ZIP_ERRORS as error:
        raise UnpackError(f"not a complete file of arrays: {error}") from None
    return found


#: Exceptions that ``zipfile`` raises for altered archives.
_ZIP_ERRORS: Final = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, OSError, ValueError, OverflowError),
    *(NotImplementedError, RuntimeError, LookupError, AttributeError, TypeError),
)


def read_array(raw: bytes) -> NDArray:
    """The array of an ``.npy`` file.

    Raises:
        UnpackError: not an array, an array of objects, or its header claims a size that the data do not have.
    """
    file = io.BytesIO(raw)
    try:
        header = _NPY_VERSIONS.get(npy.read_magic(file))
        if header is None:
            raise UnpackError("an array of an unknown format")
        shape, fortran, dtype = header(file)
        wanted = math.prod(shape) * dtype.itemsize
    except UnpackError:
        raise
    except Exception as error:  # numpy's reader of headers evaluates a text, and passes on whatever that raises
        raise UnpackError(f"not an array: {type(error).__name__} in its header") from None
    if dtype.hasobject or not dtype.itemsize:
        raise UnpackError("an array of objects or of nothing, which is never read")
    there = len(raw) - file.tell()
    if min(shape, default=0) < 0 or wanted != there:
        raise UnpackError(f"an array whose header claims {brief(wanted)} bytes, {there:,} are there")
    flat = np.frombuffer(raw, dtype, offset=file.tell()) if there else np.empty(0, dtype)
    return flat.reshape(shape, order="F" if fortran else "C").copy(order="K")


def _pieces(stream: lzma.LZMADecompressor, raw: bytes) -> Iterator[bytes]:
    piece = stream.decompress(raw, _PIECE)
    while piece:
        yield piece
        if stream.eof or stream.needs_input:
            return
        piece = stream.decompress(b"", _PIECE)


def _within(size: int, limit: int) -> int:
    if size > limit:
        raise UnpackError(f"it holds more than {limit:,} bytes, more than any such file")
    return size
