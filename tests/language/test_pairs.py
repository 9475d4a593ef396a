"""Words and pair features."""

import numpy as np
import pytest

from ucon.habits import book
from ucon.language.pairs import FEATURES, default_pair_reader
from ucon.language.quantise import cosines, quantise
from ucon.language.words import stem, stems, synonyms, tokens
from ucon.objects.catalogue import catalogue

COLUMN = {name: i for i, name in enumerate(FEATURES)}


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ("shelves", "shelf"),
        ("cabinets", "cabinet"),
        ("boxes", "box"),
        ("batteries", "battery"),
        ("knives", "knife"),
        ("hanging", "hang"),
        ("stopped", "stop"),
        ("dresses", "dress"),
        ("leaning", "leaned"),
        ("stored", "stores"),
    ],
)
def test_stems_join(a, b):
    assert stem(a) == stem(b)


@pytest.mark.parametrize(("a", "b"), [("bus", "bu"), ("glass", "gla"), ("bed", "b"), ("ring", "r"), ("red", "r")])
def test_stems_do_not_cut_short_words(a, b):
    assert stem(a) != b


def test_tokens():
    assert tokens("Mother's coffee_table, twice!") == ["mother", "coffee", "table", "twice"]
    assert stems("the low shelves") == ("the", "low", "shelf")


def test_synonyms_are_about_catalogue_names():
    assert set(synonyms()) <= set(catalogue().names)
    assert set(book().anchors) <= set(synonyms())


@pytest.mark.parametrize(
    ("habit", "name", "feature"),
    [
        ("Keys land on the coffee tables.", "coffee_table", "phrase"),
        ("It sinks between the cushions of the couch.", "sofa", "synonym"),
        ("Butter goes back to the icebox.", "fridge", "synonym"),
        ("The books go to the shelves on the left.", "wall_mounted_shelf", "head"),
        ("Coffee is served at the round table.", "coffee_table", "share"),
    ],
)
def test_lexical_features(habit, name, feature):
    named, other = default_pair_reader().features([habit], [name, "treadmill"])[0]
    assert named[COLUMN[feature]] == 1
    assert not other[: COLUMN["word"]].any()
    assert named[COLUMN["word"]] > other[COLUMN["word"]]


def test_features_do_not_depend_on_the_company():
    texts, names = list(book().texts[:40]), list(catalogue().names[:30])
    whole = default_pair_reader().features(texts, names)
    assert whole.shape == (40, 30, len(FEATURES))
    assert whole.dtype == np.float32
    assert np.abs(whole).max() <= 1.0001
    assert default_pair_reader().features(texts[7:9], names[3:8]).tobytes() == whole[7:9, 3:8].tobytes()
    assert (
        default_pair_reader().features(texts, names[::-1]).tobytes() == np.ascontiguousarray(whole[:, ::-1]).tobytes()
    )


def test_empty():
    assert default_pair_reader().features([], ["desk"]).shape == (0, 1, len(FEATURES))
    assert default_pair_reader().features(["Nothing of note happens."], []).shape == (1, 0, len(FEATURES))


def test_quantised_cosines_are_exact_and_close():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(60, 384)), rng.normal(size=(40, 384))
    found = cosines(quantise(a), quantise(b))
    true = (a / np.linalg.norm(a, axis=1)[:, None]) @ (b / np.linalg.norm(b, axis=1)[:, None]).T
    assert np.abs(found - true).max() < 5e-3
    assert cosines(quantise(a[:1]), quantise(b[5:6]))[0, 0] == found[0, 5]
