"""Measuring retrieval on held-out entries: mistakes on the command line."""

import subprocess
import sys
from pathlib import Path

import pytest

from ucon.core.errors import ConfigError, DataError
from ucon.fitting.held_out_retrieval import main

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("words", "kind", "message"),
    [
        (["--official", "/nope"], DataError, "/nope: cannot be read"),
        (["--tuned", "/nope"], DataError, "/nope: no adapter there"),
        (["--kbs", "0"], ConfigError, "--kbs 0: expected a number of knowledge bases from 1 up"),
        (["--kbs", "-3"], ConfigError, "--kbs -3: expected"),
    ],
)
def test_mistakes_are_typed(words, kind, message):
    with pytest.raises(kind, match=message):
        main(words)


def test_a_mistake_ends_in_one_line():
    command = [sys.executable, "-m", "ucon", "data", "measure-retrieval", "--official", "/nope"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert result.returncode == 2
    assert result.stderr.splitlines() == [
        "error: /nope: cannot be read (No such file or directory); expected a task file of the release"
    ]
