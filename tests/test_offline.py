"""No network at run time: a whole evaluation where there is none."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def isolated(command: str) -> list[str]:
    """The command in a network namespace of its own, with only a loopback."""
    return ["unshare", "-rn", "sh", "-c", f"ip link set lo up; {command}"]


@pytest.fixture(scope="module")
def no_network():
    if not shutil.which("unshare") or not shutil.which("ip"):
        pytest.skip("unshare or ip is not installed")
    if subprocess.run(isolated("true"), capture_output=True).returncode:
        pytest.skip("network namespaces are not permitted here")


def test_the_namespace_has_no_network(no_network):
    probe = "import socket; socket.create_connection(('192.0.2.1', 80), timeout=2)"
    assert subprocess.run(isolated(f'{sys.executable} -c "{probe}"'), capture_output=True).returncode != 0


def test_evaluation_without_network(no_network, tmp_path):
    command = (
        f"{sys.executable} eval.py agent=belief habit_level=retrieval episodes=mini limit=2 pictures=0 "
        f"progress=false out={tmp_path}/run"
    )
    environment = os.environ | {"HF_HUB_OFFLINE": "1"}
    result = subprocess.run(isolated(command), cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr[-2000:]
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["n"] == 2
