"""Atomic files and SHA-256 manifests: a file is either whole and verified, or an error."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.untrusted.plain_file import read_bounded, read_plain
from ucon.core.untrusted.strict_json import JsonError, parse_json

MANIFEST = "MANIFEST.json"
#: Largest manifest, bytes.
_MOST_MANIFEST = 64 << 20


def user_cache() -> Path:
    """Folder of the user's cache.

    ``$UCON_CACHE``, else ``ucon`` in the platform's cache folder, else in the temporary folder.
    """
    if chosen := os.environ.get("UCON_CACHE"):
        return Path(chosen)
    try:
        if sys.platform == "win32":
            return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "ucon"
        if sys.platform == "darwin":
            return Path.home() / "Library" / "Caches" / "ucon"
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ucon"
    except RuntimeError:  # the user's home folder is unknown
        return Path(tempfile.gettempdir()) / "ucon"


def user_pack() -> Path | None:
    """Folder ``$UCON_PACK``, which ``python -m ucon pack`` wrote on another machine; None if the variable is not set.

    Raises:
        ConfigError: there is no such folder.
    """
    named = os.environ.get("UCON_PACK")
    if not named:
        return None
    folder = Path(named).expanduser()
    if not folder.is_dir():
        raise ConfigError(f"UCON_PACK={named}: no such folder; name what `python -m ucon pack SET --out FOLDER` wrote")
    return folder


def sha256_bytes(data: bytes) -> str:
    """SHA-256 of bytes, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def sha256_file(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal; read in pieces."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while chunk := file.read(1 << 20):
            digest.update(chunk)
    return digest.hexdigest()


def remembered_sha256(path: Path) -> str:
    """SHA-256 of a large file, in hexadecimal; the file is read again only if its size or modification time changed."""
    stat, name = path.stat(), str(path.resolve())
    note = user_cache() / "sha256" / f"{sha256_bytes(name.encode())[:32]}.json"
    state = {"bytes": stat.st_size, "mtime_ns": stat.st_mtime_ns}
    try:
        known = parse_json(read_bounded(note, 4096))
        if {key: known[key] for key in state} == state:
            return str(known["sha256"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    found = sha256_file(path)
    with contextlib.suppress(OSError):
        write_atomic(note, canonical_json(state | {"sha256": found}))
    return found


def write_atomic(path: Path, data: bytes | str) -> None:
    """Write a file so that it is never incomplete: write a temporary file next to it, sync, rename.

    Folders are made as needed.

    Raises:
        OSError: it cannot be written.
    """
    _make_folder(path.parent)
    raw = data.encode() if isinstance(data, str) else data
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(raw)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)  # noqa: PTH101 (mkstemp makes 0600)
        os.replace(temporary, path)  # noqa: PTH105
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def require_writable(path: Path) -> None:
    """Check that a file can be written, before the long work whose result goes into it.

    Raises:
        ConfigError: naming the file and the reason.
    """
    try:
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        _make_folder(path.parent)
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror}); choose another place") from None


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:  # unclear message: a file is where the folder should be
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder)) from None


def canonical_json(value: Any) -> str:
    """JSON with sorted keys and no spaces, the text from which hashes are computed."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def write_manifest(folder: Path, names: Iterable[str]) -> None:
    """Write ``MANIFEST.json``, with the size and SHA-256 of files in a folder.

    Args:
        folder: of the files.
        names: of the files.
    """
    entries = {
        name: {"bytes": (folder / name).stat().st_size, "sha256": sha256_file(folder / name)} for name in sorted(names)
    }
    write_atomic(folder / MANIFEST, json.dumps({"files": entries}, indent=1) + "\n")


def listed_files(folder: Path) -> dict[str, Any]:
    """The entries of a folder's manifest, by file name.

    Raises:
        FileNotFoundError: there is no manifest.
        DataError: it is not usable.
    """
    manifest = folder / MANIFEST
    raw = read_plain(manifest, _MOST_MANIFEST)
    try:
        files = parse_json(raw)["files"]
    except (JsonError, LookupError, TypeError):
        files = None
    if not isinstance(files, dict):
        raise DataError(f"{manifest}: not a usable manifest; restore it from the release")
    return files


def read_verified(path: Path, most: int | None = None) -> bytes:
    """Read a file and check it against the manifest in its folder.

    Args:
        path: the file.
        most: largest size in bytes; a larger file is not read. None: the size in the manifest.

    Raises:
        DataError: the file or its manifest entry is missing, or size or checksum differ.
    """
    manifest = path.parent / MANIFEST
    if not path.is_file():
        raise DataError(f"{path}: no such file")
    try:
        entry = listed_files(path.parent)[path.name]
        expected, size = str(entry["sha256"]), entry["bytes"]
        if type(size) is not int:
            raise TypeError
    except FileNotFoundError:
        raise DataError(
            f"{manifest}: missing, so {path.name} cannot be verified; restore it from the release"
        ) from None
    except (LookupError, TypeError):
        raise DataError(f"{manifest}: no usable entry for {path.name}; restore it from the release") from None
    found = path.stat().st_size
    if found != size:
        raise DataError(
            f"{path}: {found} bytes, expected {size}; the file is truncated or altered, restore it from the release"
        )
    data = read_plain(path, size if most is None else most)
    if sha256_bytes(data) != expected:
        raise DataError(
            f"{path}: {len(data)} bytes with SHA-256 {sha256_bytes(data)[:12]}, expected {brief(expected[:12])}; "
            "the file is truncated or altered, restore it from the release"
        )
    return data
