"""Files of compressed JSON, one item per line; files listed in their folder's manifest are verified against it."""

from __future__ import annotations

import lzma
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from ucon.core.errors import DataError, EpisodeError
from ucon.core.files import canonical_json, listed_files, read_verified, write_atomic, write_manifest
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.strict_json import JsonError, parse_json
from ucon.core.untrusted.unpack import UnpackError, unpack_xz

_REMEDY = "restore it or make it again"


def read_lines(path: Path, what: str, most: int) -> Iterator[tuple[Any, str]]:
    """Yield the value of every line, with file and line number as text.

    Args:
        path: of the file.
        what: the items in words, for errors.
        most: largest allowed size when unpacked, bytes.

    Raises:
        DataError: the file cannot be read, is truncated or altered.
        EpisodeError: a line is not JSON, or the file has no lines.
    """
    try:
        raw = read_verified(path) if _in_manifest(path) else read_bounded(path, most)
        text = unpack_xz(raw, most).decode("utf-8-sig")
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); {_REMEDY}") from None
    except (UnpackError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: not a whole file of {what} ({error}); {_REMEDY}") from None
    if not text:
        raise EpisodeError(f"{path}: no {what} in it, expected one a line")
    for number, line in enumerate(text.removesuffix("\n").split("\n"), 1):
        where = f"{path}:{number}"
        try:
            data = parse_json(line)
        except JsonError as error:
            raise EpisodeError(f"{where}: {error}; {_REMEDY}") from None
        yield data, where


def write_lines(items: Iterable[Any], path: Path, suffix: str) -> None:
    """Write items, each by its ``to_json``, and update the folder's manifest; the same items give the same bytes.

    Args:
        items: the items, in order.
        path: of the file.
        suffix: ending of all such files in the folder.

    Raises:
        EpisodeError: the file's name does not end in the suffix.
    """
    check_name(path, suffix)
    text = "".join(canonical_json(item.to_json()) + "\n" for item in items)
    write_atomic(path, lzma.compress(text.encode(), preset=6))
    write_manifest(path.parent, [p.name for p in path.parent.glob(f"*{suffix}")])


def check_name(path: Path, suffix: str) -> None:
    """Raise :class:`EpisodeError` for a file name that does not end in a suffix."""
    if not path.name.endswith(suffix):
        raise EpisodeError(f"{path}: expected a name ending in {suffix}")


def _in_manifest(path: Path) -> bool:
    """Whether the file's folder has a manifest that lists it."""
    try:
        return path.name in listed_files(path.parent)
    except FileNotFoundError:
        return False
