"""Files in the folder of a finished run, and the checksums that reveal an altered bit.

``summary.json`` has the SHA-256 of records and decisions (which equal runs share), ``seconds.json`` those of timing and
configuration (which differ). Each ends with a checksum of itself. Checksums of packed records (``.xz``) are of the
unpacked bytes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from json import dumps
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError, brief
from ucon.core.files import sha256_bytes
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.typed import parse_line
from ucon.core.untrusted.unpack import UnpackError, unpack_xz

RECORDS, DECISIONS, SUMMARY = "episodes.jsonl", "decisions.jsonl", "summary.json"
#: Records of a run that is not finished.
PARTIAL: Final = f"{RECORDS}.partial"
TIMING, CONFIG, SECONDS = "timing.jsonl", "config.yaml", "seconds.json"
#: Files whose checksums are in ``summary.json`` and in ``seconds.json``.
SEALED: Final[Mapping[str, tuple[str, ...]]] = {SUMMARY: (RECORDS, DECISIONS), SECONDS: (TIMING, CONFIG)}
#: Largest file in bytes, unpacked: some hundred thousand episodes, or the decisions of some thirty thousand.
_MAX_BYTES = 1 << 28
_SEAL = ',\n "checksum": "'
_RESTORE = "restore it or evaluate again"
_NO_SUMMARY = "no summary of a finished run of eval.py"


@dataclass(frozen=True)
class RunFiles:
    """The files of a finished run, with verified checksums."""

    folder: Path
    summary: dict[str, Any]
    seconds: dict[str, Any]
    content: dict[str, bytes]
    """Bytes by name; missing files are left out."""


def sealed(content: Mapping[str, Any], files: Mapping[str, bytes]) -> str:
    """Text of a JSON file with ``content``, checksums of ``files`` by name, and a checksum of itself."""
    digests = {name: sha256_bytes(data) for name, data in sorted(files.items())}
    body = dumps({**content, "files": digests}, indent=1, allow_nan=False).removesuffix("\n}")
    return f'{body}{_SEAL}{sha256_bytes(body.encode())}"\n}}\n'


def has_summary(folder: Path) -> bool:
    """Whether there is a ``summary.json``, which marks a finished run."""
    return (folder / SUMMARY).is_file()


def read_files(folder: Path, *, whole: bool = True) -> RunFiles:
    """Read everything in the folder of a finished run and verify its checksums.

    Args:
        folder: of the run.
        whole: False: missing files are no error.

    Raises:
        DataError: a file is missing, altered, or has no checksum; names it and says what to do.
    """
    said = {name: _unsealed(folder / name) for name in SEALED if whole or (folder / name).is_file()}
    content = {}
    for name, parts in SEALED.items():
        digests = said.setdefault(name, {}).pop("files", None)
        for part in parts:
            data = read_file(folder, part)
            if data is not None:
                content[part] = data
            elif not whole:
                continue
            if digests is not None:
                _compare(folder, name, part, None if data is None else sha256_bytes(data), digests.get(part))
    return RunFiles(folder, said[SUMMARY], said[SECONDS], content)


def read_unsealed(folder: Path) -> RunFiles:
    """Read everything in the folder of a run that an older version finished; its summary has the seconds too.

    Args:
        folder: of the run.

    Raises:
        DataError: no summary of a run there.
    """
    said = read_object(folder / SUMMARY)
    seconds = {name: said.pop(name, None) for name in ("seconds", "episode_seconds", "language_seconds")}
    language = said.get("language")
    per_decision = language.pop("seconds_per_decision", None) if isinstance(language, dict) else None
    seconds["seconds_per_decision"] = per_decision
    there = {part: read_file(folder, part) for parts in SEALED.values() for part in parts}
    return RunFiles(folder, said, seconds, {name: data for name, data in there.items() if data is not None})


def read_file(folder: Path, name: str) -> bytes | None:
    """Bytes of a file, unpacked where only ``.xz`` is there; None where neither is."""
    for path in (folder / name, folder / f"{name}.xz"):
        if path.is_file():
            return read_bytes(path)
    return None


def read_bytes(path: Path) -> bytes:
    """Bytes of a file, unpacked where its name ends in ``.xz``.

    Raises:
        DataError: it is truncated, or larger than any run.
    """
    raw = read_plain(path, _MAX_BYTES)
    if path.suffix != ".xz":
        return raw
    try:
        return unpack_xz(raw, _MAX_BYTES)
    except UnpackError as error:
        raise DataError(f"{path}: incomplete ({error}); {_RESTORE}") from None


def refuse_unfinished(folder: Path) -> None:
    """Raise :class:`DataError` where a folder holds a run of ``eval.py`` that is not finished."""
    if (folder / PARTIAL).is_file():
        done = max(0, read_plain(folder / PARTIAL, _MAX_BYTES).count(b"\n") - 1)
        raise DataError(
            f"{folder}: not finished, {done} episodes so far; the same command with out={folder} continues it"
        )


def read_object(path: Path) -> dict[str, Any]:
    """The JSON object in a file, with or without a checksum.

    Raises:
        DataError: there is no file, or no object in it.
    """
    if not path.is_file():
        refuse_unfinished(path.parent)
        raise DataError(
            f"{path}: no such file; give the folder of a finished run of eval.py{_runs_inside(path.parent)}"
        )
    value = parse_line(read_plain(path, _MAX_BYTES), str(path), f"{_NO_SUMMARY}; {_RESTORE}")
    if not isinstance(value, dict):
        raise DataError(f"{path}: {_NO_SUMMARY}; {_RESTORE}")
    return value


def is_sealed(folder: Path) -> bool:
    """Whether there are checksums, right or wrong; runs of older versions have none.

    Raises:
        DataError: no summary of a run of ``eval.py`` there.
    """
    said = read_object(folder / SUMMARY)
    if "habit_level" not in said:  # a summary of train.py has none
        raise DataError(f"{folder / SUMMARY}: {_NO_SUMMARY}; give the folder of one")
    return (folder / SECONDS).exists() or not {"files", "checksum"}.isdisjoint(said)


def _unsealed(path: Path) -> dict[str, Any]:
    """Content of a file whose own checksum is right, with ``files``."""
    if path.name == SECONDS and not path.is_file():
        _refuse_older(path.parent)
        raise DataError(f"{path}: missing; {_RESTORE}, or see `python -m ucon verify {path.parent} --seal`")
    value = read_object(path)
    body, seal, checksum = read_plain(path, _MAX_BYTES).rpartition(_SEAL.encode())
    if not seal or checksum != f'{sha256_bytes(body)}"\n}}\n'.encode():
        _refuse_older(path.parent)
        raise DataError(f"{path}: its checksum does not match its content; the file is altered, {_RESTORE}")
    files = value.get("files")
    if not isinstance(files, dict) or not all(re.fullmatch("[0-9a-f]{64}", str(digest)) for digest in files.values()):
        raise DataError(f"{path}: no usable checksums of the run's files; {_RESTORE}")
    return {key: kept for key, kept in value.items() if key != "checksum"}


def _refuse_older(folder: Path) -> None:
    if not is_sealed(folder):
        raise DataError(
            f"{folder / SUMMARY}: no checksums (written by an older version); `python -m ucon verify {folder} --seal` "
            "recomputes its figures and adds them"
        )


def _compare(folder: Path, by: str, name: str, found: str | None, expected: str | None) -> None:
    if found == expected:
        return
    if found is None:
        problem = f"missing, but {by} has its checksum; restore it, or see `python -m ucon verify {folder} --seal`"
    elif expected is None:
        problem = f"not part of the run that {by} describes; remove it"
    else:
        problem = f"SHA-256 {found[:12]}, {by} says {brief(expected[:12])}; the file is altered, {_RESTORE}"
    raise DataError(f"{folder / name}: {problem}")


def _runs_inside(folder: Path) -> str:
    """Names of the runs in a folder that holds several, such as that of a sweep or of ``try``."""
    inside = sorted(path.parent.name for path in folder.glob("*/summary.json"))
    return f", such as one in it: {brief(', '.join(inside))}" if inside else ""
