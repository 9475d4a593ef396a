"""Learning to read places in sentences from where things are kept, without labels of which sentence says it."""

from dataclasses import replace
from functools import partial
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from models.nets.belief.head_reader import HeadReader
from tests.learning.belief_tiny import small_head
from tests.learning.test_belief import in_two_homes
from ucon.core.errors import ConfigError, DataError, DivergedError
from ucon.core.files import write_manifest
from ucon.fitting import scene_evidence as scene_fitting
from ucon.fitting.scene_evidence import SceneRecipe, cached_scene_evidence, precomputed_vectors
from ucon.habits import book
from ucon.habits.splits import entry_parts
from ucon.language.pairs import default_pair_reader
from ucon.learning.belief_head import held_out_readers as belief_readers
from ucon.learning.belief_head.households import pair_folds
from ucon.learning.belief_head.learner import BeliefLearner
from ucon.readers.household import parts_with
from ucon.readers.reader_weights import load_arrays
from ucon.readers.scene_evidence import ADAPTER, LAST, SceneEvidence

QUICK = SceneRecipe(epochs=1)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """A separate user cache, shared by all tests of this file."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UCON_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def data():
    """Two homes with entries of the book, whose labels are not used."""
    return replace(in_two_homes(), standing={"home_0": ("unicorn",), "home_1": ("griffin",)})


def of_part(data, part):
    parts = entry_parts(data)
    return [entry for entry in data.entries if parts[entry.id] == part]


@pytest.fixture(scope="module")
def folder(data, cache):
    torch.set_num_threads(1)
    return cached_scene_evidence(data, of_part(data, "train"), default_pair_reader(), QUICK)


@pytest.fixture(scope="module")
def places(folder):
    return parts_with(None, folder).scene_evidence


@pytest.mark.slow
def test_learns_which_places_sentences_speak_for(places, data):
    told = [
        (habit.text, entry.placements[habit.supports[0]].anchor)
        for entry in [*of_part(data, "val"), *of_part(data, "test")]
        for habit in entry.habits
        if len(habit.supports) == 1 and entry.placements[habit.supports[0]].anchor in places.known
    ]
    said = places.spoken([text for text, _ in told], places.known)
    right = np.mean([places.known[row.argmax()] == anchor for row, (_, anchor) in zip(said, told, strict=True)])
    silent = [h.text for e in of_part(data, "test") for h in e.habits if not h.supports]
    assert len(told) > 60
    assert right > 0.4  # of a hundred anchors, without labels
    assert np.median(said.max(1)) > 3 * np.median(places.read(silent).place)


def test_knows_whose_sentences_are(places, data):
    entries = of_part(data, "test")
    right = []
    for entry, other in pairwise(entries):
        texts = [habit.text for habit in entry.habits if habit.supports]
        right += list(places.about(entry.category, texts) > places.about(other.category, texts))
    assert np.mean(right) > 0.8


def test_names_and_sentences_are_read_by_themselves(places, data):
    texts = [habit.text for habit in data.entries[0].habits]
    names = ["desk", "sink", "a thing never met"]
    whole = places.spoken(texts, names)
    assert np.array_equal(whole[:, :2], places.spoken(texts, names[:2]))
    assert np.array_equal(whole[:1], places.spoken(texts[:1], names))
    assert np.array_equal(places.read(texts).anchor[1:], places.read(texts[1:]).anchor)
    assert "a thing never met" not in places.known
    assert ((whole >= 0) & (whole <= 1)).all()
    assert places.spoken([], names).shape == (0, 3)
    assert places.spoken(texts, []).shape == (len(texts), 0)
    assert places.about("a thing never met", texts).shape == (len(texts),)


def _never(text):
    raise AssertionError(text)


def test_is_fitted_once(folder, data):
    assert cached_scene_evidence(data, of_part(data, "train"), default_pair_reader(), QUICK, _never) == folder
    with pytest.raises(AssertionError, match="minutes, once"):
        cached_scene_evidence(data, of_part(data, "train")[1:], default_pair_reader(), QUICK, _never)
    with pytest.raises(
        AssertionError, match="minutes, once"
    ):  # the furniture of a home decides which places are asked about
        cached_scene_evidence(replace(data, standing={}), of_part(data, "train"), default_pair_reader(), QUICK, _never)


def test_numbers_that_are_none_leave_nothing_behind(data, cache, monkeypatch):
    monkeypatch.setattr(scene_fitting, "_loss", lambda net, *_: net.bias.sum() * float("nan"))
    with pytest.raises(DivergedError, match="step 0: the loss is not finite"):
        cached_scene_evidence(data, of_part(data, "val"), default_pair_reader(), QUICK)
    monkeypatch.undo()
    with pytest.raises(AssertionError, match="minutes, once"):
        cached_scene_evidence(data, of_part(data, "val"), default_pair_reader(), QUICK, _never)


def test_many_sentences_are_encoded_beforehand_alike(folder, places, data):
    told = precomputed_vectors(folder, data.texts)
    arrays, sha256 = load_arrays(folder / LAST)
    beforehand = SceneEvidence(arrays, sha256, told, default_pair_reader(), belief_readers.shipped_evidence())
    texts = data.texts[:6]
    assert np.abs(beforehand.spoken(texts, places.known) - places.spoken(texts, places.known)).max() < 0.1
    kept = precomputed_vectors(folder, data.texts)
    assert np.array_equal(kept.encode_half(texts), told.encode_half(texts))


def test_what_reads_a_fold_learned_from_no_entry_of_it(data, folder, monkeypatch):
    learned = []

    def note(dataset, entries, pairs):
        learned.append({(e.scene, e.category) for e in entries})
        return folder

    monkeypatch.setattr(belief_readers, "cached_scene_evidence", note)
    folds = belief_readers.scene_folds(data, scene_evidence=True)
    assert [fold.pairs for fold in folds] == [asked for asked, _ in pair_folds(data, 4)]
    for number, fold in enumerate(folds):
        assert not fold.pairs & learned[number // 2]
        assert fold.parts.scene_evidence is not None
    taught = {(e.scene, e.category) for e in of_part(data, "train")}
    assert learned[0] | learned[1] == taught


def test_a_head_keeps_what_reads_for_it(data, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(belief_readers, "cached_scene_evidence", lambda *_: folder)
    learner = BeliefLearner(partial(small_head), data, steps=4, households=1, n_kbs=2, scene_evidence=True)
    assert np.isfinite(learner.step()["loss"])
    files = learner.product()
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    write_manifest(tmp_path, list(files))
    reader = HeadReader.load(tmp_path)
    entry = of_part(data, "test")[0]
    texts = [habit.text for habit in entry.habits]
    assert reader.known == learner._parts.scene_evidence.known
    assert np.array_equal(
        reader.parts.scene_evidence.spoken(texts, ["desk"]), learner._parts.scene_evidence.spoken(texts, ["desk"])
    )
    assert "without being told which sentence says so" in learner.card().text
    belief = reader.belief(entry.category, texts, reader.known)
    assert belief.p.sum() + belief.unseen == pytest.approx(1)
    assert belief.relation.sum(1) == pytest.approx(1)
    (tmp_path / ADAPTER).write_bytes(files[ADAPTER][:-8])
    with pytest.raises(DataError, match="truncated or altered"):
        HeadReader.load(tmp_path)


def test_arrays_that_do_not_fit_are_refused(folder):
    arrays, _ = load_arrays(folder / LAST)
    pairs = default_pair_reader()
    with pytest.raises(DataError, match="no pair; train the head again"):
        SceneEvidence({k: v for k, v in arrays.items() if k != "pair"}, "", None, pairs, None)
    with pytest.raises(DataError, match=r"bias \(3,\), expected"):
        SceneEvidence({**arrays, "bias": arrays["bias"][:3]}, "", None, pairs, None)


def test_text_without_scenes_is_read_as_it_is():
    with pytest.raises(ConfigError, match="scene_evidence=true"):
        BeliefLearner(partial(small_head), book(), steps=4, scene_evidence=True)
    with pytest.raises(ConfigError, match="scene_evidence=1: must be true or false"):
        BeliefLearner(partial(small_head), book(), steps=4, scene_evidence=1)


def test_entries_of_a_step_differ_in_category(data):
    entries = of_part(data, "train")
    batches = scene_fitting._batches(entries, 0, 8)
    assert sorted(e.id for batch in batches for e in batch) == sorted(e.id for e in entries)
    for batch in batches:
        assert len({e.category for e in batch}) == len(batch) <= 8
        assert len({e.scene for e in batch}) == 1
    assert [e.id for e in scene_fitting._batches(entries, 1, 8)[0]] != [e.id for e in batches[0]]


def test_each_entry_has_one_distribution():
    """The probabilities of places add up to 1 for each entry."""
    asked = SimpleNamespace(usual=torch.full((2, 2), 0.5), truth=torch.eye(2))
    loss = scene_fitting._places_loss(torch.tensor([[1.0, 0.0], [1.0, 3.0]]), asked, torch.tensor(0.0))
    assert float(loss) == pytest.approx(-(np.log(1.5 / 2) + np.log(3.5 / 5)) / 2)
