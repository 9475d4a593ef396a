"""Own homes, which users describe in files, by name: ``own:my_flat:3fa9b2c4d5e6``, a short title and a hash.

The hash covers the program and the seed, so a name always means the same home. The program is stored in the user's
cache, where other processes and later replays find it.
"""

from __future__ import annotations

import contextlib
import re
from dataclasses import asdict
from typing import Any, Final

from ucon.core.errors import DataError, brief
from ucon.core.files import canonical_json, sha256_bytes, user_cache, write_atomic
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.strict_json import parse_json
from ucon.scenes.program import HomeProgram, program_of

PREFIX: Final = "own:"
#: Version of the stored form.
_FORMAT: Final = 1
_NAME: Final = re.compile(r"own:([a-z0-9_]{1,40}):([0-9a-f]{12})")
_MOST_BYTES: Final = 1 << 20
#: Programs of this process, for when the cache cannot be written.
_KNOWN: dict[str, str] = {}


def is_own(name: str) -> bool:
    """Whether a name is that of an own home."""
    return name.startswith(PREFIX)


def own_name(called: str, program: HomeProgram, seed: int) -> str:
    """The name of an own home.

    Args:
        called: the title that its user gives it.
        program: its rooms and furniture.
        seed: of its plan and furnishing.
    """
    return _named(called, _text(program, seed))


def keep_program(called: str, program: HomeProgram, seed: int) -> str:
    """Store a program for this process and, where the cache can be written, for others.

    Args:
        called: the title that the home's user gives it.
        program: its rooms and furniture.
        seed: of its plan and furnishing.

    Returns:
        The home's name.
    """
    text = _text(program, seed)
    name = _named(called, text)
    if name not in _KNOWN:
        with contextlib.suppress(OSError):
            write_atomic(_path(name), text)
    _KNOWN[name] = text
    return name


def own_program(name: str) -> tuple[HomeProgram, int]:
    """Program and seed of an own home.

    Raises:
        DataError: malformed name, or its program is not stored on this machine or was altered.
    """
    if not _NAME.fullmatch(name):
        raise DataError(f"home '{brief(name)}': expected own:<name>:<12 digits and letters>, as `home check` prints")
    text = _KNOWN.get(name) or _kept(name)
    try:
        data = parse_json(text)
        return program_of(name, data["program"]), int(data["seed"])
    except (ValueError, LookupError, TypeError):
        raise DataError(f"home '{name}': its stored copy is not usable; {_AGAIN}") from None


def kept_names() -> tuple[str, ...]:
    """Names of the own homes that are stored on this machine, the most recent first."""
    folder = user_cache() / "own"
    try:
        files = sorted(folder.glob("*.json"), key=lambda path: -path.stat().st_mtime)
    except OSError:  # removed in between
        return ()
    names = (PREFIX + ":".join(path.stem.rpartition("-")[::2]) for path in files)
    return tuple(name for name in names if _NAME.fullmatch(name))


_AGAIN: Final = "give its file again (python -m ucon home check FILE.yaml)"


def _kept(name: str) -> str:
    try:
        text = read_bounded(_path(name), _MOST_BYTES).decode(errors="replace")
    except OSError:
        raise DataError(f"home '{name}': made from a home file, not stored on this machine; {_AGAIN}") from None
    if _digest(text) != name.rpartition(":")[2]:
        raise DataError(f"home '{name}': its stored copy was altered; {_AGAIN}")
    return text


def _path(name: str) -> Any:
    return user_cache() / "own" / f"{name.removeprefix(PREFIX).replace(':', '-')}.json"


def _named(called: str, text: str) -> str:
    short = re.sub(r"[^a-z0-9]+", "_", called.lower()).strip("_")[:40].strip("_") or "home"
    return f"{PREFIX}{short}:{_digest(text)}"


def _digest(text: str) -> str:
    return sha256_bytes(text.encode())[:12]


def _text(program: HomeProgram, seed: int) -> str:
    return canonical_json({"format": _FORMAT, "program": asdict(program), "seed": seed})
