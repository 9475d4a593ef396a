"""Landmark cases: what counts as one, on real episodes of the test set."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from omegaconf import OmegaConf

sys.path.insert(0, str(Path(__file__).parent))
from records import record  # (the path above)

from tests.models.playing import config_of
from ucon.__main__ import main
from ucon.core.errors import ConfigError
from ucon.envs.knowledge import HabitSource
from ucon.evaluation.figures.landmark_cases import NEAR_M, landmark_cases, landmarks
from ucon.evaluation.kept.record import to_lines
from ucon.habits import book
from ucon.retrieval import BM25Retriever
from ucon.task.sets import load_episodes
from ucon.task.spoken import target_place

SOURCE = HabitSource()


@pytest.fixture(scope="module")
def found():
    """Cases among the test episodes, if every one were found at retrieval and none at gt."""
    episodes = load_episodes("test")[:400]
    runs = [
        [
            replace(record(0, success=success, steps=30, habit_level=level), episode=e.id, target=e.target_category)
            for e in episodes
        ]
        for level, success in (("retrieval", True), ("gt", False))
    ]
    return episodes, *runs, list(landmark_cases(*runs, episodes, SOURCE))


def test_a_case_is_what_it_says(found):
    episodes, _, _, cases = found
    assert len(cases) > 3
    by_id = {episode.id: episode for episode in episodes}
    for case in cases:
        episode = by_id[case.episode]
        given = SOURCE.knowledge(episode, "retrieval")
        assert given.texts[case.rank - 1] == case.habit
        dataset = book()
        row = int(given.rows[case.rank - 1])
        assert dataset.categories[dataset.row_category[row]] == case.landmark != case.target == episode.target_category
        things = [o for o in episode.arrangement.objects if o.category == case.landmark]
        assert len(things) == 1
        gap = np.linalg.norm(np.subtract(things[0].position, episode.target_object.position))
        assert gap == pytest.approx(case.distance_m, abs=0.006)
        assert gap <= NEAR_M
        # The habit speaks for the place where that thing really is.
        entry = dataset.entries[dataset.row_entry[row]]
        index = episode.arrangement.objects.index(things[0])
        assert episode.placed_by[index][0] == entry.id
        assert episode.placed_by[index][1] in dataset.habits[row].supports


def test_what_was_found_as_fast_with_own_habits_is_no_case(found):
    episodes, retrieved, own, cases = found
    fast = [replace(r, success=True, steps=44) for r in own]
    slow = [replace(r, success=True, steps=45) for r in own]
    assert list(landmark_cases(retrieved, fast, episodes, SOURCE)) == []
    assert len(list(landmark_cases(retrieved, slow, episodes, SOURCE))) == len(cases)
    failed = [replace(r, success=False) for r in retrieved]
    assert list(landmark_cases(failed, own, episodes, SOURCE)) == []


def test_the_target_is_no_landmark_of_itself():
    for episode in load_episodes("mini"):
        own = episode.placed_by[episode.target][0]
        assert own not in landmarks(episode)


def test_wrong_runs_are_told(found):
    episodes, retrieved, own, _ = found
    with pytest.raises(ConfigError, match="level retrieval"):
        list(landmark_cases(own, own, episodes, SOURCE))
    with pytest.raises(ConfigError, match="different agents"):
        list(landmark_cases(retrieved, [replace(r, agent="b") for r in own], episodes, SOURCE))
    with pytest.raises(ConfigError, match="not in the given set"):
        list(landmark_cases(retrieved, own, episodes[:1], SOURCE))


def stored(folder, found, gt=(), retrieval=()):
    """Two runs as eval.py leaves them, with further options of their configurations."""
    _, retrieved, own, _ = found
    for level, records, options in (("retrieval", retrieved, retrieval), ("gt", own, gt)):
        (folder / level).mkdir()
        (folder / level / "episodes.jsonl").write_text(to_lines(records))
        config = OmegaConf.create(config_of("belief", f"habit_level={level}", "episodes=test", *options))
        (folder / level / "config.yaml").write_text(OmegaConf.to_yaml(config))
    return str(folder / "retrieval"), str(folder / "gt")


@pytest.mark.parametrize(
    ("options", "different"),
    [(("detector=noisy",), "detector, env"), (("seed=1",), "seed"), (("knowledge_base=task",), "knowledge_base")],
)
def test_runs_that_differ_in_more_than_the_level_are_refused(found, tmp_path, capsys, options, different):
    assert main(["cases", *stored(tmp_path, found, gt=options)]) == 2
    assert f"the two runs differ in {different}" in capsys.readouterr().err


@pytest.mark.slow
def test_the_habits_are_those_that_the_run_was_given(found, tmp_path, capsys):
    """Another retriever gives other lists, so the same records make other cases, ranked as it ranks."""
    episodes, retrieved, own, cases = found
    assert main(["cases", *stored(tmp_path, found, retrieval=("retriever=bm25",)), "--json"]) == 0
    said = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    by_words = HabitSource(retriever=BM25Retriever())
    assert said == [case.to_json() for case in landmark_cases(retrieved, own, episodes, by_words)]
    assert said != [case.to_json() for case in cases]


@pytest.mark.parametrize("damage", [None, "[1]", "a: ${", "x: 1"])
def test_a_run_without_its_configuration_is_refused(found, tmp_path, capsys, damage):
    folders = stored(tmp_path, found)
    config = tmp_path / "retrieval" / "config.yaml"
    config.unlink() if damage is None else config.write_text(damage)
    assert main(["cases", *folders]) == 2
    assert "config.yaml: no " in capsys.readouterr().err


def test_the_command_keeps_episodes_that_can_be_played_again(found, tmp_path, capsys):
    *_, cases = found
    folders = stored(tmp_path, found)
    out = tmp_path / "cases.jsonl.xz"
    assert main(["cases", *folders, "--out", str(out)]) == 0
    told = capsys.readouterr().out
    assert f"{len(cases)} cases" in told
    where = {e.id: target_place(e) for e in load_episodes(out)}
    assert all(
        f"): {case.target} {where[case.episode]}\n  {case.landmark} {case.distance_m} m away" in told for case in cases
    )
    assert {e.id for e in load_episodes(out)} == {case.episode for case in cases}
