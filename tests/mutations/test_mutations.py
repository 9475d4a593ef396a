"""Whatever happened to a file, its reader gives the same result or an error in one line: no traceback, no other figure.

It also starts no program and opens no socket. To repeat a failure: ``pytest tests/mutations -k 'KIND and 17'``.
"""

import random
import shutil
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.mutations.kinds import KINDS, Kind
from tests.mutations.mutate import BYTES, INSIDE, PLACES
from tests.mutations.watch import limited, watched
from ucon.core.errors import UconError
from ucon.habits.book import MOST_TOLD

#: Numbers of mutations of all kinds together; those of `make test` come first.
FAST, ALL = 48, 336
_EACH = ALL // len(KINDS)


@dataclass(frozen=True)
class Made:
    """A kind's files, and what their reader returns for the unchanged files."""

    kind: Kind
    folder: Path
    right: Any


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Made]:
    """Kinds made so far; each is made on first use."""
    return {}


def _made(name: str, made: dict[str, Made], factory: pytest.TempPathFactory) -> Made:
    if name not in made:
        folder = factory.mktemp(name)
        kind = KINDS[name](folder)
        copy = factory.mktemp(f"{name}-right") / "copy"
        shutil.copytree(folder, copy, symlinks=True)
        made[name] = Made(kind, folder, kind.read(copy))
    return made[name]


def mutate(kind: Kind, folder: Path, rng: random.Random) -> tuple[str, bool]:
    """Change one file; returns what was done, and whether other results are now acceptable."""
    path = folder / rng.choice(kind.files)
    raw = path.read_bytes()
    forged = kind.seal is not None and path.name != "MANIFEST.json" and rng.random() < 0.4
    if rng.random() < 0.12:
        what, forged = rng.choice(sorted(PLACES)), False
        path.unlink()
        PLACES[what](path)
    elif kind.unpack and kind.pack and path.name != "MANIFEST.json" and rng.random() < 0.6:
        what = rng.choice(INSIDE)
        path.write_bytes(kind.pack(BYTES[what](kind.unpack(raw), rng, kind.other)))
        what = f"{what} inside"
    else:
        what = rng.choice(sorted(BYTES))
        path.write_bytes(BYTES[what](raw, rng, kind.other))
    if forged and kind.seal:
        kind.seal(folder)
    return f"{what} of {path.name}{', forged' if forged else ''}", forged or kind.authored


def verdict(kind: Kind, folder: Path, right: Any, *, free: bool) -> str:
    """What is wrong with how a mutated file was read; empty if nothing is."""
    found: Any = right
    with watched() as events, limited():
        try:
            found = kind.read(folder)
        except UconError as error:
            first, *listed = str(error).split("\n")
            if len(listed) > MOST_TOLD or not all(line.startswith("  ") for line in listed):
                return f"no single line, and no list of faults: {str(error)[:300]!r}"
            if not all(line.isprintable() and 0 < len(line) < 2000 for line in (first, *listed)):
                return f"lines that cannot be shown: {str(error)[:300]!r}"
        except Exception:  # also a MemoryError: no file may take that much
            return traceback.format_exc(limit=-6)
    if events:
        return f"it did {events[:3]}"
    return (
        "" if free or found == right else f"another result without a word: {str(found)[:300]}, was {str(right)[:300]}"
    )


def _numbers() -> list[Any]:
    fast = FAST // len(KINDS)
    cases = [(name, number) for name in KINDS for number in range(_EACH)]
    return [
        pytest.param(name, number, marks=() if number < fast else pytest.mark.slow, id=f"{name}-{number}")
        for name, number in cases
    ]


@pytest.mark.parametrize(("name", "number"), _numbers())
def test_a_mutated_file_is_refused_in_one_line_or_read_as_it_was(
    name: str, number: int, made: dict[str, Made], tmp_path_factory: pytest.TempPathFactory, tmp_path: Path
) -> None:
    one, folder = _made(name, made, tmp_path_factory), tmp_path / "copy"
    shutil.copytree(one.folder, folder, symlinks=True)
    what, free = mutate(one.kind, folder, random.Random(f"{name} {number}"))
    wrong = verdict(one.kind, folder, one.right, free=free)
    assert not wrong, f"{name}, number {number}, {what}: {wrong}"


def test_what_a_reader_does_beside_reading_is_seen(tmp_path: Path) -> None:
    import socket
    import subprocess
    import sys

    def program(folder: Path) -> int:
        return subprocess.run([sys.executable, "--version"], capture_output=True, check=True).returncode

    def network(folder: Path) -> int:
        socket.socket().close()
        return 0

    def several_lines(folder: Path) -> int:
        raise UconError("one\ntwo")

    def bug(folder: Path) -> int:
        return int("x")

    readers = {program: "subprocess", network: "socket", several_lines: "no single line", bug: "ValueError"}
    for reader, message in readers.items():
        assert message in verdict(Kind((), reader), tmp_path, 0, free=False)
    assert "another result" in verdict(Kind((), lambda folder: 1), tmp_path, 0, free=False)
    assert not verdict(Kind((), lambda folder: 1), tmp_path, 0, free=True)
