"""Households, hosting, knowledge bases, splits."""

from collections import Counter
from itertools import combinations

import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.habits import KnowledgeBase, book, category_split, hosted, household, split_categories
from ucon.habits.splits import PARTS_USED, entry_parts
from ucon.habits.types import HOUSEHOLD_KINDS


def drawn(home: str = "Rs_int", k: int = 20):
    found = household(home, book())
    return {c: found[c] for c in book().categories[:: len(book().categories) // k][:k]}


def test_household_is_seeded_by_the_home():
    data = book()
    a, b = household("Rs_int", data), household("Rs_int", data)
    assert a == b
    assert a != household("Merom_1_int", data)
    assert a != household("Rs_int", data, seed=1)
    counts = [len(entries) for entries in a.values()]
    assert set(counts) == {1, 2, 3}
    assert 2.2 < np.mean(counts) < 2.4
    assert list(a) == list(data.categories)


def test_hosting_needs_two_realisable_placements():
    data = book()
    entry = data.entries[0]
    anchors = [p.anchor for p in entry.placements]
    (one,) = hosted([entry], {anchors[0]})
    (two,) = hosted([entry], {anchors[0]}, lambda name: name == anchors[1])
    assert not one.ok
    assert one.realisable == (0,)
    assert two.ok
    assert two.placements == entry.placements[:2]
    assert [h.entry for h in hosted(data.entries, ())] == list(data.entries)


@pytest.mark.parametrize("mode", ["category", "task"])
def test_knowledge_base(mode):
    chosen = drawn()
    kb = KnowledgeBase.build(book(), chosen, 5, mode)
    assert list(kb.rows) == list(KnowledgeBase.build(book(), chosen, 5, mode).rows)
    assert list(kb.rows) != list(KnowledgeBase.build(book(), chosen, 6, mode).rows)
    assert kb.rows.dtype == np.int32
    assert len(set(kb.rows.tolist())) == len(kb)
    assert set(kb.entries) == set(chosen)
    for category, entries in kb.entries.items():
        assert set(entries) <= set(chosen[category])
        assert len(entries) == (1 if mode == "task" else len(chosen[category]))
        assert set(kb.rows_about(category)) == set(book().rows_of_entries(entries))
    assert (180 <= len(kb) <= 220) if mode == "task" else (len(kb) > 300)
    assert list(kb.rows) != sorted(kb.rows)


def test_adding_a_category_shifts_no_other():
    chosen = drawn()
    last = sorted(chosen)[-1]
    whole = KnowledgeBase.build(book(), chosen, 5)
    part = KnowledgeBase.build(book(), {c: e for c, e in chosen.items() if c != last}, 5)
    assert list(whole.without(last).rows) == list(part.rows)


def test_empty_and_unknown():
    with pytest.raises(ConfigError, match="empty knowledge base"):
        KnowledgeBase.build(book(), {}, 0)
    with pytest.raises(ConfigError, match="unknown knowledge base mode"):
        KnowledgeBase.build(book(), drawn(), 0, "entry")  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="unknown target of this knowledge base"):
        KnowledgeBase.build(book(), drawn(), 0).rows_about("piano")


def test_splits():
    names = book().categories
    parts = {split: split_categories(names, split) for split in ("train", "val", "test")}
    assert sorted(sum(parts.values(), ())) == sorted(names)
    assert len(parts["test"]) >= 60
    assert len(parts["val"]) >= 40
    assert len(parts["train"]) > 300
    assert category_split("wallet") == "test"  # unseen in the official release


def test_every_training_category_keeps_entries_for_testing():
    data, parts = book(), entry_parts(book())
    for category in split_categories(data.categories, "train"):
        found = Counter(parts[e.id] for e in data.entries_of(category))
        assert set(found) <= {"train", "test"}
        assert found["test"] >= 1
    for split in ("val", "test"):
        for category in split_categories(data.categories, split):
            assert {parts[e.id] for e in data.entries_of(category)} == {split}
    counts = Counter(parts.values())
    assert 0.35 < counts["train"] / len(parts) < 0.5


def test_parts_share_no_sentence_and_no_tested_category_is_learned():
    data, parts = book(), entry_parts(book())
    texts = {split: {h.text for e in data.entries if parts[e.id] == split for h in e.habits} for split in PARTS_USED}
    assert not any(texts[a] & texts[b] for a, b in combinations(PARTS_USED, 2))
    learned = {e.category for e in data.entries if parts[e.id] == "train"}
    assert not learned & {*split_categories(data.categories, "test"), *split_categories(data.categories, "val")}


@pytest.mark.parametrize("part", PARTS_USED)
def test_households_of_a_part_have_its_entries_only(part):
    parts = entry_parts(book())
    people = household("Rs_int", book(), part=part)
    assert {parts[e.id] for entries in people.values() for e in entries} <= PARTS_USED[part]
    assert len(people) > 100


def test_people_bound_to_a_kind_of_place_live_there_and_come_first():
    kinds = {kind: [e for e in book().entries if e.kind == kind] for kind in HOUSEHOLD_KINDS}
    assert all(len(entries) >= 20 for entries in kinds.values())
    at_home = household("Rs_int", book())
    assert not [e for entries in at_home.values() for e in entries if e.kind]
    for kind, entries in kinds.items():
        people = household("some_place", book(), kinds=(kind,))
        found = {e for found in people.values() for e in found if e.kind}
        assert {e.kind for e in found} == {kind}
        assert len(found) >= 0.9 * len({e.category for e in entries})
