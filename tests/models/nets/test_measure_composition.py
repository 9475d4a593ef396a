"""What is measured of the second hop: households where things lie by things that were moved, and their truth."""

from __future__ import annotations

import re

import pytest

from models.nets.measure_composition import FIRST_SEED, household, main, truth
from ucon.core.errors import ConfigError
from ucon.habits import KnowledgeBase, book
from ucon.habits.splits import entry_parts
from ucon.habits.types import Entry, Habit, HabitDataset, Placement


def entry(name: str, *anchors: str) -> Entry:
    places = tuple(Placement("ontop", anchor) for anchor in anchors)
    habits = tuple(Habit(f"The {name} is there.", (k,)) for k in range(len(places)))
    return Entry(f"{name}.1", name, "home", places, habits)


@pytest.fixture(scope="module")
def kb() -> KnowledgeBase:
    """A cup on a tray or a desk; the tray on a shelf or a table."""
    entries = (entry("cup", "tray", "desk"), entry("tray", "shelf", "coffee_table"))
    return KnowledgeBase.build(HabitDataset("small", entries), {e.category: [e] for e in entries}, 0)


def test_the_truth_is_where_things_are_in_the_end(kb: KnowledgeBase) -> None:
    assert truth(kb, "cup") == pytest.approx({"desk": 0.5, "shelf": 0.25, "coffee_table": 0.25})
    assert truth(kb, "tray") == pytest.approx({"shelf": 0.5, "coffee_table": 0.5})


@pytest.mark.parametrize("k", [20, 8])
def test_households_hold_things_that_others_lie_by(k: int) -> None:
    parts, found = entry_parts(book()), household(FIRST_SEED, k)
    assert len(found.entries) == k
    assert sum(name in book().anchors for name in found.entries) == 3 * k // 4
    assert all(len(entries) == 1 and parts[entries[0].id] == "test" for entries in found.entries.values())
    assert found.texts == household(FIRST_SEED, k).texts != household(FIRST_SEED + 1, k).texts


def test_targets_that_need_the_second_hop_are_told_apart(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--kbs", "1"])
    pattern = r"depth (\d) (\w+) +n=(\d+) hit_at_5 (\S+) nll (\S+)"
    rows = {(found[0], found[1]): found[2:] for found in re.findall(pattern, capsys.readouterr().out)}
    kb = household(FIRST_SEED)
    chained = [one for one in kb.entries.values() if any(place.anchor in kb.entries for place in one[0].placements)]
    assert 0 < len(chained) < len(kb.entries)
    for depth in ("0", "3"):
        assert int(rows[depth, "chained"][0]) == len(chained)
        assert int(rows[depth, "all"][0]) == len(kb.entries)
        assert all(0.0 < float(rows[depth, what][1]) < 1.0 for what in ("chained", "all"))
    assert float(rows["3", "chained"][2]) < float(rows["0", "chained"][2]), "it finds what lies by what was moved"


def test_there_is_something_to_measure() -> None:
    with pytest.raises(ConfigError, match="--kbs 0: expected a number"):
        main(["--kbs", "0"])
