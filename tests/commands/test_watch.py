"""``python -m ucon watch``: any episode of a finished run, listed and filmed."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import pytest

from ucon.__main__ import main
from ucon.commands.two_searches import search_twice
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.record import read_records
from ucon.evaluation.playing.recorded import RecordedAgent
from ucon.task.actions import Action
from ucon.task.sets import load_episodes
from ucon.task.spoken import target_place


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three episodes of ``frontier``."""
    out = tmp_path_factory.mktemp("run")
    words = ("agent=frontier", "episodes=mini", "limit=3")
    return search_twice(words, out, ["none"], films=False)[0].folder


def test_episodes_are_listed_with_how_they_ended(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["watch", str(run)]) == 0
    lines = capsys.readouterr().out.splitlines()
    records = read_records(run)
    for number, (line, record) in enumerate(zip(lines[1:-1], records, strict=True)):
        assert line.split()[:4] == [str(number), record.episode, record.target, "yes" if record.success else "no"]
    assert lines[-1].startswith("3 of 3 episodes")
    assert main(["watch", str(run), "--lost"]) == 0
    lost = sum(not record.success for record in records)
    assert capsys.readouterr().out.splitlines()[-1].startswith(f"{lost} of 3 episodes")


@pytest.mark.parametrize("words", [[], ["--actions"]], ids=["agent", "actions"])
def test_an_episode_is_filmed_step_by_step(
    words: list[str], run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = read_records(run)[1]
    assert main(["watch", str(run), record.episode, *words, "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    ending = "found" if record.success else f"not found ({record.failure_cause.replace('_', ' ')})"
    (episode,) = (e for e in load_episodes("mini") if e.id == record.episode)
    place = target_place(episode)
    target = record.target.replace("_", " ")
    assert f"{record.episode}: {target} {place}, {ending} after {record.steps} steps\n" in told
    made = FinishedRun.read(run).decisions()[record.episode]
    assert len(made) > 3
    assert re.findall(r"^  step +(\d+)  (.*?)  ", told, re.MULTILINE) == [(str(d.step), d.words) for d in made]
    (film,) = tmp_path.glob("001_*.webm")
    video, frames = cv2.VideoCapture(str(film)), 0
    while video.read()[0]:
        frames += 1
    assert frames > record.steps


@pytest.mark.parametrize("word", ["3", "-1", "nothing"])
def test_what_is_no_episode_of_the_run(word: str, run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["watch", str(run), "--", word]) == 2
    assert f"EPISODE {word}: expected a number from 0 to 2" in capsys.readouterr().err


def test_recorded_actions_end_in_done() -> None:
    agent = RecordedAgent("02")
    for _ in range(2):
        agent.reset([None])
        assert [agent.act([None], [None]) for _ in range(4)] == [[0], [2], [Action.DONE], [Action.DONE]]


def test_a_folder_of_several_runs_names_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("none", "retrieval"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "summary.json").write_text("{}")
    assert main(["watch", str(tmp_path)]) == 2
    assert capsys.readouterr().err.endswith("such as one in it: none, retrieval\n")
