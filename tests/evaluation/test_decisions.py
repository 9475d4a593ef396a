"""Choices on disk: the same bytes however the run was played, kept across interruptions, and their figures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from models.agents.lgx import LGXAgent
from tests.evaluation.records import played as made_up
from ucon.core.errors import DataError
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.figures.report import summary
from ucon.evaluation.kept.decisions import DecisionRecord, language_figures, seconds_per_decision
from ucon.evaluation.kept.folder import DECISIONS, PARTIAL, TIMING, RunFolder
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.language.models.encoder import EncoderModel
from ucon.task.sets import load_episodes

HASHES = {"config": "c", "episodes": "e", "habits": "h", "code": "v", "weights": "w"}
EPISODES = load_episodes("mini")[::12]


def lgx() -> LGXAgent:
    return LGXAgent(EncoderModel())


def run(workers: int, batch: int, skip: tuple[int, ...] = ()) -> list[PlayedEpisode]:
    env = partial(UcONEnv, EPISODES[:1], observe="symbolic", detector=True, habit_level="retrieval")
    return evaluate(RunSpec(lgx, env, "retrieval", batch=batch), EPISODES, workers=workers, skip=skip)


@pytest.fixture(scope="module")
def played() -> list[PlayedEpisode]:
    return run(0, 1)


def finished(path: Path, played: list[PlayedEpisode]) -> RunFolder:
    folder = RunFolder(path, HASHES)
    folder.open(ids(played))
    for one in played:
        folder.add(one)
    folder.finish(played, summary(played, HASHES), "x: 1\n")
    return folder


def ids(played: Sequence[PlayedEpisode]) -> list[str]:
    return [one.record.episode for one in played]


@pytest.mark.parametrize(("workers", "batch"), [(0, 3), (2, 1)])
def test_one_line_a_choice_whatever_workers_and_batch(
    workers: int, batch: int, played: list[PlayedEpisode], tmp_path: Path
) -> None:
    finished(tmp_path / "a", played)
    finished(tmp_path / "b", run(workers, batch))
    text = (tmp_path / "a" / DECISIONS).read_bytes()
    assert (tmp_path / "b" / DECISIONS).read_bytes() == text
    lines = [json.loads(line) for line in text.decode().split("\n")[:-1]]
    assert [(line["episode"], line["number"]) for line in lines] == [
        (p.record.episode, k) for p in played for k in range(len(p.decisions))
    ]
    assert "seconds" not in lines[0]
    assert len(lines) == summary(played, HASHES)["language"]["decisions"]


def test_an_interrupted_run_keeps_the_choices_of_what_was_finished(played: list[PlayedEpisode], tmp_path: Path) -> None:
    first = RunFolder(tmp_path / "cut", HASHES)
    first.open(ids(played))
    for one in (played[2], played[0]):
        first.add(one)
    partial_file = tmp_path / "cut" / PARTIAL
    partial_file.write_text(partial_file.read_text() + '{"index": 1, "record"')  # cut off while being written
    again = RunFolder(tmp_path / "cut", HASHES)
    done = again.open(ids(played))
    assert done == {k: played[k] for k in (0, 2)}
    new = run(0, 1, skip=tuple(done))
    for one in new:
        again.add(one)
    whole = sorted([*done.values(), *new], key=lambda p: p.index)
    again.finish(whole, summary(whole, HASHES), "x: 1\n")
    finished(tmp_path / "whole", played)
    assert (tmp_path / "cut" / DECISIONS).read_bytes() == (tmp_path / "whole" / DECISIONS).read_bytes()


def test_a_finished_run_is_read_back(played: list[PlayedEpisode], tmp_path: Path) -> None:
    finished(tmp_path, played)
    assert RunFolder(tmp_path, HASHES).open(ids(played)) == dict(enumerate(played))


def test_what_a_model_said_cannot_break_the_file(tmp_path: Path) -> None:
    said = 'a\nb\u2028c\x85d\ud800"{}\x00'
    decision = DecisionRecord("e0", 0, 3, "view", ("front", "left"), 1, asked=1, text=said)
    one = replace(made_up(0), decisions=(decision, replace(decision, number=1)))
    one = replace(one, timing=replace(one.timing, decision_seconds=(0.5, 0.25)))
    folder = RunFolder(tmp_path, HASHES)
    folder.open(["e0"])
    folder.add(one)
    resumed = RunFolder(tmp_path, HASHES).open(["e0"])[0]
    assert [d.to_line() for d in resumed.decisions] == [d.to_line() for d in one.decisions]
    assert [d.seconds for d in resumed.decisions] == [0.5, 0.25]
    assert resumed.timing == one.timing


@pytest.mark.parametrize("name", [DECISIONS, TIMING])
@pytest.mark.parametrize("damage", ["cut", "lost line", "not JSON", "other fields", "list"])
def test_a_damaged_folder_is_named_in_one_line(
    name: str, damage: str, played: list[PlayedEpisode], tmp_path: Path
) -> None:
    finished(tmp_path, played)
    file = tmp_path / name
    lines = file.read_text().splitlines(keepends=True)
    file.write_text(
        {
            "cut": "".join(lines)[:-20],
            "lost line": "".join(lines[:-1]),
            "not JSON": "".join(["hello\n", *lines[1:]]),
            "other fields": "".join(['{"episode": "x", "what": 1}\n', *lines[1:]]),
            "list": "".join(["[1]\n", *lines[1:]]),
        }[damage]
    )
    with pytest.raises(DataError, match=name.replace(".", r"\.")) as caught:
        RunFolder(tmp_path, HASHES).open(ids(played))
    assert "\n" not in str(caught.value)
    assert "evaluate again" in str(caught.value)


def test_figures_of_a_run() -> None:
    asked = DecisionRecord(
        "e0",
        0,
        3,
        "view",
        ("front", "left"),
        1,
        asked=2,
        retries=1,
        dropped=3,
        prompt_tokens=90,
        completion_tokens=10,
        seconds=2.0,
    )
    lost = replace(
        asked, number=1, fallback=True, failure="server", dropped=0, prompt_tokens=10, retries=3, seconds=4.0
    )
    alone = DecisionRecord("e1", 0, 3, "wander", ("0",), 0)
    assert language_figures([asked, lost, alone], 2) == {
        "decisions": 3,
        "decisions_per_episode": 1.5,
        "questions_per_episode": 2.0,
        "fallback_rate": 0.5,
        "failures": {"server": 1},
        "dropped_rate": 0.5,
        "dropped_per_decision": 1.5,
        "retries": 4,
        "prompt_tokens_per_decision": 50.0,
        "completion_tokens_per_decision": 10.0,
    }
    assert seconds_per_decision([asked, lost, alone]) == 3.0
    assert seconds_per_decision([alone]) is None
    assert language_figures([alone], 1) is None
    assert language_figures([], 0) is None


def test_a_run_without_choices_has_no_file(tmp_path: Path) -> None:
    finished(tmp_path, [made_up(0)])
    assert not (tmp_path / DECISIONS).exists()
    assert RunFolder(tmp_path, HASHES).open(["e0"]) == {0: made_up(0)}


def asked(**changes: object) -> DecisionRecord:
    base = DecisionRecord("e0", 0, 0, "frontier", ("a", "b"), 0, (0.5, 0.5))
    return replace(base, **changes)  # type: ignore[arg-type]


def test_figures_of_choices_by_hand() -> None:
    """Two episodes with four choices; two of them asked three questions in all, and one of the two got no answer."""
    decisions = [
        asked(),
        asked(asked=1, prompt_tokens=10, completion_tokens=2, seconds=0.5),
        asked(asked=2, dropped=3, retries=1, fallback=True, failure="timeout", prompt_tokens=20, seconds=1.0),
        asked(),
    ]
    assert language_figures(decisions, 2) == {
        "decisions": 4,
        "decisions_per_episode": 2.0,
        "questions_per_episode": 1.5,
        "fallback_rate": 0.5,
        "failures": {"timeout": 1},
        "dropped_rate": 0.5,
        "dropped_per_decision": 1.5,
        "retries": 1,
        "prompt_tokens_per_decision": 15.0,
        "completion_tokens_per_decision": 1.0,
    }
    assert seconds_per_decision(decisions) == 0.75


def test_without_questions_or_episodes_there_are_no_figures() -> None:
    assert language_figures([asked()], 3) is None
    assert language_figures([asked(asked=1)], 0) is None
    assert language_figures([], 3) is None
