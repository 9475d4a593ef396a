"""Ctrl-C and SIGTERM for ``train.py`` and ``eval.py`` as commands: exit code, time, and that they continue."""

import functools
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
#: Promised limit on seconds from the signal to the end of the process, not counting those waiting for a core.
MOST_S = 5.0
TRAIN = (
    "train.py", "learner=retriever", "learner.rank=2", "learner.n_kbs=1", "training.validate_every=2",
    "training.steps=4",
)  # fmt: skip
EVAL = ("eval.py", "agent=frontier", "habit_level=none", "limit=12", "pictures=0", "workers=1")
CODES = {signal.SIGINT: 130, signal.SIGTERM: 143}
#: The file that shows progress, the number of its lines to wait for, and the file that must come out the same.
FILES = {TRAIN: ("metrics.jsonl", 2, "metrics.jsonl"), EVAL: ("episodes.jsonl.partial", 3, "episodes.jsonl")}


def started(command: tuple[str, ...], out: Path) -> subprocess.Popen[str]:
    """Start a command that reacts to Ctrl-C, even from a shell's background job, which would ignore it."""
    return subprocess.Popen(
        [sys.executable, *command, f"out={out}", "progress=false"],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )


def waiting_s(pid: int) -> float:
    """Seconds in which a process's main thread was ready but waited for a core; 0 if unknown."""
    try:
        return int(Path(f"/proc/{pid}/task/{pid}/schedstat").read_text().split()[1]) / 1e9
    except (OSError, IndexError):
        return 0.0


def finish(*words: str) -> None:
    command = [sys.executable, *words, "progress=false"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]


@functools.cache
def whole(command: tuple[str, ...], folder: Path) -> bytes:
    finish(*command, f"out={folder}")
    return (folder / FILES[command][2]).read_bytes()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("whole")


@pytest.mark.slow
@pytest.mark.parametrize("number", CODES)
@pytest.mark.parametrize("command", [TRAIN, EVAL], ids=lambda command: command[0])
def test_a_signal_ends_a_command_in_time_with_its_code_and_it_goes_on(
    tmp_path: Path, folder: Path, command: tuple[str, ...], number: signal.Signals
) -> None:
    out = tmp_path / "run"
    sign, lines, result = FILES[command]
    process = started(command, out)
    try:
        deadline = time.monotonic() + 120
        while not ((out / sign).is_file() and (out / sign).read_text().count("\n") >= lines):
            assert process.poll() is None, process.communicate()[1]
            assert time.monotonic() < deadline
            time.sleep(0.02)
        sent = time.monotonic()
        process.send_signal(number)
        waited = waited_at_first = waiting_s(process.pid)
        while process.poll() is None:
            waited = waiting_s(process.pid) or waited
            time.sleep(0.02)
        took = time.monotonic() - sent - (waited - waited_at_first)
        _, told = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == CODES[number], told
    assert took < MOST_S, told
    last = told.strip().splitlines()[-1]
    if command is TRAIN:
        assert f"continue with resume={out}" in last
        finish("train.py", f"resume={out}")
    else:
        assert last.startswith("error: interrupted; " if number == signal.SIGINT else "error: terminated; ")
        finish(*command, f"out={out}")
    assert (out / result).read_bytes() == whole(command, folder / command[0])
