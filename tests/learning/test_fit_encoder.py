"""The fit maximises the model's own likelihood, and finds better weights than its starting point."""

import numpy as np
import pytest
import torch

from ucon.fitting.language.language_encoder import _Batch, cases, fit, four_options, measured, nats, single
from ucon.language.models.encoder import EncoderModel, EncoderWeights
from ucon.retrieval.levels import FIXED_LEVELS


@pytest.fixture(scope="module")
def found():
    return cases("mini", 12)


def mean_nats(found, weights):
    model = EncoderModel(weights)
    return np.mean([nats(model, [single(case, level) for case in found]) for level in FIXED_LEVELS])


def test_the_batch_says_what_the_model_says(found):
    for w in (EncoderWeights(), EncoderWeights(beta=0.7, tau=0.2, tau_none=0.5, tau_habit=0.1, sigma=0.2)):
        x = torch.tensor([w.beta, *np.log([w.tau, w.tau_none, w.tau_habit, w.sigma])], dtype=torch.float32)
        assert float(_Batch(found).loss(x)) == pytest.approx(mean_nats(found, w), abs=2e-3)


def test_it_finds_better_weights(found):
    weights = fit(found)
    assert mean_nats(found, weights) < mean_nats(found, EncoderWeights(1.0, 0.1, 1.0, 0.06, 0.06)) - 0.01
    assert weights.empty > 0
    assert len(measured(found, weights)) == 4


def test_a_home_is_shared_out_among_four_options(found):
    for case in found:
        question, right = four_options(case, "none")
        labels = [label for option in question.options for label in option.labels]
        assert sorted(labels) == sorted(case.categories)
        assert case.categories[case.right] in question.options[right].labels
        few, same = four_options(case, "none", 3)
        assert same == right
        assert case.categories[case.right] in few.options[right].labels
        assert max(len(option.labels) for option in few.options) == 3
        assert four_options(case, "none", hide=True)[0].options[0].labels == ()
