"""Training data of the condition reader: sentences of train entries in contexts where their conditions hold or fail.

A sentence that supports a place is labelled by that place's condition. Distractors are left out: they name no place, so
nothing depends on when they hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.rng import stream
from ucon.habits.contexts import Condition, Context, between, condition_of, draw_context
from ucon.habits.splits import Split, entry_parts
from ucon.habits.types import HabitDataset
from ucon.language.words import stems
from ucon.readers.conditions.condition_reader import KINDS

#: Number of contexts in which a sentence with a condition is shown.
N_CONTEXTS: Final = 6
#: Probability that a context has the sentence's own occasion, and that it has another one.
OWN_P, OTHER_P = 0.35, 0.3
#: Probability that a context fulfils the day, hour and season of the sentence.
HOLDS_P: Final = 0.5
_TRIES: Final = 100
#: Words of contexts that name no particular occasion.
_PLAIN: Final = frozenset(
    stems("day days night nights week weeks before after when time the a of with in season afternoons evening morning")
)


@dataclass(frozen=True)
class Said:
    """A sentence that supports a place, with the condition under which it does."""

    text: str
    condition: Condition | None
    category: str


def said_in(dataset: HabitDataset, part: Split) -> list[Said]:
    """The supporting sentences of a part's entries."""
    parts = entry_parts(dataset)
    return [
        Said(
            habit.text,
            None if (told := entry.placements[habit.supports[0]].context) is None else condition_of(told),
            entry.category,
        )
        for entry in dataset.entries
        if parts[entry.id] == part
        for habit in entry.habits
        if habit.supports
    ]


def known_occasions(dataset: HabitDataset) -> tuple[list[str], list[frozenset[str]]]:
    """Occasions of the train entries, in alphabetical order, and the stems by which these entries name each.

    Args:
        dataset: whose contexts are read.
    """
    parts, words = entry_parts(dataset), dict[str, set[str]]()
    for entry in dataset.entries:
        for place in entry.placements if parts[entry.id] == "train" else ():
            if place.context and (occasion := condition_of(place.context).occasion):
                known = words.setdefault(occasion, set(stems(occasion.replace("/", " ").replace("-", " "))))
                known |= set(stems(place.context))
    names = sorted(words)
    return names, [frozenset(words[name] - _PLAIN) for name in names]


def has_conditions(said: Sequence[Said]) -> NDArray[np.float64]:
    """(n, 4) 1 where a sentence's place has a condition of a kind."""
    return np.asarray([[part is not None for part in _parts(one.condition)] for one in said], np.float64)


def labels(condition: Condition | None, context: Context) -> tuple[int, ...]:
    """By kind: 0 where a condition holds, 1 where it fails, 2 where there is none."""
    one = condition or Condition()
    right = (
        one.days is not None and context.day in one.days,
        one.hours is not None and between(context.hour, *one.hours),
        one.seasons is not None and context.season in one.seasons,
        one.occasion == context.occasion,
    )
    return tuple(2 if part is None else int(not holds) for part, holds in zip(_parts(condition), right, strict=True))


def shown_in(said: Sequence[Said], occasions: Sequence[str], seed: int) -> list[tuple[int, Context]]:
    """Contexts in which sentences are shown: several where they have a condition, else one.

    Args:
        said: n sentences.
        occasions: that may be told.
        seed: of the draws.

    Returns:
        Number of the sentence, and a context.
    """
    return [
        (number, _drawn(one.condition, occasions, rng))
        for number, one in enumerate(said)
        for rng in [stream(seed, "conditions", number)]
        for _ in range(N_CONTEXTS if one.condition else 1)
    ]


def _drawn(condition: Condition | None, occasions: Sequence[str], rng: np.random.Generator) -> Context:
    """A context; half of them fulfil the day, hour and season of the condition."""
    own, pick = None if condition is None else condition.occasion, rng.random()
    occasion = None
    if own and pick < OWN_P:
        occasion = own
    elif pick < OWN_P + OTHER_P:
        occasion = occasions[int(rng.integers(len(occasions)))]
    context = draw_context(rng, (), "somebody")
    if condition is not None and rng.random() < HOLDS_P:
        calendar = Condition(condition.days, condition.hours, condition.seasons)
        some = (draw_context(rng, (), "somebody") for _ in range(_TRIES))
        context = next((one for one in some if calendar.holds(one)), context)
    return replace(context, occasion=occasion)


def _parts(condition: Condition | None) -> tuple[object, ...]:
    """The parts of a condition, in the order of ``KINDS``."""
    if condition is None:
        return (None,) * len(KINDS)
    return condition.days, condition.hours, condition.seasons, condition.occasion
