"""``eval.py`` on a full disk, as a user runs it: one line, finished episodes are kept, the rest is played later."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits on files differ elsewhere"),
]


def evaluate(out, most_bytes: int | None = None) -> subprocess.CompletedProcess[str]:
    """Evaluate eight episodes; no file of the process may grow beyond ``most_bytes``, as on a full disk."""

    def limit() -> None:
        import resource

        if most_bytes is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    command = [sys.executable, "eval.py", "agent=random", "episodes=mini", "limit=8", "workers=0", "pictures=0"]
    return subprocess.run(
        [*command, "progress=false", f"out={out}"],
        cwd=ROOT,
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=300,
        preexec_fn=limit,
    )


def test_finished_episodes_are_kept_and_the_same_command_goes_on(tmp_path):
    whole = evaluate(tmp_path / "whole")
    assert whole.returncode == 0, whole.stderr[-2000:]
    records = (tmp_path / "whole" / "episodes.jsonl").read_bytes()
    full = evaluate(tmp_path / "run", most_bytes=len(records) // 2)
    assert full.returncode == 2, full.stderr[-2000:]
    assert full.stderr.count("\n") == 1, full.stderr[-2000:]
    assert "File too large; make room" in full.stderr
    assert "the same command with the same out= continues" in full.stderr
    kept = (tmp_path / "run" / "episodes.jsonl.partial").read_bytes().count(b"\n") - 1
    assert 0 < kept < 8
    again = evaluate(tmp_path / "run")
    assert again.returncode == 0, again.stderr[-2000:]
    assert f"for {8 - kept} episodes" in again.stdout
    assert (tmp_path / "run" / "episodes.jsonl").read_bytes() == records
