"""Vectors by text: the shipped table, a cache on disk, and an encoder for the rest.

The table holds the habit book, the catalogue's names and the retrieval queries as fp16, so that the default data needs
no encoder. Other texts (a dataset given by path) are encoded once and kept in the user's cache folder.
"""

from __future__ import annotations

import hashlib
import io
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError, brief
from ucon.core.files import MANIFEST, read_verified, sha256_bytes, user_cache, write_atomic, write_manifest
from ucon.core.sharing import Shared, is_the_one
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.unpack import read_arrays
from ucon.language.encoder import MiniLM, TextEncoder, Vectors

DATA = Path(__file__).parent / "data"
KEY_BYTES = 16
SHARD_TEXTS = 2000
MAX_SHARDS = 32
REMEMBERED = 60_000
#: Largest file of the cache: half a million vectors.
_MAX_BYTES = 2**30


def text_key(text: str) -> bytes:
    """Key of a text: the first 16 bytes of its SHA-256."""
    return hashlib.sha256(text.encode()).digest()[:KEY_BYTES]


class VectorTable(Shared):
    """Read-only fp16 vectors, addressed by text.

    Attributes:
        vectors: (n, dim) float16.
    """

    def __init__(self, keys: bytes, vectors: NDArray[np.float16]) -> None:
        """Make a table.

        Args:
            keys: 16 bytes a row, see :func:`text_key`.
            vectors: (n, dim) float16.

        Raises:
            DataError: the numbers of keys and vectors differ.
        """
        if len(keys) != KEY_BYTES * len(vectors):
            raise DataError(f"embedding table: {len(keys) // KEY_BYTES} keys for {len(vectors)} vectors; rebuild it")
        self.vectors = np.asarray(vectors)  # a plain view: rows of a mapped array are slow to make
        self._row = {keys[i : i + KEY_BYTES]: i // KEY_BYTES for i in range(0, len(keys), KEY_BYTES)}

    def __len__(self) -> int:
        return len(self.vectors)

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickle the shipped table by name; it is checked wherever it is loaded."""
        return (shipped_table, ()) if is_the_one(shipped_table, self) else super().__reduce_ex__(protocol)

    def row(self, text: str) -> int:
        """Row of a text, -1 if it is not in the table."""
        return self._row.get(text_key(text), -1)

    def slice(self, texts: Sequence[str]) -> NDArray[np.float16] | None:
        """View (n, dim) of the consecutive rows of exactly these n texts; None if the table has no such rows."""
        first = self.row(texts[0]) if texts else -1
        if first < 0 or any(self.row(text) != first + i for i, text in enumerate(texts)):
            return None
        return self.vectors[first : first + len(texts)]

    @classmethod
    def load(cls, stem: Path) -> VectorTable:
        """Load ``stem.npy`` (memory-mapped) and ``stem.keys``, both checked against the manifest.

        Raises:
            DataError: a file is missing, altered, or no table.
        """
        keys = read_verified(stem.with_suffix(".keys"))
        read_verified(stem.with_suffix(".npy"))  # one pass over the file; the pages stay in the system's cache
        try:
            vectors = np.load(stem.with_suffix(".npy"), mmap_mode="r", allow_pickle=False)
        except (ValueError, OSError, EOFError) as error:
            raise DataError(f"{stem}.npy: not a table of vectors ({brief(str(error))}); restore it") from None
        return cls(keys, vectors)

    @staticmethod
    def save(stem: Path, texts: Sequence[str], vectors: NDArray[np.float16]) -> None:
        """Write ``stem.npy`` and ``stem.keys``; the caller writes the manifest.

        Args:
            stem: path without the endings.
            texts: n texts.
            vectors: (n, dim).
        """
        buffer = io.BytesIO()
        np.save(buffer, np.ascontiguousarray(vectors, np.float16), allow_pickle=False)
        write_atomic(stem.with_suffix(".npy"), buffer.getvalue())
        write_atomic(stem.with_suffix(".keys"), b"".join(map(text_key, texts)))


class TextCache:
    """Vectors of one encoder on disk. Files are named by their hash, so a damaged one is noticed and deleted.

    Processes may share a folder: each writes its own files under temporary names and renames them.
    """

    def __init__(self, folder: Path, dim: int) -> None:
        """Start with nothing in memory.

        Args:
            folder: of the files.
            dim: length of a vector.
        """
        self._folder, self._dim = folder, dim
        self._known: dict[bytes, NDArray[np.float16]] = {}
        self._read: set[str] = set()

    def get(self, key: bytes) -> NDArray[np.float16] | None:
        """Vector (dim,) of a key, if it is in memory; see :meth:`refresh`."""
        return self._known.get(key)

    def refresh(self) -> None:
        """Read the files that were not read yet."""
        for path in sorted(self._folder.glob("*.npz")) if self._folder.is_dir() else []:
            if path.name in self._read:
                continue
            self._read.add(path.name)
            try:
                raw = read_bounded(path, _MAX_BYTES)
                if sha256_bytes(raw)[:32] != path.stem:
                    raise ValueError("checksum")
                shard = read_arrays(raw, _MAX_BYTES)
                keys, vectors = shard["keys"].tobytes(), shard["vectors"]
                if vectors.dtype != np.float16 or vectors.shape != (len(keys) // KEY_BYTES, self._dim):
                    raise ValueError("vectors")
            except FileNotFoundError:  # another process merged it into a larger file
                continue
            except (ValueError, OSError, KeyError):
                print(f"warning: {path} is damaged; its texts are encoded again", file=sys.stderr)  # noqa: T201
                path.unlink(missing_ok=True)
                continue
            self._known.update((keys[i * KEY_BYTES : (i + 1) * KEY_BYTES], vector) for i, vector in enumerate(vectors))

    def add(self, keys: Sequence[bytes], vectors: NDArray[np.float16]) -> None:
        """Keep vectors in memory and, where the folder can be written, on disk.

        Args:
            keys: n keys, see :func:`text_key`.
            vectors: (n, dim) float16.
        """
        self._known.update(zip(keys, vectors, strict=True))
        try:
            self._write(keys, vectors)
            self._merge()
        except OSError as error:
            print(f"warning: text cache {self._folder} cannot be written ({error.strerror})", file=sys.stderr)  # noqa: T201

    def _write(self, keys: Sequence[bytes], vectors: NDArray[np.float16]) -> Path:
        buffer = io.BytesIO()
        packed = np.frombuffer(b"".join(keys), np.uint8).reshape(-1, KEY_BYTES)
        np.savez(buffer, keys=packed, vectors=np.asarray(vectors, np.float16))
        raw = buffer.getvalue()
        path = self._folder / f"{sha256_bytes(raw)[:32]}.npz"
        write_atomic(path, raw)
        self._read.add(path.name)
        return path

    def _merge(self) -> None:
        """One file instead of many: single texts must not fill the folder."""
        paths = sorted(self._folder.glob("*.npz"))
        if len(paths) <= MAX_SHARDS:
            return
        self.refresh()
        keys = sorted(self._known)
        merged = self._write(keys, np.stack([self._known[key] for key in keys]))
        for path in paths:
            if path != merged:
                path.unlink(missing_ok=True)


class StoredEncoder(Shared):
    """An encoder behind tables and a cache: each distinct text is encoded once."""

    def __init__(self, encoder: TextEncoder, *, tables: Sequence[VectorTable] = (), folder: Path | None = None) -> None:
        """Choose encoder and tables.

        Args:
            encoder: encodes texts that neither tables nor cache hold.
            tables: searched first.
            folder: of the cache; by default the user's cache folder.
        """
        self._encoder = encoder
        self._tables = tuple(tables)
        self._folder = folder
        self._forget()

    def _forget(self) -> None:
        self._cache = TextCache((self._folder or user_cache() / "text") / self._encoder.name, self._encoder.dim)
        self._refreshed = False
        self._place: dict[str, tuple[int, int, NDArray[np.float16] | None]] = {}

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickle the default encoder by name, and others without what they remember."""
        return (default_encoder, ()) if is_the_one(default_encoder, self) else super().__reduce_ex__(protocol)

    def __getstate__(self) -> dict[str, Any]:
        return {"_encoder": self._encoder, "_tables": self._tables, "_folder": self._folder}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._forget()

    @property
    def name(self) -> str:
        """Name of the encoder."""
        return self._encoder.name

    @property
    def dim(self) -> int:
        """Length of a vector."""
        return self._encoder.dim

    def missing(self, texts: Iterable[str]) -> list[str]:
        """The distinct texts that neither tables nor cache hold."""
        out: dict[str, None] = {}
        for text in texts:
            if all(table.row(text) < 0 for table in self._tables) and self._cached(text_key(text)) is None:
                out.setdefault(text)
        return list(out)

    def encode(self, texts: Sequence[str], progress: Callable[[int, int], None] | None = None) -> Vectors:
        """Encode texts; new ones are kept.

        Args:
            texts: n texts.
            progress: called with (texts done, texts in all).

        Returns:
            (n, dim) float32 whose values are exact in fp16.
        """
        return self.encode_half(texts, progress).astype(np.float32)

    def encode_half(
        self, texts: Sequence[str], progress: Callable[[int, int], None] | None = None
    ) -> NDArray[np.float16]:
        """As :meth:`encode`, in the stored type.

        Args:
            texts: n texts.
            progress: called with (texts done, texts in all).

        Returns:
            (n, dim) float16.
        """
        new = [text for text in texts if text not in self._place]
        if new:
            self._fill(self.missing(new), progress)
            if len(self._place) + len(new) > REMEMBERED:
                self._place.clear()
                new = list(texts)
            self._place.update((text, self._locate(text)) for text in new)
        places = [self._place[text] for text in texts]
        out = np.empty((len(texts), self.dim), np.float16)
        for number, table in enumerate(self._tables):
            rows = [(i, row) for i, (where, row, _) in enumerate(places) if where == number]
            if rows:
                index = np.asarray(rows)
                out[index[:, 0]] = table.vectors[index[:, 1]]
        for i, (where, _, vector) in enumerate(places):
            if where < 0:
                out[i] = vector
        return out

    def add(self, texts: Sequence[str], vectors: Vectors) -> None:
        """Keep vectors (n, dim) that this encoder computed elsewhere."""
        self._cache.add([text_key(text) for text in texts], vectors.astype(np.float16))

    def table_slice(self, texts: Sequence[str]) -> NDArray[np.float16] | None:
        """View (n, dim) of the table that holds exactly these texts in consecutive rows; None if none does."""
        for table in self._tables:
            if (view := table.slice(texts)) is not None:
                return view
        return None

    def _locate(self, text: str) -> tuple[int, int, NDArray[np.float16] | None]:
        """(table, row, None) of a text in a table, (-1, -1, vector) of a cached one."""
        for number, table in enumerate(self._tables):
            if (row := table.row(text)) >= 0:
                return number, row, None
        return -1, -1, self._cached(text_key(text))

    def _cached(self, key: bytes) -> NDArray[np.float16] | None:
        vector = self._cache.get(key)
        if vector is None and not self._refreshed:
            self._cache.refresh()
            self._refreshed = True
            vector = self._cache.get(key)
        return vector

    def _fill(self, texts: Sequence[str], progress: Callable[[int, int], None] | None) -> None:
        for start in range(0, len(texts), SHARD_TEXTS):
            part = texts[start : start + SHARD_TEXTS]
            vectors = np.concatenate(
                [self._encode_part(part[i : i + 50], start + i, len(texts), progress) for i in range(0, len(part), 50)]
            )
            self._cache.add([text_key(text) for text in part], vectors)

    def _encode_part(
        self, texts: Sequence[str], done: int, total: int, progress: Callable[[int, int], None] | None
    ) -> NDArray[np.float16]:
        vectors = self._encoder.encode(texts).astype(np.float16)
        if progress is not None:
            progress(done + len(texts), total)
        return vectors


@cache
def shipped_table() -> VectorTable:
    """The shipped table: the habit book, the catalogue's names and the retrieval queries; loaded once."""
    return VectorTable.load(DATA / "embeddings")


@cache
def default_encoder() -> StoredEncoder:
    """The process's encoder: MiniLM behind the shipped table and the user's cache."""
    tables = (shipped_table(),) if (DATA / "embeddings.npy").is_file() else ()
    return StoredEncoder(MiniLM(), tables=tables)


def write_table(texts: Sequence[str], vectors: NDArray[np.float16], stem: Path) -> None:
    """Write a table; then call :func:`write_manifest_of` for its folder."""
    VectorTable.save(stem, texts, vectors)


def write_manifest_of(folder: Path) -> None:
    """Write a folder's manifest, which lists every data file in it."""
    write_manifest(folder, [path.name for path in folder.iterdir() if path.name != MANIFEST and path.is_file()])
