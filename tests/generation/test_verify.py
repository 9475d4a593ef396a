"""The verifier on categories that it was never fitted on."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from ucon.core.errors import DataError
from ucon.core.rng import stream
from ucon.fitting.verifier import fit, held_out, labelled_pairs, measure
from ucon.generation.verify import WEIGHTS, Verifier, default_verifier, doubtful, pack, unpack
from ucon.habits import book
from ucon.habits.splits import split_categories
from ucon.habits.types import Placement
from ucon.language.pairs import default_pair_reader
from ucon.readers.reader_weights import load_arrays

CATEGORIES = split_categories(book().categories, "test")[::4]
ENTRIES = [entry for name in CATEGORIES for entry in book().entries_of(name)]
PLACES = [Placement("ontop", "coffee_table"), Placement("inside", "suitcase"), Placement("inside", "fridge")]
TEXTS = [
    "Every night the wallet is left on the low table in front of the couch.",
    "On trips it hides among socks in my luggage.",
    "Tea is never drunk after four.",
]


@pytest.fixture(scope="module")
def verifier():
    return default_verifier()


def with_habits(entry, change):
    """The entry with some habits replaced: ``change`` maps their numbers to new ones."""
    return replace(entry, habits=tuple(change.get(i, habit) for i, habit in enumerate(entry.habits)))


def dataset(entries):
    return replace(book(), entries=tuple(entries))


def test_tells_supported_places_from_others_on_held_out_categories(verifier):
    figures = measure(book(), verifier, lambda e: e.category in CATEGORIES)
    assert figures["supported"] > 400
    assert figures["auroc_swapped"] >= 0.95
    assert figures["auroc_other"] >= 0.95
    assert figures["auroc_distractor"] >= 0.95


def test_it_is_the_sentence_that_decides(verifier):
    rng = stream(0, "shuffle")
    told = [habit.text for entry in ENTRIES for habit in entry.habits if habit.supports]
    mixed = [
        with_habits(e, {i: replace(h, text=told[int(rng.integers(len(told)))]) for i, h in enumerate(e.habits)})
        for e in ENTRIES
    ]
    pairs = labelled_pairs(verifier, mixed, verifier.frequency)
    assert abs(pairs.auroc(verifier.head, "swapped") - 0.5) < 0.06
    assert abs(pairs.auroc(verifier.head, "other") - 0.5) < 0.06


def test_scores_are_probabilities(verifier):
    scores = np.concatenate([verifier.scores([h.text for h in e.habits], e.placements).ravel() for e in ENTRIES])
    labels = np.concatenate([[j in h.supports for h in e.habits for j in range(len(e.placements))] for e in ENTRIES])
    assert labels[scores > 0.9].mean() > 0.9
    assert labels[scores < 0.1].mean() < 0.03
    middle = (scores > 0.3) & (scores < 0.7)
    assert 0.3 < labels[middle].mean() < 0.75


def test_a_small_household(verifier):
    scores = verifier.scores(TEXTS, PLACES)
    assert scores.shape == (3, 3)
    assert scores[0].argmax() == 0
    assert scores[1].argmax() == 1
    assert min(scores[0, 0], scores[1, 1]) > 0.5
    assert scores[2].max() < 0.1


def test_the_relation_counts(verifier):
    within, beside = verifier.scores(TEXTS[1:2], [Placement("inside", "suitcase"), Placement("nextto", "suitcase")])[0]
    assert within > beside


def test_an_anchor_that_training_never_met(verifier):
    name = next(n for n in ("fireplace", "aquarium", "bookend") if n not in verifier.known)
    there, away = verifier.scores(
        [f"The wallet always lies next to the {name}.", TEXTS[2]], [Placement("nextto", name), *PLACES]
    )
    assert there[0] > 0.5
    assert there[0] > there[1:].max()
    assert away[0] < 0.1


def test_nothing_to_score(verifier):
    assert verifier.scores([], PLACES).shape == (0, 3)
    assert verifier.scores(TEXTS, []).shape == (3, 0)


def test_deterministic_and_independent_of_the_batch(verifier):
    fresh = Verifier(*load_arrays(WEIGHTS))
    together = fresh.scores(TEXTS[::-1], PLACES[::-1])[::-1, ::-1]
    single = np.asarray([[verifier.scores([text], [place])[0, 0] for place in PLACES] for text in TEXTS])
    assert np.abs(together - single).max() < 1e-4
    assert np.array_equal(fresh.scores(TEXTS, PLACES), verifier.scores(TEXTS, PLACES))


def test_labels_that_were_moved_are_doubted(verifier):
    rng, moved, entries = stream(0, "move"), set(), []
    for entry in ENTRIES:
        speaking = [i for i, habit in enumerate(entry.habits) if len(habit.supports) == 1]
        i = speaking[int(rng.integers(len(speaking)))]
        old = entry.habits[i].supports[0]
        new = (old + 1 + int(rng.integers(len(entry.placements) - 1))) % len(entry.placements)
        moved |= {(entry.id, i, old, False), (entry.id, i, new, True)}
        entries.append(with_habits(entry, {i: replace(entry.habits[i], supports=(new,))}))
    doubts = doubtful(dataset(entries), verifier)
    number = {entry.id: entry for entry in entries}
    found = [(d.entry, d.habit, number[d.entry].placements.index(d.placement), d.labelled) for d in doubts]
    habits = {(entry, habit) for entry, habit, _, _ in moved}
    assert len({key[:2] for key in found} & habits) > 0.8 * len(habits)
    assert {key[3] for key in found if key in moved} == {True, False}
    assert all(key in moved for key in found[:30])
    assert sum(key not in moved for key in found) < 0.2 * len(found)


def test_supports_that_were_taken_away_or_invented_are_doubted(verifier):
    entry = next(e for e in ENTRIES if verifier.scores([e.habits[0].text], e.placements)[0].max() > 0.95)
    silent = next(i for i, habit in enumerate(entry.habits) if not habit.supports)
    (place,) = entry.habits[0].supports
    changed = with_habits(
        entry,
        {0: replace(entry.habits[0], supports=()), silent: replace(entry.habits[silent], supports=(place,))},
    )
    doubts = {(d.habit, d.placement, d.labelled): d for d in doubtful(dataset([changed]), verifier)}
    assert (0, entry.placements[place], False) in doubts
    assert (silent, entry.placements[place], True) in doubts
    assert "is not labelled as supporting" in str(doubts[0, entry.placements[place], False])
    assert not doubtful(dataset([changed]), verifier, wanted=lambda _: False)


def test_few_labels_of_the_book_are_doubted(verifier):
    doubts = doubtful(dataset(ENTRIES), verifier)
    assert len(doubts) < 0.2 * len(ENTRIES)
    assert [max(1 - d.score, d.score) for d in doubts] == sorted(max(1 - d.score, d.score) for d in doubts)[::-1]


def test_a_dataset_without_labels_is_refused(verifier):
    with pytest.raises(DataError, match="does not say which habit supports what"):
        doubtful(replace(book(), labelled=False), verifier)


def test_weights(tmp_path):
    assert WEIGHTS.stat().st_size < 1e6
    arrays, _ = load_arrays(WEIGHTS)
    with pytest.raises(DataError, match=r"no head.*data fit-verifier"):
        Verifier({name: value for name, value in arrays.items() if name != "head"})
    with pytest.raises(DataError, match="do not fit this version"):
        Verifier(arrays | {"head": arrays["head"][:-1]})
    shutil.copytree(WEIGHTS.parent, tmp_path / "data")
    file = tmp_path / "data" / WEIGHTS.name
    file.write_bytes(file.read_bytes()[:-100])
    with pytest.raises(DataError, match="truncated or altered"):
        load_arrays(file)


def test_packed_words_come_back():
    weights = stream(0, "words").normal(size=(50, 7)).astype(np.float32)
    weights[3] = 0
    assert np.abs(unpack(pack(weights)) - weights).max() <= np.abs(weights).max() / 250


@pytest.mark.slow
def test_the_command_makes_the_shipped_weights():
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        again = Verifier(fit(book(), default_pair_reader()))
    finally:
        torch.set_num_threads(threads)
    figures = [measure(book(), one, held_out(book())["test"]) for one in (again, default_verifier())]
    assert figures[0] == pytest.approx(figures[1], abs=2e-3)
    assert figures[1]["auroc_swapped"] >= 0.98
