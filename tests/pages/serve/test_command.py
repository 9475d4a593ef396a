"""``python -m ucon serve`` as a program: killed, stopped, started twice; errors in one line."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2 as httpx
import pytest

from tests.pages.serve import conftest  # noqa: F401 (skips where the extra is missing)
from ucon.__main__ import main
from ucon.task.sets import load_episodes

ROOT = Path(__file__).parents[3]


def command(out: Path) -> list[str]:
    """The command that serves a folder."""
    return [sys.executable, "-m", "ucon", "serve", "--port", "0", "--no-browser", "--out", str(out)]


@contextlib.contextmanager
def running(out: Path) -> Iterator[tuple[subprocess.Popen[str], httpx.Client]]:
    """Run the command, with a client; it is killed at the end if it still runs."""
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(
        command(out), cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    address = process.stdout.readline().strip()
    assert address.startswith("http://127.0.0.1:"), process.communicate()
    try:
        with httpx.Client(base_url=address, timeout=60) as client:
            yield process, client
    finally:
        process.kill()
        process.communicate()


def test_what_was_done_survives_a_kill_and_ctrl_c_ends_it(tmp_path: Path) -> None:
    episode = load_episodes("mini")[0]
    out, ann = tmp_path / "out", {"player": "ann", "level": "none", "episodes": "mini", "n": 1, "picture_px": 128}
    said = {"study": "s", "rater": "ann", "item": 2, "real": 4, "look": "unsure"}

    def act(client: httpx.Client, state: dict[str, Any], actions: str) -> dict[str, Any]:
        for digit in actions:
            view = state["view"]
            sent = {"game": "ann/mini-none-1", "episode": view["episode"], "step": view["step"], "action": int(digit)}
            state = client.post("api/play/act", json=sent).json()
        return state

    with running(out) as (process, client):
        state = client.post("api/play/begin", json=ann).json()["state"]
        act(client, state, episode.solution[:5])
        client.post("api/study/make", json={"study": "s", "n": 4, "seed": 0}).raise_for_status()
        client.post("api/study/answer", json=said).raise_for_status()
        second = subprocess.run(command(out), cwd=ROOT, capture_output=True, timeout=60)
        assert second.returncode == 2  # one server per folder
        process.send_signal(signal.SIGKILL)
        process.wait(20)
    with running(out) as (process, client):
        items = client.get("api/study/items", params={"study": "s", "rater": "ann"}).json()
        assert items["answers"] == {"2": [4, "unsure"]}
        state = client.post("api/play/begin", json=ann).json()["state"]
        assert state["view"]["step"] == 5
        state = act(client, state, episode.solution[5:-1])
        process.send_signal(signal.SIGINT)
        told, wrong = process.communicate(timeout=30)
        assert process.returncode == 0, wrong
        assert told.endswith("ended; the same command continues\n")
        assert wrong == ""
    assert (out / "play/ann/mini-none-1/journal.jsonl").read_text().count("\n") == len(episode.solution) - 1


def told(capsys: Any, *words: str) -> str:
    """The error line of a command that ends with 2."""
    assert main(["serve", "--no-browser", *words]) == 2
    said = str(capsys.readouterr().err)
    assert said.count("\n") == 1
    return said


def test_errors_are_one_line(capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert f"--port {port}: taken by another program" in told(capsys, "--port", port)
    assert "--port 70000: expected 0 to 65535" in told(capsys, "--port", "70000")
    assert "--out file: a file, expected a folder" in told(capsys, "--out", "file")
    assert "nowhere: no such folder" in told(capsys, "nowhere")
    assert "no-habits" in told(capsys, "--habits", "no-habits")
    (tmp_path / "home.yaml").write_text("rooms:\n  kitchen: {furniture: {frigde: 1}}\n")
    assert "home.yaml:2: unknown furniture 'frigde'" in told(capsys, "--home", "home.yaml")
    assert "gone.yaml: cannot be read" in told(capsys, "--home", "gone.yaml")
    there = importlib.util.find_spec
    monkeypatch.setattr(
        "ucon.commands.serve.find_spec", lambda name: None if name in ("starlette", "uvicorn") else there(name)
    )
    assert "pip install 'ucon-nav[serve]'" in told(capsys)
