"""One mutant: made in a copy of the tree, tested, and reverted."""

from __future__ import annotations

import os
import resource
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cosmic_ray.mutating import use_mutation
from cosmic_ray.plugins import get_operator
from cosmic_ray.testing import run_tests
from cosmic_ray.work_item import TestOutcome

from tests.mutants.copies import environment, kernels, mutants_kernels, own_cache
from tests.mutants.places import Mutation

#: No test needs more; a mutant that multiplies a size must not bring the machine down.
MEMORY_BYTES: Final = 10 << 30
OUT_OF_TIME: Final = "out of time"
#: Time limit for a mutant's tests: this multiple of their recorded time, plus seconds for starting and for compiling.
_SLOWER, _STARTING_S, _COMPILING_S = 5.0, 90.0, 240.0


@dataclass(frozen=True)
class Tried:
    """The outcome of a trial."""

    killed: bool
    by: str
    """The test that failed, or why none did."""


def attempt(session: Path, number: int, mutation: Mutation, tests: Sequence[str], seconds: float) -> Tried:
    """Try a mutation in copy ``number`` of a session with ``tests``, which take ``seconds`` without it."""
    if not tests:
        return Tried(False, "no test reaches it")
    copy = session / f"copy-{number}"
    path = copy / mutation.file
    dates, good = path.stat(), kernels(copy)
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, resource.getrlimit(resource.RLIMIT_DATA)[1]))
    os.chdir(copy)
    command = f"{sys.executable} -m pytest -x -q -n 0 -p no:cacheprovider --tb=line -m 'not slow and not timed' "
    try:
        with (
            own_cache(session / "cache", session / f"cache-{number}") as cache,
            use_mutation(path, get_operator(mutation.operator)(), mutation.occurrence),
            mutants_kernels(copy, good, mutation.file) as compiling,
        ):
            os.environ.update(environment(copy, cache))
            limit = _STARTING_S + _SLOWER * seconds + compiling * _COMPILING_S
            outcome, output = run_tests(command + " ".join(tests), limit)
    finally:
        os.utime(path, ns=(dates.st_atime_ns, dates.st_mtime_ns))  # compiled bytecode stays valid
    if outcome == TestOutcome.INCOMPETENT or ("no tests ran" in output and "ERROR" not in output):
        raise RuntimeError(f"{mutation.file}:{mutation.line}: {output}")
    killed = outcome == TestOutcome.KILLED
    return Tried(killed, _killer(output) if killed else f"{len(tests)} tests pass")


def _killer(output: str) -> str:
    if output == "timeout":
        return OUT_OF_TIME
    failed = [line for line in output.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    if failed:
        return failed[0].split(" ", 1)[1].split(" - ")[0]
    return (output.strip().splitlines() or ["no word"])[-1][:200]
