"""A learner whose worker was killed or stopped leaves no process and no shared memory behind."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from tests.learning.tiny_ppo import tiny_ppo
from ucon.learning.ppo.collecting import InWorkers
from ucon.learning.run.workers import LearnerWorkerError

SHARED = Path("/dev/shm")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc and /dev/shm"),
]


def shared() -> set[str]:
    """Names of this user's pieces of shared memory."""
    return {path.name for path in SHARED.iterdir() if path.lstat().st_uid == os.getuid()}


def descendants(of: int) -> set[int]:
    """All processes below one, but those that are dead and only wait to be asked how they ended."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent = stat.read_text().rpartition(")")[2].split()[:2]
        except OSError:  # it has ended meanwhile
            continue
        if state not in "ZX":
            parents[int(stat.parent.name)] = int(parent)
    found, new = set(), {of}
    while new := {child for child, parent in parents.items() if parent in new} - found:
        found |= new
    return found


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP, None])
def test_neither_process_nor_shared_memory(tmp_path, number):
    """Workers that were killed, stopped, or left alone."""
    processes, memory = descendants(os.getpid()), shared()
    learner = tiny_ppo(tmp_path, collector=InWorkers(2, worker_timeout_s=120.0), frames=8, levels=("none",))
    try:
        learner.step()
        workers = list(learner.rollouts._workers())
        assert len(workers) == 2
        if number is not None:
            object.__setattr__(learner.rollouts._collecting, "worker_timeout_s", 3.0)
            os.kill(workers[0].pid, number)
            began = time.monotonic()
            with pytest.raises(LearnerWorkerError):
                learner.step()
            assert time.monotonic() - began < 60, "3 s, and the same again to find out who does not answer"
    finally:
        learner.close()
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline and {worker.pid for worker in workers} & descendants(os.getpid()):
        time.sleep(0.05)
    left = {pid for pid in descendants(os.getpid()) - processes if not is_tracker(pid)}
    assert left == set()
    assert shared() - memory == set()


def is_tracker(pid: int) -> bool:
    """Whether a process is Python's own, which lives as long as its parent and sweeps what others leave."""
    line = Path(f"/proc/{pid}/cmdline").read_bytes() if Path(f"/proc/{pid}/cmdline").exists() else b""
    return b"resource_tracker" in line or b"forkserver" in line
