"""Runs ``eval.py`` and ``train.py`` many times in one process, since imports cost seconds and a wrong option does not.

    python -m tests.programs < calls.json

Standard input is a JSON list of argument lists, the script first; standard output is a JSON list of [exit code,
standard error].
"""

from __future__ import annotations

import contextlib
import io
import json
import runpy
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]


def outcomes(calls: Sequence[Sequence[str]], *, cwd: Path = ROOT) -> list[tuple[int, str]]:
    """Exit code and standard error of each call, run one after the other in one new process."""
    command = [sys.executable, "-m", "tests.programs"]
    done = subprocess.run(command, input=json.dumps(calls), cwd=cwd, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return [(code, told) for code, told in json.loads(done.stdout.splitlines()[-1])]


def _outcome(script: str, *words: str) -> tuple[int, str]:
    from hydra.core.global_hydra import GlobalHydra

    GlobalHydra.instance().clear()
    sys.argv, told = [str(ROOT / script), *words], io.StringIO()
    with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
        try:
            runpy.run_path(sys.argv[0], run_name="__main__")
        except SystemExit as ended:
            return int(ended.code or 0), told.getvalue()
        except BaseException as error:  # what a shell would show as a traceback
            return 1, f"{told.getvalue()}{type(error).__name__}: {error}"
    return 0, told.getvalue()


if __name__ == "__main__":
    sys.stdout.write(f"{json.dumps([_outcome(*call) for call in json.load(sys.stdin)])}\n")
