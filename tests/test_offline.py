"""No network at run time: no request to another machine, and commands work without a network."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
WATCH = ROOT / "tests" / "network_watch"
#: A training run of two steps.
TRAINED = (
    "train.py learner=retriever learner.rank=2 learner.n_kbs=1 training.steps=2 training.validate_every=1 "
    "progress=false out={out}/run"
)
#: Retrieval with a query and a sentence that are in no shipped table of vectors.
NEW_QUERY = """-c "
from ucon.language.store import default_encoder
from ucon.retrieval import DenseRetriever
from ucon.habits import KnowledgeBase, book
encoder = default_encoder()
base = KnowledgeBase.build(book(), {{'mug': book().entries_of('mug')[:2]}}, seed=0)
first = DenseRetriever(encoder).rank('left handed {out} teapot', base)[0]
encoder.encode_half(['Nobody wrote about {out} before.'])
print(book().texts[first])
" """


def isolated(command: str) -> list[str]:
    """The command in its own network namespace, with only a loopback interface."""
    return ["unshare", "-rn", "sh", "-c", f"ip link set lo up; {command}"]


def watched(log: Path) -> dict[str, str]:
    """The environment in which every Python process logs its attempts to reach other machines."""
    path = os.pathsep.join(filter(None, [str(WATCH), str(ROOT), os.environ.get("PYTHONPATH", "")]))
    return os.environ | {"HF_HUB_OFFLINE": "1", "UCON_NETWORK_LOG": str(log), "PYTHONPATH": path}


@pytest.fixture(scope="module")
def no_network():
    if not shutil.which("unshare") or not shutil.which("ip"):
        pytest.skip("unshare or ip is not installed")
    if subprocess.run(isolated("true"), capture_output=True).returncode:
        pytest.skip("network namespaces are not permitted here")


def test_the_namespace_has_no_network(no_network):
    probe = "import socket; socket.create_connection(('192.0.2.1', 80), timeout=2)"
    assert subprocess.run(isolated(f'{sys.executable} -c "{probe}"'), capture_output=True).returncode != 0


@pytest.mark.parametrize(
    ("asked", "attempts"),
    [
        ("s.connect(('192.0.2.1', 80))", ["socket.connect"]),
        ("s.connect_ex(('192.0.2.1', 80))", ["socket.connect"]),
        ("socket.create_connection(('2001:db8::1', 80), 0.1)", ["socket.getaddrinfo", "socket.connect"]),
        ("socket.getaddrinfo('nowhere.invalid', 443)", ["socket.getaddrinfo"]),
        ("socket.socket(type=socket.SOCK_DGRAM).sendto(b'', ('192.0.2.1', 9))", ["socket.sendto"]),
        (
            "subprocess.run([sys.executable, '-c', 'import socket; socket.gethostbyname(\"a.invalid\")'])",
            ["socket.geth"],
        ),
        ("s.connect(('127.0.0.1', 9))", []),
        ("socket.create_connection(('localhost', 9))", []),
        ("socket.create_connection(('::1', 9))", []),
        ("socket.getaddrinfo(None, 80)", []),
        ("socket.socket(socket.AF_UNIX).connect('/nowhere')", []),
    ],
)
def test_the_watch_sees_what_is_asked_of_other_machines(no_network, tmp_path, asked, attempts):
    """Without this, the tests below could not fail."""
    (tmp_path / "asks.py").write_text(f"import socket, subprocess, sys\ns = socket.socket()\n{asked}\n")
    subprocess.run(
        isolated(f"{sys.executable} {tmp_path}/asks.py"), env=watched(tmp_path / "log"), capture_output=True, timeout=60
    )
    log = (tmp_path / "log").read_text().splitlines() if attempts else []
    assert (tmp_path / "log").exists() == bool(attempts)
    assert len(log) == len(attempts)
    assert all(line.startswith(event) for line, event in zip(log, attempts, strict=True))


def test_evaluation_without_network(no_network, tmp_path):
    command = (
        f"{sys.executable} eval.py agent=belief habit_level=retrieval episodes=mini limit=2 pictures=0 "
        f"progress=false out={tmp_path}/run"
    )
    result = subprocess.run(
        isolated(command), cwd=ROOT, env=watched(tmp_path / "log"), capture_output=True, text=True, timeout=300
    )
    assert result.returncode == 0, result.stderr[-2000:]
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["n"] == 2
    assert not (tmp_path / "log").exists(), (tmp_path / "log").read_text()


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(NEW_QUERY, marks=pytest.mark.slow),
        pytest.param(TRAINED, marks=pytest.mark.slow),
        pytest.param("-m ucon demo --no-video --out {out}/demo", marks=pytest.mark.slow),
        pytest.param(
            "eval.py agent=lgx habit_level=context episodes=mini limit=4 workers=2 pictures=1 progress=false "
            "out={out}/run",
            marks=pytest.mark.slow,
        ),
    ],
    ids=["new query", "train.py", "demo", "eval.py with workers and films"],
)
def test_no_command_asks_another_machine(no_network, tmp_path, command):
    result = subprocess.run(
        isolated(f"{sys.executable} {command.format(out=tmp_path)}"),
        cwd=ROOT,
        env=watched(tmp_path / "log"),
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert result.returncode == 0, result.stderr[-2000:]
    assert not (tmp_path / "log").exists(), (tmp_path / "log").read_text()
