"""What each test file runs, recorded once and kept while files change, as far as it stays valid."""

from __future__ import annotations

import difflib
import hashlib
import json
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from tests.mutants.copies import environment
from tests.mutants.sample import PARTS

#: A test file that takes longer has hung.
_LIMIT_S = 3600


def test_files(root: Path, parts: Iterable[str]) -> list[str]:
    """Test files of parts."""
    folders = [PARTS[name][1] for name in parts]
    return sorted(p.relative_to(root).as_posix() for folder in folders for p in (root / folder).rglob("test_*.py"))


def missing(root: Path, session: Path, parts: Iterable[str]) -> list[str]:
    """Test files of parts without a record of their current content; outdated records are removed."""
    valid = {_name(root, file) for file in test_files(root, PARTS)}
    for path in (session / "map").glob("*.json"):
        if path.stem not in valid:
            path.unlink()
    return [file for file in test_files(root, parts) if not recorded(root, session, file).is_file()]


def recorded(root: Path, session: Path, file: str) -> Path:
    """Path of the record of a test file."""
    return session / "map" / f"{_name(root, file)}.json"


def _name(root: Path, file: str) -> str:
    return f"{file.replace('/', '.')}-{hashlib.sha256((root / file).read_bytes()).hexdigest()[:12]}"


def record(root: Path, session: Path, number: int, file: str) -> None:
    """Run a test file in copy ``number`` and note which lines its tests run.

    Raises:
        RuntimeError: pytest did not finish.
    """
    copy, out = session / f"copy-{number}", recorded(root, session, file)
    out.parent.mkdir(exist_ok=True)
    words = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", "-p", "tests.mutants.recorder"]
    words += ["--record", f"{out}.part", "-m", "not slow and not timed", file]
    done = subprocess.run(
        words, cwd=copy, env=environment(copy, session / "cache"), capture_output=True, text=True, timeout=_LIMIT_S
    )
    if done.returncode not in (0, 1, 5):  # 1: some fail without a mutation and are left out; 5: all are slow
        raise RuntimeError(f"{file}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    Path(f"{out}.part").replace(out)


def follow(session: Path, before: Mapping[str, str], after: Callable[[str], str]) -> None:
    """Adjust the line numbers in records to changed files; ``before`` has their old texts."""
    ways = {file: moved(text, after(file)) for file, text in before.items()}
    for path in (session / "map").glob("*.json"):
        found = json.loads(path.read_text())
        for file in ways.keys() & found["lines"].keys():
            lines: dict[int, set[int]] = defaultdict(set)
            for line, tests in found["lines"][file].items():
                for new in ways[file].get(int(line), ()):
                    lines[new] |= set(tests)
            found["lines"][file] = {line: sorted(tests) for line, tests in sorted(lines.items())}
        path.write_text(json.dumps(found, separators=(",", ":")))


def moved(before: str, after: str) -> dict[int, list[int]]:
    """New line numbers of each old line; changed lines map to all lines that replaced their block."""
    out: dict[int, list[int]] = {}
    matcher = difflib.SequenceMatcher(None, before.splitlines(), after.splitlines(), autojunk=False)
    for what, a, b, c, d in matcher.get_opcodes():
        for k in range(a, b):
            out[k + 1] = [c + k - a + 1] if what == "equal" else list(range(c + 1, d + 1))
    return out
