"""Copies of the working tree for the mutants, so that the tree itself is never changed."""

from __future__ import annotations

import filecmp
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ucon.core.jit import sources_hash


def refresh(root: Path, copy: Path) -> None:
    """Make ``copy`` hold what git would commit of ``root``; unchanged files keep their dates."""
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=root, check=True, capture_output=True, text=True
    )
    wanted = {name for name in listed.stdout.split("\0") if name and (root / name).is_file()}
    for name in wanted:
        here, there = root / name, copy / name
        if not (there.is_file() and filecmp.cmp(here, there, shallow=False)):
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(here, there)
    kept = {".pytest_cache", "__pycache__"}
    for path in [path for path in copy.rglob("*") if path.is_file()]:
        relative = path.relative_to(copy)
        if relative.as_posix() not in wanted and not kept & set(relative.parts):
            path.unlink()


def environment(copy: Path, cache: Path) -> dict[str, str]:
    """The environment of tests in a copy: its own code, its own cache, one thread."""
    return {
        **os.environ,
        "PYTHONPATH": str(copy),
        "UCON_CACHE": str(cache),
        "OMP_NUM_THREADS": "1",
    }


@contextmanager
def own_cache(kept: Path, own: Path) -> Iterator[Path]:
    """A separate cache for one mutant with the content of the good one, so that nothing else reads what it writes.

    Files are linked, not copied; the code replaces whole files and never writes into existing ones.
    """
    shutil.rmtree(own, ignore_errors=True)
    kept.mkdir(parents=True, exist_ok=True)
    shutil.copytree(kept, own, copy_function=os.link)
    try:
        yield own
    finally:
        shutil.rmtree(own, ignore_errors=True)


def kernels(copy: Path) -> Path:
    """Folder of the kernels for the current code of a copy."""
    return copy / "ucon" / "__pycache__" / f"kernels-{sources_hash(copy / 'ucon')[:16]}"


@contextmanager
def mutants_kernels(copy: Path, good: Path, file: str) -> Iterator[bool]:
    """Compiled kernels for the mutated code: the good ones, without those that may depend on ``file``.

    Yields whether any have to be recompiled. Otherwise all of them would be, which takes minutes, since they are cached
    by the content of all kernel files.
    """
    mine = kernels(copy)
    if mine == good or not good.is_dir():
        yield False
        return
    stale = {Path(name) for name in depending(copy, file)}
    for path in good.glob("*/*"):
        folder, module = path.parent.name.rsplit("_", 1)[0], path.name.split(".", 1)[0]
        if not any(name.stem == module and name.parent.name == folder for name in stale):
            (mine / path.parent.name).mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, mine / path.parent.name / path.name)
    try:
        yield True
    finally:
        shutil.rmtree(mine, ignore_errors=True)


def depending(copy: Path, file: str) -> set[str]:
    """The file itself and all files that import it, directly or indirectly."""
    sources = {
        p.relative_to(copy).as_posix(): p.read_text()
        for folder in ("ucon", "models")
        for p in (copy / folder).rglob("*.py")
    }
    found, fresh = {file}, {file}
    while fresh:
        modules = [(name.removesuffix(".py").replace("/", ".")) for name in fresh]
        said = [f"from {m} import" for m in modules] + [
            f"from {m.rpartition('.')[0]} import {m.rpartition('.')[2]}" for m in modules
        ]
        fresh = {name for name, text in sources.items() if name not in found and any(one in text for one in said)}
        found |= fresh
    return found
