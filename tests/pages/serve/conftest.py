"""Servers of the pages: within a test, and listening for a browser."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("starlette", reason="the extra 'serve' is not installed")
pytest.importorskip("uvicorn", reason="the extra 'serve' is not installed")
import uvicorn
from starlette.testclient import TestClient

from ucon.habits import HabitDataset, book
from ucon.pages.serve.app import make_app
from ucon.pages.serve.desk import Desk
from ucon.pages.serve.server import listening

TOKEN, PORT = "a-token-of-tests", 8765


@pytest.fixture
def client(tmp_path: Path) -> Iterator[TestClient]:
    """A client of an application without a network; its paths begin after the token."""
    app = make_app(Desk(tmp_path / "out", (tmp_path,), book()), TOKEN, PORT)
    with TestClient(app, base_url=f"http://127.0.0.1:{PORT}/{TOKEN}") as asking:
        yield asking


@dataclass
class Served:
    """A listening server: its address and its output folder."""

    address: str
    out: Path


class Listening:
    """Starts and stops servers."""

    def __init__(self) -> None:
        self._running: list[tuple[uvicorn.Server, threading.Thread]] = []

    def start(self, out: Path, folders: tuple[Path, ...] = (), dataset: HabitDataset | None = None) -> Served:
        opened = listening(0)
        port = opened.getsockname()[1]
        app = make_app(Desk(out, folders or (out,), dataset or book()), TOKEN, port)
        server = uvicorn.Server(
            uvicorn.Config(app, log_level="warning", access_log=False, ws="none", timeout_graceful_shutdown=1)
        )
        thread = threading.Thread(target=server.run, kwargs={"sockets": [opened]}, daemon=True)
        thread.start()
        until = time.monotonic() + 30
        while not server.started:
            assert thread.is_alive(), "the server did not start"
            assert time.monotonic() < until, "the server takes too long to start"
            time.sleep(0.01)
        self._running.append((server, thread))
        return Served(f"http://127.0.0.1:{port}/{TOKEN}/", out)

    def stop(self) -> None:
        for server, thread in self._running:
            server.should_exit = True
            thread.join(20)
        self._running.clear()


@pytest.fixture
def listener() -> Iterator[Listening]:
    """Starts servers that are stopped at the end of the test."""
    found = Listening()
    yield found
    found.stop()


@pytest.fixture
def served(listener: Listening, tmp_path: Path) -> Served:
    """A server with the habit book and no runs yet."""
    return listener.start(tmp_path / "out", (tmp_path,))


def seen(page: Any, selector: str) -> str:
    """Text of an element, once it appears."""
    page.wait_for_selector(selector)
    return str(page.inner_text(selector))
