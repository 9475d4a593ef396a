"""Scores make an answer; scores that are not numbers make none."""

import numpy as np
import pytest

from ucon.language.choice import LEAST, from_scores


def test_scores_are_log_probabilities_and_ties_fall_to_the_first():
    answer = from_scores(np.array([1.0, 2.0 + 1e-9, 2.0]), seconds=0.5)
    assert (answer.choice, answer.seconds, answer.failure) == (1, 0.5, "")
    assert np.exp(answer.scores).sum() == pytest.approx(1, abs=1e-3)
    assert from_scores(np.zeros(3)).choice == 0
    assert from_scores(np.array([-1e9])).scores == (0.0,)


@pytest.mark.parametrize("bad", [[np.nan, 1.0], [np.inf, 1.0], [-np.inf, -np.inf]])
def test_what_is_no_number_is_no_answer(bad):
    answer = from_scores(np.array(bad))
    assert (answer.choice, answer.scores, answer.failure) == (-1, (), "unusable")


def test_the_impossible_stays_finite():
    assert from_scores(np.array([0.0, -np.inf])).scores == (0.0, LEAST)
