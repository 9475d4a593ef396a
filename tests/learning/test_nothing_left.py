"""A training run that lost a worker leaves no processes and no shared memory behind when it has ended."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc"),
]


def train_until_lost(folder: str, number: int) -> None:
    """Learn a step with two workers, lose one, and end as ``train.py`` does.

    Prints its worker processes, and the files of shared memory that any of its processes has mapped.
    """
    from tests.learning.tiny_ppo import tiny_ppo
    from ucon.learning.ppo.collecting import InWorkers
    from ucon.learning.run import workers as workers_module
    from ucon.learning.run.workers import LearnerWorkerError

    workers_module.MOST_REPLACED = 0
    learner = tiny_ppo(Path(folder), collector=InWorkers(2, worker_timeout_s=120.0), frames=8, levels=("none",))
    try:
        learner.step()
        workers = [worker.pid for worker in learner.rollouts._workers()]
        shared = {name for pid in (os.getpid(), *workers) for name in mapped(pid)}
        sys.stdout.write(json.dumps({"workers": workers, "shared": sorted(shared)}) + "\n")
        object.__setattr__(learner.rollouts._collecting, "worker_timeout_s", 3.0)
        os.kill(workers[0], number)
        learner.step()
    except LearnerWorkerError as error:
        sys.exit(str(error))
    finally:
        learner.close()


def mapped(pid: int) -> set[str]:
    """Files of shared memory that a process has mapped."""
    lines = Path(f"/proc/{pid}/maps").read_text().splitlines()
    return {line.split(maxsplit=5)[5] for line in lines if "/dev/shm/" in line and "(deleted)" not in line}


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_neither_process_nor_shared_memory(tmp_path, number):
    program = tmp_path / "main.py"  # a file, since workers import the main program
    call = f"train_until_lost({str(tmp_path)!r}, {int(number)})"
    program.write_text(
        f"from tests.learning.test_nothing_left import train_until_lost\nif __name__ == '__main__':\n    {call}\n"
    )
    done = subprocess.run(
        [sys.executable, str(program)],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 1, done.stderr[-2000:]
    assert "resume=RUN continues" in done.stderr
    held = json.loads(done.stdout.splitlines()[0])
    assert len(held["workers"]) == 2
    assert held["shared"], "it did use shared memory, so there was something to leave behind"
    assert not any(map(is_running, held["workers"]))
    assert [name for name in held["shared"] if Path(name).exists()] == []
