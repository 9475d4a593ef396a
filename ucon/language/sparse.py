"""Sparse vectors of texts (token ids and weights), and their storage in parts on disk."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ucon.core.files import sha256_bytes, write_atomic
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.unpack import read_arrays

#: Largest file of a part.
_MAX_BYTES = 256 * 2**20


@dataclass(frozen=True, eq=False)
class SparseRows:
    """n sparse vectors in flat arrays."""

    start: NDArray[np.int32]
    """(n + 1,) row i is ``start[i]:start[i + 1]`` of the other arrays."""
    ids: NDArray[np.int32]
    """(m,) token ids, ascending within a row."""
    weights: NDArray[np.float16]
    """(m,) weights above 0."""

    def __len__(self) -> int:
        return len(self.start) - 1

    @classmethod
    def stack(cls, rows: Sequence[tuple[NDArray[np.int32], NDArray[np.float16]]]) -> SparseRows:
        """Vectors from (ids, weights) of every row."""
        start = np.cumsum([0, *(len(ids) for ids, _ in rows)]).astype(np.int32)
        ids = np.concatenate([np.empty(0, np.int32), *(ids for ids, _ in rows)])
        return cls(start, ids, np.concatenate([np.empty(0, np.float16), *(weights for _, weights in rows)]))

    def row(self, i: int) -> tuple[NDArray[np.int32], NDArray[np.float16]]:
        """Ids (k,) and weights (k,) of one row."""
        part = slice(self.start[i], self.start[i + 1])
        return self.ids[part], self.weights[part]

    def dot(self, ids: NDArray[np.int32], weights: NDArray[np.float16]) -> NDArray[np.float64]:
        """Dot products with one sparse vector.

        Args:
            ids: (k,) token ids, ascending.
            weights: (k,).

        Returns:
            (n,) float64.
        """
        place = np.minimum(np.searchsorted(ids, self.ids), max(len(ids) - 1, 0))
        shared = (ids[place] == self.ids) if len(ids) else np.zeros(len(self.ids), bool)
        product = np.zeros(len(self.ids))
        product[shared] = self.weights[shared].astype(np.float64) * weights[place[shared]].astype(np.float64)
        total = np.concatenate([[0.0], np.cumsum(product)])
        return total[self.start[1:]] - total[self.start[:-1]]

    def save(self, path: Path) -> None:
        """Write a compressed file, 4 to 6 bytes a token, with checksums."""
        buffer = io.BytesIO()
        np.savez_compressed(buffer, start=self.start, ids=self.ids, weights=self.weights)
        write_atomic(path, buffer.getvalue())

    @classmethod
    def load(cls, path: Path, n: int) -> SparseRows | None:
        """Read a file.

        Args:
            path: the file.
            n: expected number of rows.

        Returns:
            None if the file is missing or damaged (with a warning).
        """
        try:
            file = read_arrays(read_bounded(path, _MAX_BYTES), _MAX_BYTES)
            found = cls(file["start"], file["ids"], file["weights"])
            if not found._is_whole(n):
                raise ValueError("rows")
            return found
        except FileNotFoundError:
            return None
        except (ValueError, KeyError, OSError):
            print(f"warning: {path} is damaged; its texts are encoded again", file=sys.stderr)  # noqa: T201
            return None

    def _is_whole(self, n: int) -> bool:
        """Whether the arrays hold exactly ``n`` consecutive rows."""
        types = (self.start.dtype, self.ids.dtype, self.weights.dtype) == (np.int32, np.int32, np.float16)
        if not types or self.start.shape != (n + 1,) or self.ids.ndim != 1 or self.ids.shape != self.weights.shape:
            return False
        ends = self.start[0] == 0 and self.start[-1] == len(self.ids)
        return bool(ends and (np.diff(self.start) >= 0).all() and np.isfinite(self.weights).all())


def joined(parts: Sequence[SparseRows]) -> SparseRows:
    """The rows of all parts, in order."""
    return SparseRows.stack([part.row(i) for part in parts for i in range(len(part))])


class SparseFolder:
    """Sparse vectors of long lists of texts, made and stored in parts, so that interrupted work is continued."""

    PART_TEXTS = 2000

    def __init__(self, folder: Path, make: Callable[[Sequence[str], int, int], SparseRows]) -> None:
        """Choose the folder.

        Args:
            folder: of the parts.
            make: maps some texts, the number of texts done before and the total number to the rows of these texts.
        """
        self._folder, self._make = folder, make

    def rows(self, texts: Sequence[str]) -> SparseRows:
        """Vectors of texts; missing parts are made and stored."""
        parts = []
        for begin in range(0, len(texts), self.PART_TEXTS):
            part = texts[begin : begin + self.PART_TEXTS]
            path = self._folder / f"{sha256_bytes(chr(10).join(part).encode())[:32]}.npz"
            found = SparseRows.load(path, len(part))
            if found is None:
                found = self._make(part, begin, len(texts))
                self._keep(found, path)
            parts.append(found)
        return joined(parts)

    @staticmethod
    def _keep(rows: SparseRows, path: Path) -> None:
        try:
            rows.save(path)
        except OSError as error:
            print(f"warning: {path} cannot be written ({error.strerror})", file=sys.stderr)  # noqa: T201
