"""A newer Python without PyBullet, with newer packages, plays a pack to the same bytes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ucon.__main__ import main

ROOT = Path(__file__).parents[2]
#: What playing compiled homes imports, in their newest releases.
NEEDED = ("numpy>=2.5,<2.6", "numba", "gymnasium", "opencv-python-headless", "scipy", "pillow", "bm25s", "safetensors")
PLAY = """
import hashlib, sys
import gymnasium, numpy, ucon
assert sys.argv[1] in ("any", numpy.__version__[:3]), numpy.__version__
digest = hashlib.sha256()
for level in ("retrieval", "full"):
    env = gymnasium.make("UcON-v0", habit_level=level, detector=True)
    for episode in (0, 7):
        seen = [env.reset(options={"episode": episode})]
        seen += [env.step(int(digit)) for digit in env.unwrapped.episode.solution]
        for step in seen:
            for name, value in sorted(step[0].items()):
                digest.update(name.encode() + numpy.asarray(value).tobytes())
        digest.update(repr(sorted(seen[-1][-1]["episode_metrics"].items())).encode())
print(digest.hexdigest())
"""


def python313() -> str | None:
    """A Python 3.13 that starts, from pyenv or the path; None if there is none."""
    kept = sorted(Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")).glob("versions/3.13*/bin/python3.13"))
    for candidate in (*map(str, kept), shutil.which("python3.13")):
        if candidate and subprocess.run([candidate, "-c", ""], capture_output=True, check=False).returncode == 0:
            return candidate
    return None


def played(python: str, pack: Path, empty: Path, numpy: str) -> str:
    changed = {"UCON_PACK": str(pack), "UCON_CACHE": str(empty / "cache"), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [python, "-c", PLAY, numpy], env=os.environ | changed, capture_output=True, text=True, timeout=900, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.strip()


@pytest.mark.slow
def test_python_3_13_with_numpy_2_5_plays_the_same_bytes(tmp_path: Path) -> None:
    python = python313()
    if python is None:
        pytest.skip("no Python 3.13 on the path or under pyenv")
    subprocess.run([python, "-m", "venv", str(tmp_path / "venv")], check=True)
    new = str(tmp_path / "venv" / "bin" / "python")
    pip = [new, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *NEEDED]
    made = subprocess.run(pip, capture_output=True, text=True, check=False, timeout=900)
    if made.returncode != 0:
        pytest.skip(f"packages for it cannot be installed here: {made.stderr.strip().splitlines()[-1][:200]}")
    assert main(["pack", "mini", "--out", str(tmp_path / "pack")]) == 0
    here = played(sys.executable, tmp_path / "pack", tmp_path, "any")
    assert played(new, tmp_path / "pack", tmp_path, "2.5") == here
