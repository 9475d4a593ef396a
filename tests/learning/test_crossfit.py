"""Readers fitted on some categories of a habit book to read the others, also for a user's own book."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.learning.belief_tiny import tiny_belief
from tests.learning.tiny import some_habits
from ucon.core.errors import ConfigError
from ucon.core.files import MANIFEST
from ucon.fitting.place_encoder import PlaceRecipe
from ucon.habits import book
from ucon.habits.types import HabitDataset
from ucon.language.pairs import default_pair_reader
from ucon.learning.belief_head.crossfit import ReadEvidence, folds, train_texts
from ucon.learning.belief_head.held_out_readers import Fold
from ucon.readers.household import FittedParts
from ucon.readers.reader_weights import default_weights

QUICK = PlaceRecipe(epochs=1, rank=2)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """A separate user cache, shared by all tests of this file."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UCON_CACHE", str(folder))
        torch.set_num_threads(1)
        yield folder


@pytest.fixture(scope="module")
def data():
    """A small book that names fewer anchors than the shipped one."""
    found = some_habits(40)
    assert len(found.anchors) < len(default_weights().anchors)
    return found


def fitted(data):
    return folds(data, default_pair_reader(), 2, 1, QUICK, lambda text: None)


@pytest.fixture(scope="module")
def fold(data, cache):
    return fitted(data)[0]


def never(text):
    raise AssertionError(text)


def test_the_shipped_book_names_the_anchors_of_the_shipped_weights():
    assert book().anchors == default_weights().anchors


def test_a_small_book_is_read_with_the_anchors_of_the_shipped_weights(fold):
    known, texts = default_weights().anchors, train_texts(fold.dataset)
    assert fold.weights.anchors == known
    assert fold.logits.shape == (len(texts), len(known) + 5)
    assert fold.weights["prior_bias"].shape == (len(known),)
    said = ReadEvidence.of(fold, default_pair_reader()).read(texts)
    places = [entry.placements[habit.supports[0]].anchor for entry, habit in told(fold.dataset)]
    rows = [texts.index(habit.text) for _, habit in told(fold.dataset)]
    p = [said.anchor[row, known.index(place)] for row, place in zip(rows, places, strict=True)]
    assert np.median(p) > 5 / len(known), "columns are not those of their names"


def told(data):
    """Sentences of train entries that support exactly one place, with their entries."""
    texts = set(train_texts(data))
    return [(e, h) for e in data.entries for h in e.habits if len(h.supports) == 1 and h.text in texts]


def test_a_head_learns_from_a_small_book(fold):
    pairs = default_pair_reader()
    read = Fold(fold.dataset, FittedParts(fold.weights, pairs, ReadEvidence.of(fold, pairs)))
    learner = tiny_belief(folds=[read])
    losses = [learner.step()["loss"] for _ in range(3)]
    assert np.isfinite(losses).all()


def test_is_fitted_once_and_anew_where_it_was_killed_meanwhile(data, fold, cache):
    (manifest,) = (cache / "crossfit").rglob(MANIFEST)
    again = folds(data, default_pair_reader(), 2, 1, QUICK, never)[0]
    assert np.array_equal(again.logits, fold.logits)
    manifest.unlink()  # as after a kill between writing the two files
    with pytest.raises(AssertionError, match="fitting a reader for"):
        folds(data, default_pair_reader(), 2, 1, QUICK, never)
    assert np.array_equal(fitted(data)[0].logits, fold.logits)
    assert manifest.is_file()


def test_anchors_that_the_shipped_weights_do_not_know_are_refused_before_fitting(data, cache):
    first = data.entries[0]
    moved = replace(first, placements=tuple(replace(place, anchor="unicorn") for place in first.placements))
    odd = HabitDataset("own", (moved, *data.entries[1:]))
    with pytest.raises(
        ConfigError, match=r"habits own: the anchor unicorn is not among the 109 .* rename it"
    ) as caught:
        folds(odd, default_pair_reader(), 2, 1, QUICK, never)
    assert "\n" not in str(caught.value)
