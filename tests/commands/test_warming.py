"""``doctor --warm`` compiles everything that an evaluation uses, in two processes, into one cache."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_after_setting_up_nothing_is_compiled(tmp_path: Path) -> None:
    kernels = tmp_path / "kernels"

    def compiled_by(*words: str) -> set[Path]:
        """Paths of the files that a program adds to a cache folder or changes in it."""
        before = {path: path.stat().st_mtime_ns for path in kernels.rglob("*.nb?")}
        setting = os.environ | {"NUMBA_CACHE_DIR": str(kernels), "OMP_NUM_THREADS": "1"}
        words = (sys.executable, *words)
        done = subprocess.run(words, cwd=ROOT, env=setting, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr[-2000:]
        return {path for path in kernels.rglob("*.nb?") if before.get(path) != path.stat().st_mtime_ns}

    assert len(compiled_by("-m", "ucon", "doctor", "--warm")) > 100
    words = ("eval.py", "agent=belief", "habit_level=retrieval", "episodes=mini", f"out={tmp_path}/run")
    assert compiled_by(*words) == set()
    assert compiled_by("-m", "ucon", "demo", "--out", f"{tmp_path}/demo") == set()
