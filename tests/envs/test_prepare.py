"""Before episodes are played, every text that a retriever will want has been encoded and kept on disk."""

import numpy as np

from ucon.envs.knowledge import HabitSource
from ucon.habits import book
from ucon.habits.types import HabitDataset
from ucon.language import MiniLM, StoredEncoder
from ucon.retrieval import BM25Retriever, DenseRetriever, query_text, tuned_encoder


class Counting:
    """An encoder of word counts that counts what it is asked for."""

    name, dim = "counting", 8

    def __init__(self):
        self.texts = []

    def encode(self, texts):
        self.texts += texts
        return np.asarray([[text.count(letter) + 1 for letter in "aeioutnr"] for text in texts], np.float32)


def test_the_retrievers_own_encoder_is_prepared(tmp_path):
    data = HabitDataset("some", book().entries[:12])
    source = HabitSource(data, DenseRetriever(StoredEncoder(first := Counting(), folder=tmp_path)))
    told = []
    source.prepare(lambda done, total: told.append((done, total)), "retrieval")
    assert set(first.texts) == {*data.texts, *map(query_text, data.categories)}
    assert told[-1][0] == told[-1][1]
    assert max(total for _, total in told) == len(set(data.texts))
    later = StoredEncoder(second := Counting(), folder=tmp_path)
    HabitSource(data, DenseRetriever(later)).prepare(level="retrieval")
    assert not second.texts


def test_the_weights_that_decide_are_named():
    frozen, tuned = HabitSource(), HabitSource(retriever=DenseRetriever(tuned_encoder()))
    assert frozen.weights("retrieval") == (MiniLM().name, MiniLM().name)
    assert tuned.weights("retrieval") == tuned.weights("context") == (MiniLM().name, tuned_encoder().name)
    assert tuned.weights("full") == frozen.weights("none") == (MiniLM().name,)
    assert HabitSource(retriever=BM25Retriever()).weights("retrieval") == (MiniLM().name,), "it has none"
