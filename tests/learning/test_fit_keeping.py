"""The fit maximises the model's own likelihood of places, and finds better weights than its starting point."""

import numpy as np
import pytest
import torch

from ucon.fitting.language.location_cases import LABELS, PLACES, THINGS, asked, place_cases
from ucon.fitting.language.location_model import _Batch, fit, measured, target_scores, weights_of
from ucon.language.models.encoder import EncoderModel
from ucon.language.models.keeping import LocationWeights
from ucon.language.phrases import phrase
from ucon.retrieval.levels import FIXED_LEVELS
from ucon.sim.cache import load_house
from ucon.task.sets import load_episodes

START = LocationWeights(8.8, 0.4, 0.02, 0.45, 0.06, 0.7, 0.05)


@pytest.fixture(scope="module")
def found():
    return place_cases("mini", 12)


def point(w):
    logs = np.log([w.sigma, w.weight, w.doubt])
    return np.array([w.like, w.other, np.log(w.about), w.named, *logs])


def mean_nats(found, weights):
    model = EncoderModel(keeping=weights)
    by_level = [target_scores(found, level, model) for level in FIXED_LEVELS]
    return np.mean([np.logaddexp.reduce(scores, 1) - scores[:, 0] for scores in by_level])


def test_a_point_and_its_weights():
    assert weights_of(point(START)) == START


def test_the_batch_says_what_the_model_says(found):
    for w in (LocationWeights(), START, LocationWeights(5.0, 0.2, 0.1, 0.3, 0.2, 1.5, 0.7)):
        x = torch.tensor(point(w), dtype=torch.float32)
        assert float(_Batch(found).loss(x)) == pytest.approx(mean_nats(found, w), abs=2e-3)


def test_it_finds_better_weights(found):
    weights = fit(found)
    assert mean_nats(found, weights) < mean_nats(found, START) - 0.01
    lines = measured(found, weights)
    assert [line.split(":")[0] for line in lines] == [*FIXED_LEVELS, "uniform"]


def test_places_are_those_of_the_home(found):
    episodes = {episode.id: episode for episode in load_episodes("mini")}
    for case in found:
        episode = episodes[case.id]
        house = load_house(episode.scene)
        placed = [thing.category for thing in episode.arrangement.objects]
        standing = {phrase(name) for name in (*house.categories[: house.n_items], *placed)}
        names = [*house.categories, *placed]
        assert len(case.places) == PLACES
        assert case.labels[0] == phrase(episode.target_category)
        assert len(set(case.labels)) == LABELS
        for place in case.places:
            assert 0 < len(set(place)) == len(place) <= THINGS
            assert case.labels[0] not in place
            assert set(place) <= standing
        if len(case.places[0]) < THINGS and episode.target_object.holder < 0:
            assert phrase(names[episode.target_object.anchor]) in case.places[0]
        assert [question.things for question in asked(case, "gt")] == list(case.places)
