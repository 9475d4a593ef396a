"""``python -m ucon watch``: episodes of a finished run are listed, and any of them filmed."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import pytest

from ucon.__main__ import main
from ucon.commands.watch import _decision_lines, _habit_lines
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.record import read_records
from ucon.evaluation.playing.recorded import RecordedAgent
from ucon.programs.composing import eval_config
from ucon.programs.evaluating import Evaluation
from ucon.programs.two_searches import search_twice
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
    assert "\nhabits: the agent reads none\nworth: the agent's estimate" in told
    assert ("\nnot found: " in told) == (not record.success)
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


def test_the_numbers_of_computed_choices_are_explained_and_even() -> None:
    made = [
        DecisionRecord("e", 0, 0, "frontier", ("a",), 0, text="worth 0.0434, 1 action away, score 0.051"),
        DecisionRecord(
            "e", 1, 4, "landmark", ("b",), 0, text="belief 21.9%, worth 3e-05, 6 actions away, score 1.25, x"
        ),
        DecisionRecord("e", 2, 9, "frontier", ("c",), 0, asked=1, text="worth 0.5, 1 action away, score 1"),
    ]
    legend, *lines = _decision_lines(made)
    assert all(f"{word}: " in legend for word in ("worth", "score", "belief"))
    assert [line.split("  ")[-1].strip() for line in lines] == [
        "worth 0.0434, 1 action away, score 0.0510",
        "belief 21.9%, worth 0.0000, 6 actions away, score 1.2500, x",
        "worth 0.5, 1 action away, score 1",
    ]
    assert [*_decision_lines(made[2:])] == lines[2:], "a model's answer stays as it is"


def test_the_habits_that_the_agent_reads_most_from_are_shown(tmp_path: Path) -> None:
    config = eval_config("agent=belief", "habit_level=retrieval", "episodes=mini", "limit=1", f"out={tmp_path}")
    run = Evaluation(config, tmp_path)
    given = run.given(run.episodes[0])
    assert given is not None
    first, *lines = _habit_lines(run, config["agent"], 0, reads=True)
    assert first == ("habits: 20 retrieved; those the agent reads most from, and how much each says about the place:")
    found = [re.fullmatch(r'  number +(\d+) +(\d+)%  "(.*)"', line) for line in lines]
    rows = [(int(row[1]), int(row[2]), row[3]) for row in found if row]
    assert len(rows) == 5
    assert [share for _, share, _ in rows] == sorted((share for _, share, _ in rows), reverse=True)
    assert all(given[number - 1] == text for number, _, text in rows)
    first, *lines = _habit_lines(run, {"_target_": "models.agents.random.RandomAgent"}, 0, reads=True)
    assert first == "habits: 20 retrieved; the first:"
    assert lines == [f'  number {k:>3}  "{text}"' for k, text in enumerate(given[:5], 1)]
    assert [*_habit_lines(run, config["agent"], 0, reads=False)] == ["habits: the agent reads none"]


@pytest.mark.parametrize("words", [["watch"], ["compare", "results/learned-frontier", "results/belief-none"]])
def test_runs_that_keep_figures_only_say_how_they_are_played(
    words: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(__file__).parents[2])
    assert main([*words, "results/belief-gt"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    names = ["belief-none", "belief-gt"] if words[0] == "compare" else ["belief-gt"]
    folders = " ".join(f"results/{name}" for name in names)
    assert line == (
        f"error: {folders}: keeps only figures, no episodes; run `python -m ucon replay {folders}`, "
        f"then give {' '.join(f'runs/replay/{name}' for name in names)}"
    )
