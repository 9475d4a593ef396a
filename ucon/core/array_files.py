"""Arrays of others (``.npz``): what each says of itself is compared with what is there before room is made for it."""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from typing import IO, Any, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from ucon.core.errors import DataError

_SUFFIX: Final = ".npy"
#: Of all arrays of a file together, unpacked.
MOST_BYTES: Final = 1 << 30


def read_arrays(raw: bytes, most: int = MOST_BYTES) -> dict[str, NDArray[Any]]:
    """The arrays in the bytes of an ``.npz`` file, by name.

    Raises:
        DataError: it is none, is larger than ``most`` bytes when unpacked, or holds what is no plain array; without
            the name of the file.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            members = archive.infolist()
            if sum(member.file_size for member in members) > most:
                raise DataError(f"more than {most} bytes when unpacked")
            found = {}
            for member in members:
                with archive.open(member) as file:
                    found[member.filename.removesuffix(_SUFFIX)] = _array(file, member.file_size)
    except (zipfile.BadZipFile, zlib.error, ValueError, OSError, EOFError, NotImplementedError, RuntimeError) as error:
        raise DataError(f"no file of arrays ({str(error)[:80]})") from None
    return found


def _array(file: IO[bytes], size: int) -> NDArray[Any]:
    """One array of a member that has ``size`` bytes.

    Raises:
        DataError, ValueError: it is none, or not of the size that it says.
    """
    version = npy.read_magic(file)
    read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}.get(version)
    if read is None:
        raise DataError(f"an array in format {version}")
    shape, fortran, kind = read(file)
    data = file.read(size)
    if kind.hasobject or math.prod(shape) * kind.itemsize != len(data):
        raise DataError("an array that is not what it says")
    flat = np.frombuffer(data, kind)
    return (flat.reshape(shape[::-1]).T if fortran else flat.reshape(shape)).copy(order="F" if fortran else "C")
