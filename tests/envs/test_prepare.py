"""Every text that a retriever needs is encoded and kept on disk before episodes are played."""

import numpy as np
import pytest

from ucon.core.errors import ConfigError, EpisodeError
from ucon.envs.knowledge import HabitSource
from ucon.habits import book
from ucon.habits.types import HabitDataset
from ucon.language import MiniLM, StoredEncoder
from ucon.language.phrases import query_text
from ucon.retrieval import LEVELS, BM25Retriever, DenseRetriever, tuned_encoder
from ucon.sim.cache import load_house
from ucon.task.sets import load_episodes


class Counting:
    """An encoder of letter counts that notes the texts it is given."""

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


@pytest.mark.parametrize(("level", "asked"), [("none", 0), ("full", 0), ("gt", 0), ("retrieval", 1), ("context", 1)])
def test_a_retriever_is_prepared_where_a_level_ranks(level, asked, tmp_path):
    data = HabitDataset("some", book().entries[:2])
    source = HabitSource(data, DenseRetriever(StoredEncoder(counting := Counting(), folder=tmp_path)))
    source.prepare(level=level)
    assert bool(counting.texts) == bool(asked)


def test_a_retriever_of_words_has_nothing_to_prepare():
    HabitSource(HabitDataset("some", book().entries[:2]), BM25Retriever()).prepare(level="retrieval")


def test_at_least_one_habit_is_retrieved():
    episode = load_episodes("mini")[0]
    assert len(HabitSource(top_p=1).knowledge(episode, "retrieval").rows) == 1
    for top_p in (0, -1):
        with pytest.raises(ConfigError, match=f"top_p={top_p}, expected at least 1"):
            HabitSource(top_p=top_p)


def test_the_list_that_follows_what_is_seen_is_of_its_level_alone():
    episode, source = load_episodes("mini")[0], HabitSource(top_p=3)
    for level in LEVELS:
        told = source.knowledge(episode, level)
        assert (told.reranking is not None) == (level == "context")
    assert told.reranking.rows.tolist() == told.rows.tolist()


def test_a_dataset_that_the_episode_was_not_made_with_is_refused():
    with pytest.raises(EpisodeError, match="made with habits 'book'"):
        HabitSource(HabitDataset("some", book().entries[:2])).knowledge(load_episodes("mini")[0], "full")


def test_where_a_target_may_be_adds_up_and_holds_where_it_is():
    for episode in load_episodes("mini")[:8]:
        house = load_house(episode.scene)
        found = HabitSource().locations(episode, house)
        assert sum(p for _, _, p in found) == pytest.approx(1)
        places = [(relation, anchor) for relation, anchor, _ in found]
        assert places == sorted(set(places))
        target = episode.target_object
        names = [*house.categories, *(thing.category for thing in episode.arrangement.objects)]
        assert (target.relation, names[target.anchor]) in places


def test_the_weights_that_decide_are_named():
    frozen, tuned = HabitSource(), HabitSource(retriever=DenseRetriever(tuned_encoder()))
    assert frozen.weights("retrieval") == (MiniLM().name, MiniLM().name)
    assert tuned.weights("retrieval") == tuned.weights("context") == (MiniLM().name, tuned_encoder().name)
    assert tuned.weights("full") == frozen.weights("none") == (MiniLM().name,)
    assert HabitSource(retriever=BM25Retriever()).weights("retrieval") == (MiniLM().name,), "it has none"
