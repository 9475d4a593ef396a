"""Conditions of sentences, read in a stated context: learned from train entries, tested on held-out ones."""

import pickle
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from ucon.habits import contexts_book
from ucon.habits.contexts import Context, condition_of
from ucon.habits.knowledge import KnowledgeBase
from ucon.readers.anchor_reader import default_reader
from ucon.readers.conditions.calendar_words import days_named, hours_named, names_in, seasons_named
from ucon.readers.conditions.condition_reader import KINDS, Strength, default_conditions
from ucon.retrieval.bm25 import BM25Retriever
from ucon.retrieval.dense import DenseRetriever
from ucon.retrieval.told import ToldRetriever

SATURDAY = Context(day=5, hour=8, season="winter", occasion=None, asker="a family", user=None)
MONDAY = replace(SATURDAY, day=0)


@pytest.mark.parametrize(
    ("text", "days", "hours", "seasons"),
    [
        ("Monday to Friday it rides in the bag.", range(5), (), ()),
        ("From Friday to Sunday nobody may clear it at night.", (4, 5, 6), (22, 23, *range(6)), ()),
        ("On Saturdays and at weekends", (5, 6), (), ()),
        ("School mornings begin in July.", range(5), range(6, 10), (1,)),
        ("After supper in December I may go.", (), range(18, 22), (3,)),
        ("She springs up and marches off.", (), (), (0,)),
        ("The sun is on the day bed.", (), (), ()),
    ],
)
def test_words_of_the_calendar(text, days, hours, seasons):
    assert days_named(text) == set(days)
    assert hours_named(text) == set(hours)
    assert seasons_named(text) == set(seasons)


def test_people_are_capitalised_words_without_their_titles():
    assert names_in("Take it from old Mr Lindqvist or Cem.") == {"Take", "Lindqvist", "Cem"}


def holding(text, context):
    found = default_conditions().holding([text], context)
    return found.holds[0], found.fails[0]


def test_weekends_hold_on_a_saturday_and_fail_on_a_monday():
    text = "At weekends the mug stands on the desk beside the radio."
    (holds, fails), (holds_not, fails_then) = holding(text, SATURDAY), holding(text, MONDAY)
    assert holds[0] > 0.5 > fails[0]
    assert fails_then[0] > 0.5 > holds_not[0]


def test_a_sentence_that_names_the_user_holds_and_one_that_names_another_of_the_household_fails():
    asked = replace(SATURDAY, asker="Ines and Marta, sisters", user="Ines")
    for text, holds, fails in (
        ("Ines carries it in her bag.", 1, 0),
        ("Marta pushes it under the bed.", 0, 1),
        ("Marta lets Ines have it.", 1, 0),
        ("It is somewhere here.", 0, 0),
    ):
        found = holding(text, asked)
        assert (found[0][-1], found[1][-1]) == (holds, fails), text
    assert not holding("Ines carries it in her bag.", SATURDAY)[0][-1]


def test_conditions_of_held_out_people_are_read_right():
    """Share of sentences with the right weight: above 1 if their place is used in this context, below 1 if not."""
    right = defaultdict(list)
    data, calendar = contexts_book(), [SATURDAY, MONDAY, replace(MONDAY, hour=20, season="summer")]
    for entry in data.entries:
        for habit in entry.habits if entry.id in data.parts else ():
            told = entry.placements[habit.supports[0]].context if habit.supports else None
            if told is None:
                continue
            condition = condition_of(told)
            for now in calendar:
                here = replace(now, asker=entry.household, user=None, occasion=None)
                if condition.user:
                    here = replace(here, user=condition.user)
                weight = default_conditions().holding([habit.text], here).weights(Strength(2.0, 0.5))[0]
                right[condition.kinds[0]].append((weight > 1) == condition.holds(here))
    shares = {kind: np.mean(values) for kind, values in right.items()}
    assert shares["day"] > 0.85
    assert shares["season"] > 0.75
    assert shares["user"] > 0.9
    assert shares["time"] > 0.6


def test_no_weight_where_nothing_is_said():
    texts = ["It lies in the drawer.", "At weekends it lies on the desk."]
    weights = default_conditions().weights(texts, SATURDAY, "fitted")
    assert weights.shape == (2,)
    assert weights[1] > weights[0]
    assert default_conditions().weights([], SATURDAY, "fitted").shape == (0,)


def test_an_occasion_that_no_train_entry_names_can_be_told():
    told = replace(SATURDAY, occasion="hobby/origami")
    assert "hobby/origami" not in default_conditions().occasions
    holds = (
        default_conditions().holding(["For origami the scissors lie on the desk.", "It is on the desk."], told).holds
    )
    assert holds[0, KINDS.index("occasion")] > holds[1, KINDS.index("occasion")]


def household(category):
    data = contexts_book()
    entries = {
        name: [e for e in data.entries if e.category == name][:1]
        for name in (category, "bench", "umbrella", "bucket")
        if name in data.categories
    }
    return KnowledgeBase.build(data, entries, 0)


def test_the_fitted_reader_follows_the_told_day():
    base = household("shoulder_bag")
    reader, p = default_reader(), {}
    for name, context in (("untold", None), ("weekday", MONDAY), ("weekend", SATURDAY)):
        belief = reader.read("shoulder_bag", base.texts, context=context).belief(reader.known)
        p[name] = dict(zip(belief.candidates, belief.p, strict=True))
    assert p["weekend"]["wardrobe"] > p["untold"]["wardrobe"] > p["weekday"]["wardrobe"]
    assert p["weekday"]["desk"] > p["untold"]["desk"] > p["weekend"]["desk"]


@pytest.mark.parametrize("plain", [DenseRetriever(), BM25Retriever()])
def test_what_holds_is_retrieved_first(plain):
    base = household("shoulder_bag")
    holds = [k for k, text in enumerate(base.texts) if "weekend" in text and "shut it in" in text]
    before = plain.scores("shoulder_bag", base)
    saturday, monday = (ToldRetriever(plain, now).scores("shoulder_bag", base) - before for now in (SATURDAY, MONDAY))
    assert len(holds) == 1
    assert saturday[holds[0]] > monday[holds[0]] + 0.5 * before.std()


def test_the_query_names_occasion_and_user():
    base = household("wineglass")
    told = replace(SATURDAY, occasion="guests/visit", user="Vera")
    assert told.occasion_and_user == "when there is visit for Vera"
    assert SATURDAY.occasion_and_user == ""
    plain = DenseRetriever()
    assert not np.array_equal(plain.scores("wineglass", base), plain.scores("wineglass", base, told.occasion_and_user))


def test_the_shipped_reader_is_pickled_by_name():
    assert pickle.loads(pickle.dumps(default_conditions())) is default_conditions()
