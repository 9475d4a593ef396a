"""Questions asked in seeded orders: options keep their scores, and the mean of two orders favours no position."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.language.tiny_models import NAMES, PROMPT, question, save_causal
from ucon.core.errors import ConfigError
from ucon.language.choice import Answer
from ucon.language.models.causal_lm import CausalModel
from ucon.language.models.orders import Orders, averaged, in_order
from ucon.language.prompt import Prompt


def listing(names=NAMES, target="wallet"):
    """A question whose message can list its options in any order."""
    asked, prompt = question(names=names, target=target), Prompt.parse(PROMPT)
    return replace(
        asked, listed=lambda order: prompt.situation(target=target, options=", ".join(names[k] for k in order))
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return str(save_causal(tmp_path_factory.mktemp("tiny") / "llama"))


def test_an_order_depends_on_the_seed_and_the_question_alone():
    asked = [listing(target=f"thing {n}") for n in range(300)]
    first = [Orders(1, 0).of(one) for one in asked]
    assert first == [Orders(1, 0).of(one) for one in asked]
    assert first != [Orders(1, 1).of(one) for one in asked]
    assert all(sorted(order) == [0, 1, 2, 3] for (order,) in first)
    where = np.array([order for (order,) in first])
    for place in range(4):  # each option is at each place about a quarter of the time
        assert np.bincount(where[:, place], minlength=4) / 300 == pytest.approx(np.full(4, 0.25), abs=0.1)
    for one, (order,) in zip(asked, first, strict=True):
        assert Orders(2, 0).of(one) == [order, order[::-1]]


def test_what_lists_nothing_or_one_option_is_asked_as_it_is():
    assert Orders(2).of(question()) == [(0, 1, 2, 3)]
    assert Orders(2).of(listing(NAMES[:1])) == [(0,)]
    assert Orders(0).of(listing()) == [(0, 1, 2, 3)]
    asked = listing()
    assert in_order(asked, (0, 1, 2, 3)) is asked


@pytest.mark.parametrize("count", [-1, 3, True, 1.0, "2"])
def test_other_numbers_of_orders_are_refused(count):
    with pytest.raises(ConfigError, match=r"language\.orders=.*expected 0, 1 or 2") as caught:
        CausalModel("tiny", orders=count)
    assert "\n" not in str(caught.value)


def test_an_answer_is_told_in_the_questions_own_order(folder):
    """The answer in the seeded order equals that to a question that lists its options in this order."""
    asked = [listing(target=f"thing {n}") for n in range(6)]
    seeded, as_listed = CausalModel(folder, orders=1, seed=3), CausalModel(folder)
    for one, answer in zip(asked, seeded.answer(asked), strict=True):
        (order,) = Orders(1, 3).of(one)
        told = in_order(one, order)
        assert told.situation != one.situation or order == (0, 1, 2, 3)
        assert [o.name for o in told.options] == [NAMES[k] for k in order]
        (other,) = as_listed.answer([told])
        assert [answer.scores[k] for k in order] == pytest.approx(other.scores, abs=1e-3)
        assert answer.choice == order[other.choice]
        assert answer.places == other.places == (other.choice,)


def test_two_orders_are_averaged(folder):
    one = listing()
    (answer,) = CausalModel(folder, orders=2).answer([one])
    orders = Orders(2).of(one)
    parts = CausalModel(folder).answer([in_order(one, order) for order in orders])
    by_option = [np.exp(part.scores)[np.argsort(order)] for order, part in zip(orders, parts, strict=True)]
    assert np.exp(answer.scores) == pytest.approx(np.mean(by_option, axis=0), abs=2e-3)
    assert answer.places == tuple(part.choice for part in parts)
    assert answer.prompt_tokens == sum(part.prompt_tokens for part in parts)
    assert CausalModel(folder, orders=2).name == "causal (llama, two orders)"


def test_a_model_that_knows_places_alone_is_left_without_a_preference():
    """A model that always gives .7 to the first place: asked in two orders, the options listed first share it."""
    by_place = tuple(np.log([0.7, 0.2, 0.1]).tolist())
    both = averaged([(2, 0, 1), (1, 0, 2)], [Answer(0, by_place), Answer(0, by_place)])
    assert np.exp(both.scores) == pytest.approx([0.2, 0.4, 0.4], abs=1e-3)
    assert both.places == (0, 0)  # the first place both times, so not the same option
    lost = averaged([(0, 1), (1, 0)], [Answer(0, (-0.1, -2.4)), Answer(-1, failure="too long")])
    assert (lost.choice, lost.failure, lost.scores) == (-1, "too long", ())


def test_what_is_asked_beside_changes_no_order(folder):
    model = CausalModel(folder, orders=2)
    asked = [listing(target=f"thing {n}") for n in range(4)]
    together = model.answer(asked)
    alone = [model.answer([one])[0] for one in asked]
    for a, b in zip(together, alone, strict=True):
        assert a.scores == pytest.approx(b.scores, abs=2e-4)
        assert a.places == b.places
