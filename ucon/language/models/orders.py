"""The order in which a question lists its options, and the mean of its answers in several orders.

Small models choose by an option's place in the list nearly as much as by the option itself (Zheng et al., "Large
language models are not robust multiple choice selectors", ICLR 2024). A seeded order keeps an option from always having
the same place; a question asked in an order and in its reverse is answered by the mean of both probabilities.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from ucon.core.errors import ConfigError, brief
from ucon.core.rng import stream
from ucon.language.choice import Answer, Question, from_scores

Order = tuple[int, ...]
"""Numbers of options, in the order in which they are listed."""
#: Largest :attr:`Orders.count`.
MOST: Final = 2


@dataclass(frozen=True)
class Orders:
    """How often a question is asked, and in which orders."""

    count: int = 0
    """0: once, as the agent lists the options; 1: once, in a seeded order; 2: in that and in its reverse."""
    seed: int = 0

    def __post_init__(self) -> None:
        if type(self.count) is not int or not 0 <= self.count <= MOST:
            raise ConfigError(f"language.orders={brief(self.count)}: expected 0, 1 or {MOST}")

    def of(self, question: Question) -> list[Order]:
        """The orders in which a question is asked; only its own order where its list cannot be rewritten.

        Args:
            question: its text decides the order, so that other questions do not change it.
        """
        n = len(question.options)
        if not self.count or n < 2 or question.listed is None:
            return [tuple(range(n))]
        draw = stream(self.seed, "order of options", question.system, question.situation)
        order = tuple(draw.permutation(n).tolist())
        return [order, order[::-1]][: self.count]


def in_order(question: Question, order: Order) -> Question:
    """A question with its options in an order."""
    if question.listed is None or order == tuple(range(len(order))):
        return question
    return replace(
        question, options=tuple(question.options[k] for k in order), situation=question.listed(order), listed=None
    )


def averaged(orders: Sequence[Order], answers: Sequence[Answer]) -> Answer:
    """The answer whose probabilities are the means of those in each order.

    Args:
        orders: of one question.
        answers: one in each of them.

    Returns:
        Choice and scores refer to the question's own list; no choice if one of the answers has none. Tokens and seconds
        are added up.
    """
    spent: dict[str, Any] = {
        "prompt_tokens": sum(a.prompt_tokens for a in answers),
        "seconds": sum(a.seconds for a in answers),
        "dropped": max(a.dropped for a in answers),
    }
    if lost := next((a for a in answers if a.choice < 0), None):
        return Answer(-1, failure=lost.failure, **spent)
    places = tuple(a.choice for a in answers)
    if len(orders) == 1:  # exactly the answer, without rounding
        by_option = dict(zip(orders[0], answers[0].scores, strict=True))
        scores = tuple(by_option[k] for k in range(len(by_option)))
        return Answer(orders[0][places[0]], scores, places=places, **spent)
    own_order = [np.array(a.scores)[np.argsort(order)] for order, a in zip(orders, answers, strict=True)]
    return from_scores(np.logaddexp.reduce(own_order), places=places, **spent)
