"""A belief learner on a part of the habit book, read by the fitted reader, that is quick to make."""

from functools import partial

from models.nets.belief.belief_head import BeliefHead
from tests.learning.tiny import some_habits
from ucon.language.pairs import default_pair_reader
from ucon.learning.belief_head.draws import Draw
from ucon.learning.belief_head.held_out_readers import Fold
from ucon.learning.belief_head.learner import BeliefLearner
from ucon.readers.household import FittedParts
from ucon.readers.reader_weights import default_weights


def plain_parts() -> FittedParts:
    return FittedParts(default_weights(), default_pair_reader())


def small_head(**options):
    return BeliefHead(**{"width": 16, "heads": 2, "channels": 2, "hidden": 8, **options})


def tiny_belief(**options) -> BeliefLearner:
    parts = plain_parts()
    standard = {"steps": 6, "n_kbs": 1, "households": 1, "draw": Draw(targets=4, clutter=5), "warm_up": 2}
    standard |= {"folds": [Fold(some_habits(12), parts), Fold(some_habits(17), parts)]}
    head = partial(small_head, **options.pop("head", {}))
    return BeliefLearner(head, some_habits(6), parts=parts, **{**standard, **options})
