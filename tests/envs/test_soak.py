"""A long-running environment takes no more memory and files than one that has just warmed up."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")

#: Limit on the growth of resident memory, as a share of the warm process's memory.
MOST_GROWTH = 0.02


@pytest.mark.parametrize(
    ("name", "steps", "resets"),
    [
        ("UcON-v0", 2_000, 20),
        pytest.param("UcON-v0", 100_000, 500, marks=pytest.mark.slow),
        pytest.param("UcONResident-v0", 10_000, 20, marks=pytest.mark.slow),
    ],
)
def test_memory_and_files_stay_what_they_were(name: str, steps: int, resets: int) -> None:
    command = [sys.executable, "-m", "tests.envs.soak", name, str(steps), str(resets)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout)
    assert (found["steps"], found["resets"]) == (steps, resets)
    assert found["homes"] > 1
    assert max(found["mb"]) < found["warm_mb"] * (1 + MOST_GROWTH), found
    assert set(found["files"]) == {found["warm_files"]}, found
