"""BM25 against its formula, on three sentences."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ucon.habits import KnowledgeBase
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.retrieval import BM25Retriever

#: After removing stop words: 4 words with the mug twice, 2 with it once, 3 without.
SENTENCES = ("Mug beside mug, washed.", "The mug dried.", "Socks dry outside.")


@pytest.fixture(scope="module")
def kb() -> KnowledgeBase:
    habits = tuple(Habit(text, (0,)) for text in SENTENCES)
    entry = Entry("mug.1", "mug", "home", (Placement("ontop", "desk"),), habits)
    return KnowledgeBase(HabitDataset("three", (entry,)), np.arange(3, dtype=np.int32))


def score(times: int, words: int, k1: float, b: float) -> float:
    """BM25 of a sentence with ``words`` words and the name ``times`` times; 2 of 3 sentences have it, mean length 3."""
    idf = math.log(1 + (3 - 2 + 0.5) / (2 + 0.5))
    return idf * times / (times + k1 * (1 - b + b * words / 3))


@pytest.mark.parametrize("chosen", [{}, {"k1": 0.9, "b": 0.4}, {"k1": 2.0}, {"b": 0.0}])
def test_scores_are_the_formulas(kb: KnowledgeBase, chosen: dict[str, float]) -> None:
    constants = {"k1": 1.5, "b": 0.75} | chosen
    found = BM25Retriever(**chosen).scores("mug", kb)
    assert found == pytest.approx([score(2, 4, **constants), score(1, 2, **constants), 0.0], abs=1e-6)


def test_a_name_that_nobody_says_scores_nothing(kb: KnowledgeBase) -> None:
    retriever = BM25Retriever()
    assert retriever.scores("unicorn", kb).tolist() == [0.0, 0.0, 0.0]
    assert retriever.rank("unicorn", kb).tolist() == [0, 1, 2]


def test_names_of_several_words_add_up(kb: KnowledgeBase) -> None:
    retriever = BM25Retriever()
    both = retriever.scores("mug_socks", kb)
    assert both == pytest.approx(retriever.scores("mug", kb) + retriever.scores("socks", kb), abs=1e-6)


def test_it_ranks_without_a_word(kb: KnowledgeBase, capfd: pytest.CaptureFixture[str]) -> None:
    BM25Retriever().rank("mug", kb)
    assert capfd.readouterr() == ("", "")
