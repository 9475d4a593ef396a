"""What an agent may choose: one of the candidates, with a score for every option or for none."""

from __future__ import annotations

import pytest

from models.agents.waypoint import Chosen, _check
from ucon.core.errors import ConfigError


@pytest.mark.parametrize("number", [0, 2])
def test_every_candidate_may_be_chosen(number: int) -> None:
    _check("mine", Chosen(number), 3)
    _check("mine", Chosen(number, scores=(0.1, 0.2, 0.3)), 3)
    _check("mine", Chosen(number, options=("a", "b"), scores=(0.1, 0.2)), 3)


@pytest.mark.parametrize("number", [-1, 3])
def test_candidates_count_from_zero(number: int) -> None:
    with pytest.raises(ConfigError, match=f"agent mine chose number {number} of 3 candidates"):
        _check("mine", Chosen(number), 3)


@pytest.mark.parametrize("scores", [(0.1,), (0.1, 0.2, 0.3, 0.4)])
def test_scores_are_of_all_options(scores: tuple[float, ...]) -> None:
    with pytest.raises(ConfigError, match=f"gives {len(scores)} scores for 3 options"):
        _check("mine", Chosen(0, scores=scores), 3)
    with pytest.raises(ConfigError, match="scores for 2 options"):
        _check("mine", Chosen(0, options=("a", "b"), scores=(0.1, 0.2, 0.3)), 3)


def test_a_choice_is_the_models_own_unless_it_says_otherwise() -> None:
    assert not Chosen(0).fallback
