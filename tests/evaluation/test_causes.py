"""Causes by counterfactuals: what sentences are about, which count as causes, and the command that plays them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from omegaconf import OmegaConf

from tests.evaluation.records import record
from tests.models.playing import config_of
from ucon.__main__ import main
from ucon.core.errors import EpisodeError
from ucon.envs.knowledge import HabitSource
from ucon.envs.told.edits import Edits
from ucon.envs.told.falsehoods import place_now, things_of
from ucon.evaluation.causes.causes import NEAR_M, Tried, about, confirmed, counts, landmarks, strongest, tried
from ucon.evaluation.causes.changes import placed_elsewhere, renamed
from ucon.evaluation.causes.weighing import Weighed, moved, weighed
from ucon.evaluation.kept.record import read_records
from ucon.habits import book
from ucon.perception.belief.from_habits import ReadHabits
from ucon.perception.belief.target_belief import Locations
from ucon.task.sets import load_episodes

EPISODES = load_episodes("test")[:200]
SOURCE = HabitSource()


def one(number: int, with_it: tuple[bool, float], without: tuple[bool, float], **changes: Any) -> Tried:
    """A sentence of episode ``number``, with success and SPL when it is told and when it is not."""
    values = {
        "episode": f"e{number}", "scene": "Rs_int", "target": "mug", "habit": "h", "row": 0, "about": "target",
        "thing": "mug", "rank": 1, "weight": 0.5, "changes": True, "steps": (30, 40),
        "success": (with_it[0], without[0]), "spl": (with_it[1], without[1]),
    }  # fmt: skip
    return Tried(**(values | changes))


def test_what_sentences_are_about() -> None:
    """A sentence is about a thing beside the target only if the episode put that thing there."""
    dataset, kinds = book(), {}
    for episode in EPISODES:
        for row in SOURCE.knowledge(episode, "retrieval").rows.tolist():
            kind, entry = about(episode, dataset, row), dataset.entry_of(row)
            kinds[kind] = kinds.get(kind, 0) + 1
            if kind == "target":
                assert entry.category == episode.target_category
                continue
            at = [k for k, (name, _) in enumerate(episode.placed_by) if name == entry.id]
            gaps = [
                float(
                    np.linalg.norm(np.subtract(episode.arrangement.objects[k].position, episode.target_object.position))
                )
                for k in at
                if episode.placed_by[k][1] in dataset.habits[row].supports
            ]
            assert (kind == "beside") == any(gap <= NEAR_M for gap in gaps)
            anchors = {place.anchor for place in dataset.supports(row)}
            if kind != "beside":
                assert (kind == "anchor") == (place_now(dataset, episode).anchor in anchors)
    assert kinds.keys() == {"target", "beside", "anchor", "other"}
    assert not any(episode.placed_by[episode.target][0] in landmarks(episode) for episode in EPISODES)


def test_a_sentence_weighs_what_the_belief_moves_without_it() -> None:
    def locate(info: dict[str, Any]) -> Locations:
        """A probability of a tenth at ``a`` for each sentence that contains "a"."""
        share = 0.1 * sum("a" in habit for habit in info["habits"])
        return Locations(("a", "b"), np.array([[share, 0, 0, 0], [0.5, 0, 0, 0]]))

    found = weighed("mug", "retrieval", [7, 8, 9], ["nothing", "a", "a too"], locate)
    assert found == [Weighed(2, 8, "a", 0.1), Weighed(3, 9, "a too", 0.1)]
    whole = Locations(("a",), np.array([[1.0, 0, 0, 0]]))
    assert moved(whole, Locations(("b",), np.array([[1.0, 0, 0, 0]]))) == 1.0
    assert moved(whole, whole) == 0.0


def test_the_weightiest_sentence_of_the_shipped_reader_moves_its_belief_most() -> None:
    episode, locate = EPISODES[0], ReadHabits()
    given = SOURCE.knowledge(episode, "retrieval")
    found = weighed(episode.target_category, "retrieval", given.rows.tolist(), given.texts, locate)
    assert [w.weight for w in found] == sorted((w.weight for w in found), reverse=True)
    assert all(given.texts[w.rank - 1] == w.habit and given.rows[w.rank - 1] == w.row for w in found)
    assert found[0].weight > 0.01


def test_changed_sentences_are_elsewhere_in_this_home() -> None:
    dataset, changed, other_names = book(), 0, 0
    for episode in EPISODES[:60]:
        now = place_now(dataset, episode)
        for row in SOURCE.knowledge(episode, "retrieval").rows[:5].tolist():
            said = placed_elsewhere(dataset, episode, row)
            assert said == placed_elsewhere(dataset, episode, row)
            if said is not None:
                changed += 1
                numbers = [k for k, text in enumerate(dataset.texts) if text == said]
                assert any(dataset.entry_of(k).category == dataset.entry_of(row).category for k in numbers)
                anchors = {place.anchor for k in numbers for place in dataset.supports(k)}
                assert anchors & things_of(episode)
                assert now.anchor not in anchors
            text = renamed(dataset, episode, row)
            if text is not None:
                other_names += 1
                assert text != dataset.texts[row]
                start = len(common(text, dataset.texts[row]))
                end = len(common(text[::-1], dataset.texts[row][::-1]))
                assert start + end > 0.4 * min(len(text), len(dataset.texts[row])), "one name alone is another"
    assert changed > 30
    assert other_names > 30


def common(first: str, second: str) -> str:
    """The common beginning of two texts."""
    n = next((k for k, (a, b) in enumerate(zip(first, second, strict=False)) if a != b), min(len(first), len(second)))
    return first[:n]


def test_a_cause_changes_the_search_and_what_comes_of_it() -> None:
    helps, hurts = one(0, (True, 0.5), (False, 0.0)), one(0, (True, 0.2), (True, 0.6))
    assert (helps.is_cause, helps.helps, helps.hurts, helps.gain) == (True, True, False, (1, 0.5))
    assert (hurts.is_cause, hurts.helps, hurts.hurts, hurts.gain) == (True, False, True, (0, -0.4))
    assert not one(0, (True, 0.5), (True, 0.5)).is_cause
    assert not one(0, (True, 0.5), (False, 0.0), changes=False).is_cause
    assert strongest([hurts, helps])["e0"] is helps
    assert strongest([one(1, (False, 0.0), (False, 0.0))]) == {}


def test_confirmed_is_what_every_other_way_of_not_telling_it_says() -> None:
    helps, hurts = one(0, (True, 0.5), (False, 0.0)), one(0, (False, 0.0), (True, 0.5))
    worse, same = record(0, success=False), record(0, spl=0.5)
    assert confirmed(helps, [worse, worse])
    assert not confirmed(helps, [worse, same])
    assert confirmed(hurts, [same, same])
    assert not confirmed(hurts, [worse, same])


def test_counts_are_of_episodes_with_intervals() -> None:
    found = [
        one(0, (True, 0.5), (False, 0.0)),
        one(0, (True, 0.5), (True, 0.4), about="beside"),
        one(1, (False, 0.0), (True, 0.5)),
        one(2, (True, 0.5), (True, 0.5), changes=False),
    ]
    figures = counts(found, [f"e{k}" for k in range(10)], {"e0": True, "e1": False})
    whole = figures["any"]
    assert (whole["tried"], whole["changes_search"]) == (4, 3)
    assert (whole["helps"]["share"], whole["hurts"]["share"]) == (0.1, 0.1)
    assert whole["helps_less_hurts"]["share"] == 0.0
    assert whole["helps_less_hurts"]["ci95"][0] < 0 < whole["helps_less_hurts"]["ci95"][1]
    assert (whole["found_with_it_alone"], whole["lost_with_it_alone"]) == (1, 1)
    assert (whole["confirmed_helps"], whole["confirmed_hurts"]) == (
        {"confirmed": 1, "of": 1},
        {"confirmed": 0, "of": 1},
    )
    assert figures["beside"]["helps"]["share"] == 0.1
    assert figures["other"]["helps"]["ci95"][1] > 0.2, "none of ten says little"


def test_records_of_other_episodes_are_refused() -> None:
    episode = EPISODES[0]
    told = replace(record(0), episode=episode.id)
    habit = Weighed(1, 0, "h", 0.1)
    assert tried(episode, book(), habit, told, told).changes is False
    with pytest.raises(EpisodeError, match="compared with records of"):
        tried(episode, book(), habit, told, record(1))


def run_of(folder: Path, agent: str = "belief", *overrides: str) -> str:
    """The configuration of a run, as eval.py leaves it."""
    folder.mkdir()
    config = OmegaConf.create(config_of(agent, "episodes=mini", "limit=2", *overrides))
    (folder / "config.yaml").write_text(OmegaConf.to_yaml(config))
    return str(folder)


def test_the_command_plays_pairs_that_are_ordinary_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run, out = run_of(tmp_path / "run"), tmp_path / "out"
    command = ["cases", run, "--out", str(out), "--most", "2", "--about", "target", "--workers", "0"]
    assert main([*command, "--json"]) == 0
    *lines, last = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert len(lines) == 4
    assert (last["episodes"], last["told"], last["counts"]["target"]["tried"]) == (2, 40, 4)
    told = {r.episode: r for r in read_records(out / "told")}
    for number in (1, 2):
        without = {r.episode: r for r in read_records(out / f"removed-{number}")}
        edits = {edit.episode: edit for edit in Edits.read(out / f"removed-{number}.edits.jsonl").edits}
        assert told.keys() == without.keys() == edits.keys()
        assert all(r.n_habits == 19 for r in without.values())
        for line in lines:
            if line["habit"] == edits[line["episode"]].habit:
                pair = told[line["episode"]], without[line["episode"]]
                assert line["spl"] == [r.spl for r in pair]
                assert line["changes"] == (pair[0].actions != pair[1].actions)
    kept = (out / "cases.jsonl").read_bytes(), (out / "cases.json").read_bytes()
    seconds = (out / "told" / "seconds.json").read_bytes()
    assert main(command) == 0
    assert "4 of 40 habits tried in 2 episodes" in capsys.readouterr().out
    assert ((out / "cases.jsonl").read_bytes(), (out / "cases.json").read_bytes()) == kept
    assert (out / "told" / "seconds.json").read_bytes() == seconds, "a finished run is only read"
    assert main(["replay", str(out / "removed-1"), "--workers", "0", "--out", str(tmp_path / "again")]) == 0
    assert "the same to the byte" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("agent", "overrides", "options", "said"),
    [
        ("frontier", (), (), "expected an agent that reads habits"),
        ("belief", ("habit_level=none",), (), "at level none: expected an agent that reads habits, at level full"),
        ("belief", ("habit_level=context",), (), "at level context: expected"),
        ("belief", ("env.source.edits=edits.jsonl",), (), "the habits of this run were edited already"),
        ("belief", (), ("--most", "0"), "--most 0: expected a whole number from 1 up"),
        ("belief", (), ("--every", "0"), "--every 0: expected a whole number from 1 up"),
    ],
)
def test_runs_without_habits_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], agent: str, overrides: tuple[str, ...],
    options: tuple[str, ...], said: str,
) -> None:  # fmt: skip
    run = run_of(tmp_path / "run", agent, *overrides)
    assert main(["cases", run, "--out", str(tmp_path / "out"), *options]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("damage", [None, "[1]", "a: ${", "x: 1"])
def test_a_run_without_its_configuration_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], damage: str | None
) -> None:
    run = run_of(tmp_path / "run")
    config = tmp_path / "run" / "config.yaml"
    config.unlink() if damage is None else config.write_text(damage)
    assert main(["cases", run, "--out", str(tmp_path / "out")]) == 2
    assert "config.yaml: no " in capsys.readouterr().err
