"""A folder has one writer at a time, and is free when the writer is gone, however it ended."""

import subprocess
import sys

import pytest

from tests.test_eval import evaluate
from tests.test_train import SMALL, error_line, train
from ucon.core.errors import ConfigError
from ucon.core.sole_writer import fcntl, sole_writer

pytestmark = pytest.mark.skipif(fcntl is None, reason="this system locks no folders")
HOLD = """
import sys
from pathlib import Path
from ucon.core.sole_writer import sole_writer

with sole_writer(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def refused(folder):
    with pytest.raises(ConfigError, match="another command is writing there"), sole_writer(folder):
        pass


def test_one_at_a_time_and_nothing_is_left(tmp_path):
    folder = tmp_path / "new" / "run"
    with sole_writer(folder):
        refused(folder)
        with sole_writer(tmp_path / "new" / "other"):
            pass
    with pytest.raises(KeyError), sole_writer(folder):
        raise KeyError
    with sole_writer(folder):
        assert not any(folder.iterdir())


def test_a_killed_process_lets_go(tmp_path):
    other = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert other.stdout.readline() == "held\n"
    refused(tmp_path)
    other.kill()
    other.communicate()
    with sole_writer(tmp_path):
        pass


def test_what_cannot_be_a_folder_is_left_to_the_writer(tmp_path):
    (tmp_path / "file").write_text("mine")
    with sole_writer(tmp_path / "file"), sole_writer(tmp_path / "file" / "run"):
        assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.slow
def test_commands_refuse_a_folder_in_use(tmp_path):
    with sole_writer(tmp_path):
        played = evaluate("agent=frontier", "habit_level=none", "limit=1", "progress=false", f"out={tmp_path}")
        trained = train(*SMALL, "training.steps=1", f"out={tmp_path}")
    for result in (played, trained):
        assert result.returncode == 2
        assert f"{tmp_path}: another command is writing there" in error_line(result)
    assert not any(tmp_path.iterdir())
