"""Training data that takes long to make: made in batches by worker processes, kept in the user's cache, found again.

A batch depends on its numbers alone, so the data is the same whatever the number of workers, and after an interruption
only the missing batches are made. The name of the folder is a hash of all that decides what the data means.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load

import ucon
from ucon.core.errors import DataError, brief
from ucon.core.files import write_atomic
from ucon.core.pool import Needs, open_pool
from ucon.core.progress import Progress


def kept_batches(
    folder: Path,
    count: int,
    size: int,
    what: str,
    workers: int,
    make: Callable[..., bytes],
    given: tuple[Any, ...],
    needs: Needs,
) -> list[Path]:
    """Files of the numbers from 0 to ``count`` - 1, in batches; those that are missing are made.

    Args:
        folder: of the files.
        count: how many numbers.
        size: of a batch.
        what: label of the progress line.
        workers: processes.
        make: from ``given`` and a range of numbers to the bytes of a file; a function that can be pickled.
        given: arguments.
        needs: what ``make`` loads by name.

    Returns:
        Paths, in the order of the numbers.
    """
    batches = [range(first, min(first + size, count)) for first in range(0, count, size)]
    files = [folder / f"{batch[0]:06d}-{len(batch)}.safetensors" for batch in batches]
    missing = [k for k, file in enumerate(files) if not file.is_file()]
    if missing:
        with Progress(what, sum(len(batches[k]) for k in missing)) as progress, open_pool(workers, needs=needs) as pool:
            asked, done = [(k, pool.submit(make, *given, batches[k])) for k in missing], 0
            for k, answer in asked:
                write_atomic(files[k], pool.result(answer))
                done += len(batches[k])
                progress.update(done)
    return files


def read_batch(path: Path, names: Sequence[str], what: str) -> dict[str, NDArray[Any]]:
    """Arrays of a file.

    Args:
        path: the file.
        names: of the arrays; none: all that it has.
        what: what it holds, for the error.

    Raises:
        DataError: the file is damaged.
    """
    try:
        found = load(path.read_bytes())
        return {name: found[name] for name in names or found}
    except (SafetensorError, KeyError) as error:
        raise DataError(f"{path}: no {what} ({brief(str(error))}); remove it, and they are made again") from None


@lru_cache(maxsize=8)
def code_hash(*parts: str) -> str:
    """Hash of source files and folders below ``ucon/``, such as ``search/suspects.py``."""
    root, found = Path(ucon.__file__).parent, hashlib.sha256()
    for part in parts:
        paths = sorted((root / part).rglob("*.py")) if (root / part).is_dir() else [root / part]
        for path in paths:
            found.update(path.read_bytes())
    return found.hexdigest()
