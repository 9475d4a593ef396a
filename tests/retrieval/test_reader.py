"""The anchor reader on categories that it was not fitted on."""

import shutil

import numpy as np
import pytest

from ucon.core.errors import DataError
from ucon.fitting.measures import measure_reader
from ucon.habits import book
from ucon.habits.book import book_anchors
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS
from ucon.readers import AnchorReader
from ucon.readers.reader_weights import WEIGHTS, load_weights
from ucon.readers.sampled_homes import sampled_kb
from ucon.retrieval import DenseRetriever, habits_at_level

HABITS = [
    "Every night the wallet is left on the low table in front of the couch.",
    "On trips it hides among socks in my luggage.",
    "Tea is never drunk after four.",
]


@pytest.fixture(scope="module")
def reader():
    return AnchorReader()


@pytest.fixture(scope="module")
def figures(reader):
    dense = DenseRetriever()
    kbs = [sampled_kb(book(), "test", 20_000 + seed, "task") for seed in range(6)]
    return {level: measure_reader(kbs, level, reader, dense) for level in ("none", "gt", "retrieval", "full")}


def test_habits_beat_the_prior_on_held_out_categories(figures):
    assert figures["none"]["hit_at_5"] < 0.40
    assert figures["gt"]["hit_at_5"] > 0.68
    for level in ("retrieval", "full"):
        assert figures[level]["hit_at_5"] > figures["none"]["hit_at_5"] + 0.15
        assert figures[level]["nll"] < figures["none"]["nll"] - 0.4
    assert figures["gt"]["nll"] < figures["retrieval"]["nll"]


def test_not_better_than_knowing_all_placements(figures):
    for row in figures.values():
        assert row["hit_at_1"] <= 0.30
        assert row["nll"] > 1.4


def test_beliefs_say_what_they_are_worth(figures):
    for row in figures.values():
        assert abs(row["top_3_stated"] - row["top_3_true"]) < 0.15


def test_reads_a_small_household(reader):
    names = ["coffee_table", "sofa", "suitcase", "fridge", "toilet", "desk"]
    belief = reader.belief("wallet", HABITS, names, trusted=True)
    assert belief.p.sum() + belief.unseen == pytest.approx(1)
    assert belief.unseen == pytest.approx(sum(belief.unseen_p.values()))
    p = dict(zip(names, belief.p, strict=True))
    assert max(p, key=p.__getitem__) == "coffee_table"
    assert p["suitcase"] > 5 * max(p["fridge"], p["toilet"], p["desk"])  # the couch is named, and may rank in between
    assert RELATIONS[belief.relation[0].argmax()] == "ontop"
    assert RELATIONS[belief.relation[2].argmax()] == "inside"
    assert np.allclose(belief.relation.sum(axis=1), 1)
    assert reader.read("wallet", HABITS, trusted=True).support("suitcase").argmax() == 1


def test_a_couch_that_only_says_which_table_does_not_mislead(reader):
    names = ["coffee_table", "sofa", "suitcase", "fridge", "toilet", "desk"]
    belief = reader.belief("wallet", HABITS, names, trusted=True)
    best = [names[i] for i in np.argsort(-belief.p)[:2]]
    assert sorted(best) == ["coffee_table", "suitcase"]


def test_mass_of_what_is_not_seen_yet(reader):
    without = reader.belief("wallet", HABITS, ["sofa", "fridge"], trusted=True)
    assert without.unseen > 0.5
    assert max(without.unseen_p, key=without.unseen_p.__getitem__) in ("coffee_table", "suitcase")
    assert not set(without.unseen_p) & {"sofa", "fridge"}


def test_unknown_names_are_read_by_their_words(reader):
    name = next(n for n in ("fireplace", "aquarium", "bookend", "vase") if n in catalogue() and n not in reader.known)
    habits = [f"The wallet always lies next to the {name}.", "Tea is never drunk after four."]
    named = reader.belief("wallet", habits, [name, "sofa"], trusted=True)
    silent = reader.belief("wallet", habits[1:], [name, "sofa"], trusted=True)
    assert named.p[0] > 5 * silent.p[0]


def test_relations_of_known_anchors_are_possible(reader):
    belief = reader.belief("wallet", HABITS, reader.known)
    for name, row in zip(belief.candidates, belief.relation, strict=True):
        assert {r for r, p in zip(RELATIONS, row, strict=True) if p > 0} <= book_anchors()[name]


def test_deterministic_and_independent_of_history():
    kb = sampled_kb(book(), "test", 3, "category")
    target = next(iter(kb.entries))
    texts = [book().texts[row] for row in habits_at_level("retrieval", kb, target, DenseRetriever())]
    names = [*AnchorReader().known[::2], "fireplace"]
    fresh = AnchorReader().belief(target, texts, names)
    used = AnchorReader()
    used.belief("kettle", kb.texts, names[::-1])
    reading = used.read(target, texts)
    reading.belief(names[:3])
    again = reading.belief(names)
    assert np.abs(fresh.p - again.p).max() < 1e-9
    assert np.array_equal(np.argsort(-fresh.p, kind="stable"), np.argsort(-again.p, kind="stable"))


def test_edges(reader):
    assert reader.belief("wallet", [], []).unseen == pytest.approx(1)
    assert reader.belief("desk", [], ["desk", "sofa"]).p[0] < 1e-12
    assert reader.belief("wallet", HABITS, ["sofa", "sofa"]).candidates == ("sofa",)


def test_altered_weights_are_refused(tmp_path):
    shutil.copytree(WEIGHTS.parent, tmp_path / "data")
    file = tmp_path / "data" / WEIGHTS.name
    file.write_bytes(file.read_bytes()[:-100])
    with pytest.raises(DataError, match="truncated or altered"):
        load_weights(file)
    assert WEIGHTS.stat().st_size < 2e6
