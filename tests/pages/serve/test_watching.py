"""An evaluation ends in the same bytes whether or not it is watched or filmed."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2 as httpx
import pytest

from tests.pages.serve.conftest import Listening
from ucon.evaluation.kept.seal import DECISIONS, RECORDS
from ucon.programs.composing import eval_config
from ucon.programs.evaluating import Evaluation

ROOT = Path(__file__).parents[3]
WORDS = ("episodes=mini", "progress=false")


class Viewer(threading.Thread):
    """Repeatedly requests a server's page Runs, the list of runs and each run, until stopped.

    ``seen``: numbers of finished episodes that it was shown for runs still being played.
    """

    def __init__(self, address: str) -> None:
        super().__init__(daemon=True)
        self._address, self._over = address, threading.Event()
        self.seen: set[int] = set()
        self.asked, self.problem = 0, ""

    def run(self) -> None:
        try:
            with httpx.Client(base_url=self._address, timeout=60) as client:
                while not self._over.is_set():
                    client.get("runs").raise_for_status()
                    for run in client.get("api/runs/list").raise_for_status().json()["runs"]:
                        one = client.get("api/runs/one", params={"run": run["id"]})
                        self.asked += 1
                        if one.status_code == 200 and not one.json()["finished"]:  # else the run ended in between
                            self.seen.add(one.json()["done"])
                    time.sleep(0.02)
        except Exception as error:
            self.problem = repr(error)

    def wait_for_one(self) -> None:
        """Wait until a finished episode of an unfinished run was shown."""
        until = time.monotonic() + 60
        while not any(self.seen) and self.is_alive() and time.monotonic() < until:
            time.sleep(0.01)

    def stop(self) -> None:
        self._over.set()
        self.join(60)


@contextmanager
def watched(listener: Listening, folder: Path) -> Iterator[Viewer]:
    """Context manager: a viewer that constantly reads the runs of a folder."""
    folder.mkdir()
    viewer = Viewer(listener.start(folder).address)
    viewer.start()
    try:
        yield viewer
    finally:
        viewer.stop()
    assert not viewer.problem
    assert any(viewer.seen), "nothing was shown while it was played"
    assert viewer.asked > 2


def content(folder: Path) -> list[bytes]:
    return [(folder / name).read_bytes() for name in (RECORDS, DECISIONS)]


def test_neither_viewer_nor_films_change_a_record(listener: Listening, tmp_path: Path) -> None:
    def played(name: str, *words: str, viewer: Viewer | None = None) -> list[bytes]:
        out = tmp_path / name / "run"
        config = eval_config("agent=frontier", "limit=3", "workers=0", f"out={out}", *WORDS, *words)
        Evaluation(config, out).play(None if viewer is None else lambda _: viewer.wait_for_one())
        return content(out)

    alone = played("alone", "pictures=0")
    assert alone[0].count(b"\n") == 3
    with watched(listener, tmp_path / "watched") as viewer:
        assert played("watched", "pictures=0", viewer=viewer) == alone
    with watched(listener, tmp_path / "filmed") as viewer:
        assert played("filmed", "pictures=1", viewer=viewer) == alone
    assert not (tmp_path / "watched" / "run" / "pictures").exists()
    assert [*(tmp_path / "filmed" / "run" / "pictures").glob("*.webm")]


@pytest.mark.slow
def test_the_command_with_workers_is_changed_by_nobody_who_watches(listener: Listening, tmp_path: Path) -> None:
    """``eval.py`` with ``belief`` and two workers, each time in a separate process."""

    def played(name: str, pictures: int) -> list[bytes]:
        out = tmp_path / name / "run"
        told = ("agent=belief", "habit_level=retrieval", "limit=12", "workers=2", f"pictures={pictures}", f"out={out}")
        command = [sys.executable, "eval.py", *told, *WORDS]
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr[-2000:]
        return content(out)

    alone = played("alone", 0)
    assert alone[0].count(b"\n") == 12
    for name, pictures in (("watched", 0), ("filmed", 2)):
        with watched(listener, tmp_path / name):
            assert played(name, pictures) == alone
