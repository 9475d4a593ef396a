"""False sentences among the habits, and edits of single sentences: what agents are given, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ucon.core.errors import ConfigError, DataError, EpisodeError
from ucon.envs.knowledge import HabitSource
from ucon.envs.told.edits import Edit, Edits, save_edits
from ucon.envs.told.falsehoods import Falsehoods, place_now, things_of
from ucon.envs.told.orders import ordered_places, orders_for, with_orders
from ucon.envs.ucon_env import UcONEnv
from ucon.habits import book
from ucon.habits.types import HabitDataset
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

EPISODES = load_episodes("mini")[::4]
SOURCE = HabitSource()


def naming(source: HabitSource, episode: Episode) -> list[int]:
    """Rows of the knowledge base that name a place of the target."""
    rows = source.knowledge(episode, "none").base.rows_about(episode.target_category)
    return [int(row) for row in rows if source.dataset.supports(row)]


def places(dataset: HabitDataset, row: int) -> set[tuple[str, str]]:
    return {(place.relation, place.anchor) for place in dataset.supports(row)}


@pytest.mark.parametrize("episode", EPISODES, ids=lambda e: e.id)
def test_lies_are_other_peoples_and_name_what_stands_in_this_home(episode: Episode) -> None:
    dataset, true = book(), naming(SOURCE, episode)
    told = naming(HabitSource(falsehoods="adversarial", false_share=1.0), episode)
    own = {place for row in true for place in places(dataset, row)}
    now = place_now(dataset, episode)
    assert not set(told) & set(true)
    assert len(told) <= len(true)
    for row in told:
        assert dataset.entry_of(row).category == episode.target_category
        assert dataset.entry_of(row).id not in episode.entries
        assert not places(dataset, row) & own
        assert {anchor for _, anchor in places(dataset, row)} <= things_of(episode) - {now.anchor}


@pytest.mark.parametrize("kind", ["adversarial", "stale"])
def test_a_larger_share_replaces_more_of_the_same(kind: str) -> None:
    dataset = book()
    for episode in EPISODES:
        now = place_now(dataset, episode)
        before: set[int] = set()
        base = Falsehoods(kind, 0.0).among(SOURCE.knowledge(episode, "none").base, episode)
        true = {row for row in base.rows_about(episode.target_category).tolist() if dataset.supports(row)}
        assert kind == "adversarial" or all((now.relation, now.anchor) in places(dataset, row) for row in true)
        for share in (0.25, 0.5, 0.75, 1.0):
            left = true & set(naming(HabitSource(falsehoods=kind, false_share=share), episode))
            replaced = true - left
            assert before <= replaced
            assert share * len(true) - 1 < len(replaced) < share * len(true) + 1
            before = replaced
        assert before == true


def test_stale_sentences_are_the_households_own_of_another_time() -> None:
    dataset, counted = book(), 0
    for episode in EPISODES:
        now = place_now(dataset, episode)
        told = naming(HabitSource(falsehoods="stale", false_share=1.0), episode)
        counted += len(told)
        assert set(told) <= set(naming(SOURCE, episode))
        assert all((now.relation, now.anchor) not in places(dataset, row) for row in told)
    assert counted > 3


def test_all_other_sentences_stay_in_their_order() -> None:
    for kind in ("adversarial", "stale"):
        source = HabitSource(falsehoods=kind, false_share=0.5)
        for episode in EPISODES[:4]:
            about = set(naming(SOURCE, episode)) | set(naming(source, episode))
            kept = [
                [row for row in one.knowledge(episode, "none").base.rows.tolist() if row not in about]
                for one in (SOURCE, source)
            ]
            assert kept[0] == kept[1]


def test_orders_are_added_and_send_to_what_stands_there_and_never_holds_the_thing() -> None:
    dataset, n_added = book(), []
    for episode in EPISODES:
        before: set[int] = set()
        habits = SOURCE.knowledge(episode, "full")
        kept_at = {p.anchor for entry in dataset.entries_of(episode.target_category) for p in entry.placements}
        for share in (0.0, 0.25, 0.5, 1.0):
            given = HabitSource(falsehoods="orders", false_share=share).knowledge(episode, "full")
            rows = given.rows.tolist()
            assert [row for row in rows if row < len(dataset)] == habits.rows.tolist()
            added = {row for row in rows if row >= len(dataset)}
            wanted = share * len(naming(SOURCE, episode))
            there = orders_for(given.base.dataset, episode.target_category, things_of(episode))
            assert min(wanted - 1, len(there) - 0.5) < len(added) < wanted + 1
            assert before <= added
            before = added
        n_added.append(len(before))
        for row in before:
            entry = given.base.dataset.entry_of(row)
            place = ordered_places(entry)[row - int(given.base.dataset.first_row[given.base.dataset.row_entry[row]])]
            assert entry.category == episode.target_category
            assert place is None or place in things_of(episode) - kept_at
            assert given.base.dataset.texts[row] in given.texts
    assert 4 <= min(n_added) <= max(n_added) <= 8


def test_orders_are_about_each_thing_and_change_nothing_of_the_habits() -> None:
    dataset = book()
    ordered = with_orders(dataset)
    assert ordered is with_orders(dataset)
    assert ordered.texts[: len(dataset)] == dataset.texts
    assert ordered.categories == dataset.categories
    added = ordered.entries[len(dataset.entries) :]
    assert [entry.category for entry in added] == list(dataset.categories)
    assert {len(entry.habits) for entry in added} == {8}
    assert len({habit.text for entry in added for habit in entry.habits}) == 6 * len(added) + 2  # two name no thing
    assert not any(row for entry in added for row in entry.habits if row.supports)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"falsehoods": "adversary", "false_share": 0.5}, "unknown kind of falsehoods 'adversary': did you mean adv"),
        ({"falsehoods": "stale", "false_share": 1.5}, "false_share=1.5: expected a share from 0 to 1"),
        ({"falsehoods": "stale", "false_share": float("nan")}, "false_share=nan: expected a share from 0 to 1"),
        ({"false_share": 0.5}, "false_share=0.5: no kind of falsehoods"),
    ],
)
def test_wrong_falsehoods_are_refused_in_one_line(options: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=said) as caught:
        HabitSource(**options)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_habits_without_labels_cannot_be_falsified() -> None:
    dataset = book()
    unlabelled = HabitDataset("release", dataset.entries, labelled=False)
    source = HabitSource(unlabelled, falsehoods="stale", false_share=0.5)
    with pytest.raises(ConfigError, match="have no labels"):
        source.knowledge(EPISODES[0], "none")


def edited(tmp_path: Path, *edits: Edit) -> HabitSource:
    save_edits(edits, tmp_path / "edits.jsonl")
    return HabitSource(edits=str(tmp_path / "edits.jsonl"))


def test_an_edit_takes_out_one_sentence_of_one_episode_and_says_another(tmp_path: Path) -> None:
    first, second, other = EPISODES[:3]
    told = {episode.id: SOURCE.knowledge(episode, "retrieval").texts for episode in (first, second, other)}
    said = "The Smiths keep it under the piano."
    source = edited(tmp_path, Edit(first.id, told[first.id][3], None), Edit(second.id, told[second.id][0], said))
    env = UcONEnv((first, second, other), source=source)
    for episode, expected in (
        (first, told[first.id][:3] + told[first.id][4:]),
        (second, (said, *told[second.id][1:])),
        (other, told[other.id]),
    ):
        obs, info = env.reset(options={"episode": episode})
        assert info["habits"] == expected
        rows = obs["habits"][obs["habits_mask"] == 1]
        assert len(rows) == len(expected)
        vectors = source.encoder.encode_half(list(expected))
        assert np.abs(env.habit_table[rows].astype(float) - vectors).max() < 2e-3
    assert env.reset(options={"episode": second, "habit_level": "none"})[1]["habits"] == ()
    with pytest.raises(ConfigError, match="level context"):
        env.reset(options={"episode": second, "habit_level": "context"})


def test_an_edit_of_a_sentence_that_is_not_told_is_refused(tmp_path: Path) -> None:
    source = edited(tmp_path, Edit(EPISODES[0].id, "Nobody said this.", None))
    with pytest.raises(
        EpisodeError, match=r"is not given 'Nobody said this\.'; expected one of its 20 habits"
    ) as caught:
        source.knowledge(EPISODES[0], "retrieval")
    assert "\n" not in str(caught.value)


GOOD = {"episode": "a", "habit": "b", "instead": None}


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ([], "empty; expected lines with"),
        (["{"], r":1: not JSON"),
        ([{**GOOD, "more": 1}], r":1: "),
        ([{"episode": "a", "habit": "b"}], r":1: "),
        ([{**GOOD, "instead": 3}], r":1: instead=3"),
        ([{**GOOD, "habit": "\x1b[2J"}], r":1: expected plain text"),
        ([{**GOOD, "instead": " "}], r":1: expected plain text"),
        ([{**GOOD, "habit": "b" * 1001}], r":1: expected plain text"),
        ([GOOD, {**GOOD, "instead": "c"}], r":2: a second edit of the same sentence"),
    ],
)
def test_damaged_edits_are_refused_in_one_line(tmp_path: Path, lines: list[object], said: str) -> None:
    path = tmp_path / "edits.jsonl"
    path.write_text("".join(f"{line if isinstance(line, str) else json.dumps(line)}\n" for line in lines))
    with pytest.raises(DataError, match=said) as caught:
        Edits.read(path)
    assert "\n" not in str(caught.value)


def test_edits_of_no_episode_that_is_played_are_refused(tmp_path: Path) -> None:
    source = edited(tmp_path, Edit("test/elsewhere/000", "b", None), Edit(EPISODES[0].id, "b", None))
    source.check_edits(EPISODES)
    with pytest.raises(ConfigError, match=r"edits mini/.*, but no such episode is played; give their set"):
        source.check_edits(EPISODES[1:])


def test_edits_that_are_missing_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no such file of edits"):
        HabitSource(edits=str(tmp_path / "none.jsonl"))


def test_edits_count_among_what_decides_a_run(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    sources = [
        SOURCE,
        edited(tmp_path, Edit("a", "b", None)),
        edited(tmp_path / "other", Edit("a", "b", "c")),
    ]
    assert len({source.weights("retrieval") for source in sources}) == 3
