"""Mutation testing: ``make mutants``, or ``python -m tests.mutants --help``.

A seeded sample of mutations of the nine parts is tried with cosmic-ray in copies of the working tree, each against the
tests that run its line. The session is kept: an interrupted one continues where it stopped, and survivors are tried
again, since tests may have been added. The exit code is 1 if too few mutants are killed.
"""

from __future__ import annotations

import argparse
import hashlib
import multiprocessing
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

from cosmic_ray.work_db import WorkDB, use_db
from cosmic_ray.work_item import MutationSpec, TestOutcome, WorkerOutcome, WorkItem, WorkResult

from tests.mutants.copies import environment, refresh
from tests.mutants.places import Mutation, changed_line
from tests.mutants.reach import Reach, Recorded
from tests.mutants.recording import follow, missing, record
from tests.mutants.report import Outcome, killed_share, known, reason, report
from tests.mutants.sample import PARTS, part_of, sampled
from tests.mutants.trial import OUT_OF_TIME, Tried, attempt

_Job = TypeVar("_Job")
_Result = TypeVar("_Result")


def main(words: Sequence[str] | None = None) -> int:
    """Record tests that are not recorded yet, try mutations that are not tried yet, and report."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description="Mutation testing.")
    parser.add_argument("--session", type=Path, default=Path("build/mutants"), help="folder that keeps what was done")
    parser.add_argument("--jobs", type=int, default=2, help="copies that work side by side")
    parser.add_argument("--count", type=int, default=150, help="mutants")
    parser.add_argument("--seed", type=int, default=0, help="of the sample")
    parser.add_argument("--at-least", type=float, default=90.0, help="per cent that must be killed")
    parser.add_argument("--budget", type=float, default=120.0, help="seconds of tests a mutant, as they were recorded")
    parser.add_argument(
        "--part", choices=PARTS, action="append", help="only mutants and tests of this part (repeatable)"
    )
    parser.add_argument("--limit", type=int, help="try only so many now; the rest another time")
    args = parser.parse_args(words)
    root, session = Path.cwd(), args.session.resolve()
    if not (root / ".git").exists():
        parser.error(f"{root}: no clone; mutants live in copies of what git lists there")
    run, parts = Run(root, session, args.jobs, args.budget), args.part or list(PARTS)
    run.prepare(parts)
    chosen = [mutation for mutation in sampled(root, args.count, args.seed) if part_of(mutation.file) in parts]
    return run.judge(chosen, args.limit, args.at_least)


class Run:
    """One call of the command on a session."""

    def __init__(self, root: Path, session: Path, jobs: int, budget_s: float) -> None:
        self.root, self.session, self.jobs, self.budget_s = root, session, jobs, budget_s

    def prepare(self, parts: Sequence[str]) -> None:
        """Bring copies up to date and record what the tests of these parts run."""
        first = self.session / "copy-0"
        before = {
            path.relative_to(first).as_posix(): path.read_text()
            for folder in ("ucon", "models", "tests")
            for path in (first / folder).rglob("*.py")
        }
        for number in range(self.jobs):
            refresh(self.root, self.session / f"copy-{number}")
        changed = {file: text for file, text in before.items() if _now(self.root, file) != text}
        if changed:
            follow(self.session, changed, lambda file: _now(self.root, file))
        tell("compiling kernels")
        for number in range(self.jobs):
            copy = self.session / f"copy-{number}"
            words = [sys.executable, "-m", "ucon", "doctor", "--warm"]
            env = environment(copy, self.session / "cache")
            subprocess.run(words, cwd=copy, env=env, check=True, stdout=subprocess.DEVNULL)
        todo = missing(self.root, self.session, parts)
        with ThreadPoolExecutor(self.jobs) as pool:
            dealt(pool, self.jobs, todo, lambda number, file: record(self.root, self.session, number, file), "recorded")

    def judge(self, mutations: Sequence[Mutation], limit: int | None, at_least: float) -> int:
        """Try the mutations and print the outcome; returns 1 if too few are killed, or not all were tried."""
        equivalent = known()
        reach = Reach(self.root, Recorded.read((self.session / "map").glob("*.json")))
        with use_db(str(self.session / "session.sqlite"), WorkDB.Mode.create) as db:
            jobs = self._jobs(db, mutations)
            done = self._done(db, jobs)
            todo = [job for job in jobs if job not in done or not (done[job].killed or reason(done[job], equivalent))][
                :limit
            ]
            self._try(db, reach, {job: jobs[job] for job in todo}, done)
        outcomes = [done[job] for job in jobs if job in done]
        print(report(outcomes, equivalent))  # noqa: T201
        share = killed_share(outcomes) if outcomes else 0.0
        late = sum(one.by == OUT_OF_TIME for one in outcomes)
        tell(
            f"{len(outcomes)} of {len(jobs)} tried, {100 * share:.1f} % killed, {at_least:g} % expected; {late} by time"
        )
        return int(len(outcomes) < len(jobs) or 100 * share < at_least)

    def _jobs(self, db: WorkDB, mutations: Sequence[Mutation]) -> dict[str, Mutation]:
        """The session's jobs by id, a hash of the mutation and the file's content, so that new code gets new jobs."""
        jobs = {
            hashlib.sha256(f"{m.key}|{(self.root / m.file).read_text()}".encode()).hexdigest()[:32]: m
            for m in mutations
        }
        there = {item.job_id for item in db.work_items}
        db.add_work_items(WorkItem.single(job, self._spec(m)) for job, m in jobs.items() if job not in there)
        return jobs

    @staticmethod
    def _spec(m: Mutation) -> MutationSpec:
        start = (m.line, m.column)
        return MutationSpec(
            Path(m.file), m.operator, m.occurrence, start, max(m.end, (m.line, m.column + 1)), {}, m.function
        )

    def _done(self, db: WorkDB, jobs: dict[str, Mutation]) -> dict[str, Outcome]:
        return {
            job: self._outcome(jobs[job], Tried(result.test_outcome == TestOutcome.KILLED, result.output or ""))
            for job, result in db.results
            if job in jobs
        }

    def _outcome(self, mutation: Mutation, tried: Tried) -> Outcome:
        after = changed_line((self.root / mutation.file).read_text(), mutation)
        return Outcome(mutation, after, tried.killed, tried.by)

    def _try(self, db: WorkDB, reach: Reach, jobs: dict[str, Mutation], done: dict[str, Outcome]) -> None:
        tests = {job: reach.tests(mutation, self.budget_s) for job, mutation in jobs.items()}
        lock = threading.Lock()

        def one(number: int, job: str) -> str:
            seconds = reach.seconds(tests[job])
            tried = processes.submit(attempt, self.session, number, jobs[job], tests[job], seconds).result()
            outcome = self._outcome(jobs[job], tried)
            diff = f"- {outcome.mutation.text}\n+ {outcome.after}"
            result = TestOutcome.KILLED if tried.killed else TestOutcome.SURVIVED
            with lock:
                db.set_result(job, WorkResult(WorkerOutcome.NORMAL, tried.by, result, diff))
                done[job] = outcome
            what = f"killed by {tried.by}" if tried.killed else f"LIVED ({tried.by})"
            return f"{jobs[job].file}:{jobs[job].line}  {outcome.mutation.text}  ->  {outcome.after}  {what}"

        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(self.jobs, context) as processes, ThreadPoolExecutor(self.jobs) as pool:
            dealt(pool, self.jobs, list(jobs), one, "tried")


def dealt(
    pool: ThreadPoolExecutor, copies: int, jobs: Sequence[_Job], work: Callable[[int, _Job], _Result], what: str
) -> None:
    """Do each job in a free copy, and print progress."""
    free: queue.Queue[int] = queue.Queue()
    for number in range(copies):
        free.put(number)
    begun, done, lock = time.monotonic(), 0, threading.Lock()

    def one(job: _Job) -> None:
        nonlocal done
        number = free.get()
        try:
            result = work(number, job)
        finally:
            free.put(number)
        with lock:
            done += 1
            left = (time.monotonic() - begun) / done * (len(jobs) - done)
            tell(f"[{done}/{len(jobs)}] {what}, {left / 60:.0f} min left  {result or job}")

    for future in [pool.submit(one, job) for job in jobs]:
        future.result()


def tell(text: str) -> None:
    """Print a line of progress."""
    print(text, flush=True)  # noqa: T201


def _now(root: Path, file: str) -> str:
    return (root / file).read_text() if (root / file).is_file() else ""


if __name__ == "__main__":
    os.environ.pop("NUMBA_CACHE_DIR", None)  # every copy has its own kernels
    sys.exit(main())
