"""Packed files never unpack beyond their limit, and arrays are made only if all their bytes are present."""

import bz2
import io
import lzma
import subprocess
import sys
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest

from ucon.core.untrusted.unpack import UnpackError, read_array, read_arrays, unpack_xz, unpack_zlib

WHOLE = b"some text, " * 1000


def npy(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def npz(**arrays: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


def claiming(shape: str, descr: str = "'<f4'", data: bytes = b"\0" * 64) -> bytes:
    """An .npy file whose header claims a shape."""
    header = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}}}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode() + data


@pytest.mark.parametrize("raw", [b"", WHOLE, b"x" * (3 << 20)])
def test_whole_data_come_back(raw: bytes) -> None:
    assert unpack_xz(lzma.compress(raw), len(raw)) == raw
    assert unpack_zlib(zlib.compress(raw), len(raw)) == raw
    assert unpack_xz(lzma.compress(raw) + b"\0" * 8 + lzma.compress(WHOLE), 1 << 30) == raw + WHOLE


@pytest.mark.parametrize(
    ("unpack", "packed"), [(unpack_xz, lzma.compress(WHOLE)), (unpack_zlib, zlib.compress(WHOLE))], ids=["xz", "zlib"]
)
def test_what_is_not_whole_or_too_large_is_refused(unpack, packed: bytes) -> None:
    for raw in (b"", packed[:-1], packed[:20], packed + b"more", b"\x00" + packed, WHOLE):
        with pytest.raises(UnpackError):
            unpack(raw, 1 << 20)
    with pytest.raises(UnpackError, match="more than 10,999 bytes"):
        unpack(packed, len(WHOLE) - 1)


BOMB = """
import lzma, resource, sys, zlib, zipfile, io
from ucon.core.untrusted.unpack import UnpackError, read_arrays, unpack_xz, unpack_zlib
piece = bytes(1 << 24)
xz = lzma.compress(piece, preset=0) * 128  # streams in a row, two gigabytes in all
stream = zlib.compressobj(1)
z = b"".join([stream.compress(piece) for _ in range(8)] + [stream.flush()])
held = io.BytesIO()
with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file, file.open("a.npy", "w") as entry:
    for _ in range(8):
        entry.write(piece)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for unpack, raw in ((unpack_xz, xz), (unpack_zlib, z), (read_arrays, held.getvalue())):
    try:
        unpack(raw, 1 << 24)
        sys.exit("taken")
    except UnpackError:
        pass
grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
print(len(xz), grown * (1 if sys.platform == "darwin" else 1024))
"""


def test_a_bomb_takes_little_memory() -> None:
    done = subprocess.run([sys.executable, "-c", BOMB], capture_output=True, text=True, check=True)
    size, grown = map(int, done.stdout.split())
    assert 100_000 < size < 500_000
    assert grown < 100 << 20


@pytest.mark.parametrize(
    "array",
    [
        *(np.arange(12, dtype=np.float16).reshape(3, 4), np.asfortranarray(np.eye(3)), np.zeros((0, 4)), np.array(7)),
        *(np.array([True, False]), np.array(["a", "bc"]), np.arange(6, dtype=">i4")),
    ],
)
def test_arrays_come_back(array: np.ndarray) -> None:
    for back in (read_array(npy(array)), read_arrays(npz(a=array, b=np.ones(2)), 1 << 20)["a"]):
        assert back.dtype == array.dtype
        assert back.shape == array.shape
        assert np.array_equal(back, array)
        assert back.flags.writeable


BAD_ARRAYS = {
    "a million million elements": claiming("(1000000, 1000000)"),
    "more elements than numbers have digits for": claiming(f"({'9' * 60}, {'9' * 60})"),
    "negative": claiming("(-4, -4)"),
    "no numbers": claiming("('a',)"),
    "objects": claiming("(8,)", "'|O'"),
    "elements of nothing": claiming("(1000000000000,)", "'|V0'", b""),
    "too few bytes": npy(np.ones(9))[:-1],
    "too many bytes": npy(np.ones(9)) + b"\0",
    "a header that is none": b"\x93NUMPY\x01\x00\x05\x00[[[[[",
    "a header that computes": claiming("(__import__('os').getpid(),)"),
    "no array": b"PK\x03\x04",
    "nothing": b"",
}


@pytest.mark.parametrize("raw", BAD_ARRAYS.values(), ids=BAD_ARRAYS)
def test_arrays_whose_bytes_are_not_there_are_refused(raw: bytes) -> None:
    with pytest.raises(UnpackError) as refused:
        read_array(raw)
    assert len(str(refused.value)) < 200
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as file:
        file.writestr("a.npy", raw)
    with pytest.raises(UnpackError):
        read_arrays(held.getvalue(), 1 << 30)


def test_damaged_archives_are_refused() -> None:
    packed = npz(a=np.arange(100), b=np.ones((4, 5)))
    for place in range(0, len(packed), 3):
        damaged = bytearray(packed)
        damaged[place] ^= 0x55
        try:
            found = read_arrays(bytes(damaged), 1 << 20)
        except UnpackError:
            continue
        assert np.array_equal(found[min(found)], np.arange(100)) or set(found) != {"a", "b"}  # a name, a date
    for raw in (b"", packed[:-30], packed[:100], b"x" * 500):
        with pytest.raises(UnpackError):
            read_arrays(raw, 1 << 20)
    with pytest.raises(UnpackError, match="more than 100 bytes"):
        read_arrays(packed, 100)


@pytest.mark.parametrize("how", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_archives_that_unpack_without_limit_are_refused(how: int) -> None:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", how) as file:
        file.writestr("a.npy", npy(np.ones(4)))
    with pytest.raises(UnpackError, match="no limit"):
        read_arrays(held.getvalue(), 1 << 20)


def test_other_compressions_are_no_xz() -> None:
    for raw in (bz2.compress(WHOLE), lzma.compress(WHOLE, lzma.FORMAT_ALONE)):
        with pytest.raises(UnpackError):
            unpack_xz(raw, 1 << 20)


def test_no_reader_unpacks_past_the_helper() -> None:
    """Data from others are unpacked in one place only; data that this process packed may be unpacked directly."""
    root = Path(__file__).resolve().parents[2]
    own = {"ucon/core/untrusted/unpack.py", "ucon/learning/imitation/feeding.py", "ucon/language/store.py"}
    words = (
        "lzma.decompress", "lzma.open", "LZMADecompressor", "zlib.decompress", "np.load(", "gzip.decompress",
        "gzip.open", "GzipFile", "bz2.",
    )  # fmt: skip
    found = {
        path.relative_to(root).as_posix()
        for folder in ("ucon", "models")
        for path in (root / folder).rglob("*.py")
        if any(word in path.read_text(encoding="utf-8") for word in words)
    }
    assert found - own <= {"ucon/evaluation/kept/record.py"}
