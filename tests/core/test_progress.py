"""Progress: a bar on a terminal; elsewhere a few plain lines, each with the time left."""

from __future__ import annotations

import os
import pty
import subprocess
import sys

import pytest

from tests.evaluation.records import played
from ucon.core import progress
from ucon.core.progress import Progress, duration, part
from ucon.evaluation.playing.progress_bar import EvaluationProgress, embedding_progress

SHORT = """
from ucon.core.progress import Progress
with Progress("short", 3, unit="things") as bar:
    bar.update(1)
    bar.update(3, "all well")
"""


class Clock:
    """A clock in seconds that the test sets."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    lines = progress._Lines
    monkeypatch.setattr(progress, "_Lines", lambda *told: lines(*told, clock=made))
    return made


def test_a_line_is_due_after_ten_per_cent_or_half_a_minute(clock: Clock, capsys: pytest.CaptureFixture[str]) -> None:
    with Progress("x", 100, unit="episodes") as bar:
        for done in range(1, 41):
            clock.now += 1.0
            bar.update(done, f"SR {done} %")
        clock.now += 31.0
        bar.update(41)
        for done in range(42, 101):
            clock.now += 0.01
            bar.update(done)
    assert capsys.readouterr().err.splitlines() == [
        "x: 0 of 100 episodes",
        "x: 10 of 100 episodes, 1.0 a second, 2 min left, SR 10 %",
        "x: 20 of 100 episodes, 1.0 a second, 80 s left, SR 20 %",
        "x: 30 of 100 episodes, 1.0 a second, 70 s left, SR 30 %",
        "x: 40 of 100 episodes, 1.0 a second, 60 s left, SR 40 %",
        "x: 41 of 100 episodes, 34.6 a minute, 2 min left, SR 40 %",
        "x: 100 of 100 episodes, 1.4 a second, in 72 s, SR 40 %",
    ]


def test_what_was_done_before_does_not_count_for_the_rate(clock: Clock, capsys: pytest.CaptureFixture[str]) -> None:
    with Progress("x", 100, done=50) as bar:
        clock.now += 10.0
        bar.update(60)
    assert "60 of 100, 1.0 a second, 40 s left" in capsys.readouterr().err


def test_a_long_part_is_told_every_half_minute(clock: Clock, capsys: pytest.CaptureFixture[str]) -> None:
    with Progress("ppo", 4, unit="steps") as bar:
        with part("collecting", 100) as tick:
            for done in range(1, 101):
                clock.now += 1.0
                tick(done)
        bar.update(1)
        with part("updating"):
            clock.now += 29.0
    assert capsys.readouterr().err.splitlines() == [
        "ppo: 0 of 4 steps",
        "ppo: 0 of 4 steps, collecting 30 of 100 (70 s left)",
        "ppo: 0 of 4 steps, collecting 60 of 100 (40 s left)",
        "ppo: 0 of 4 steps, collecting 90 of 100 (10 s left)",
        "ppo: 1 of 4 steps, 0.6 a minute, 5 min left",
    ]


def test_a_part_of_nothing_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with part("collecting", 3) as tick:
        tick(1)
    with Progress("x", 3, visible=False) as bar, part("collecting", 3) as tick:
        tick(1)
        bar.update(3)
    assert capsys.readouterr().err == ""


def test_an_evaluation_says_how_well_it_goes(capsys: pytest.CaptureFixture[str]) -> None:
    with EvaluationProgress("belief none", 3, done=[played(0)]) as bar:
        bar.add(played(1, success=False))
    first, last = capsys.readouterr().err.splitlines()
    assert first == "belief none: 1 of 3 episodes, SR 100 % SPL 0.50"
    assert last.startswith("belief none: 2 of 3 episodes, ")
    assert last.endswith(", SR 50 % SPL 0.25")


def test_nothing_is_said_of_texts_where_all_are_known(capsys: pytest.CaptureFixture[str]) -> None:
    with embedding_progress():
        pass
    assert capsys.readouterr().err == ""
    with embedding_progress() as on_text:
        on_text(5, 5)
    assert capsys.readouterr().err.startswith("embedding habits, once: 0 of 5 texts\n")


def test_no_control_codes_where_output_is_no_terminal() -> None:
    env = os.environ | {"FORCE_COLOR": "1", "TERM": "xterm-256color"}
    done = subprocess.run([sys.executable, "-c", SHORT], env=env, capture_output=True, text=True, check=True)
    assert done.stdout == ""
    first, last = done.stderr.splitlines()
    assert first == "short: 0 of 3 things"
    assert last.startswith("short: 3 of 3 things, ")
    assert last.endswith(", all well")
    assert "\x1b" not in done.stderr
    assert "\r" not in done.stderr


def test_a_bar_at_a_terminal() -> None:
    parent, child = pty.openpty()
    env = os.environ | {"TERM": "xterm-256color", "COLUMNS": "120"}
    process = subprocess.Popen([sys.executable, "-c", SHORT], env=env, stderr=child)
    os.close(child)
    said = b""
    while True:
        try:
            piece = os.read(parent, 4096)
        except OSError:
            break
        if not piece:
            break
        said += piece
    assert process.wait() == 0
    assert b"\x1b[" in said
    assert b"3/3" in said
    assert b"all well" in said


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.4, "0 s"), (61, "61 s"), (95, "2 min"), (3 * 3600 + 240, "3 h 04 min")]
)
def test_durations(seconds: float, said: str) -> None:
    assert duration(seconds) == said
