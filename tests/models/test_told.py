"""Stated contexts: which agents are given them, by which option, and how prompts and beliefs change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from models.agents.l3mvn import L3MVNAgent
from models.agents.lgx import LGXAgent
from models.agents.pixelnav import PixelNavAgent
from models.nets.belief.head_reader import HeadReader, default_head_reader
from tests.models.playing import config_of
from ucon.core.errors import EpisodeError
from ucon.envs.knowledge import HabitSource
from ucon.envs.ucon_env import UcONEnv
from ucon.language.models.encoder import EncoderModel
from ucon.perception.belief.from_habits import ReadHabits
from ucon.task.sets import load_episodes

EPISODES = load_episodes("mini", context=True)[:2]


def reset(level: str = "full", **source: bool):  # type: ignore[no-untyped-def]
    env = UcONEnv(EPISODES, habit_level=level, source=HabitSource(**source), observe="symbolic", detector=True)
    return env.reset(options={"episode": 0})


def test_a_context_is_told_as_sentence_and_value_unless_it_is_not_to_be() -> None:
    told, untold = reset()[1], reset(tell_context=False)[1]
    assert told["told"] == EPISODES[0].context
    assert told["context"] == EPISODES[0].context.sentence()
    assert untold["context"] is None
    assert "told" not in untold
    assert told["habits"] == untold["habits"]


@pytest.mark.parametrize(("option", "tells"), [("task.context=false", False), ("task.context=true", True)])
def test_the_option_of_the_task_decides(option: str, tells: bool) -> None:
    assert config_of("belief", option)["env"]["source"]["tell_context"] is tells


def test_retrieval_follows_what_is_told() -> None:
    sources = HabitSource(), HabitSource(tell_context=False)
    given = [[source.knowledge(one, "retrieval").rows.tolist() for one in EPISODES] for source in sources]
    assert given[0] != given[1]
    levels = [source.knowledge(EPISODES[0], "context").reranking.rows.tolist() for source in sources]
    assert levels == [rows[0] for rows in given]


@pytest.mark.parametrize("reader", [None, default_head_reader()])
def test_a_reader_that_is_told_expects_otherwise_and_one_that_is_not_as_ever(reader: HeadReader | None) -> None:
    told, untold = reset()[1], reset(tell_context=False)[1]
    locate = ReadHabits(reader)
    with_it, without = locate(told), locate(untold)
    assert with_it.names == without.names
    assert np.abs(with_it.p - without.p).max() > 1e-3
    assert with_it.p.sum() == pytest.approx(1.0, abs=0.05)
    assert with_it.relevance.max() <= 1.0
    plain = locate({name: untold[name] for name in ("target", "habits", "habit_level")})
    assert np.array_equal(plain.p, without.p)


@pytest.mark.parametrize("kind", [LGXAgent, PixelNavAgent, L3MVNAgent])
def test_language_agents_have_it_as_one_sentence_before_the_habits(kind: type[LGXAgent]) -> None:
    systems = {}
    for name, info in (("told", reset()[1]), ("untold", reset(tell_context=False)[1]), ("none", reset("none")[1])):
        agent = kind(EncoderModel())
        agent.start(0, info)
        systems[name] = agent._constant_prompt[0][2]
        assert len(agent._habit_weights[0]) == (len(info["habits"]) if name == "told" else 0)
    sentence = EPISODES[0].context.sentence()
    assert systems["told"].count(sentence) == 1
    assert systems["told"].replace(f"{sentence}\n\n", "") == systems["untold"]
    assert sentence in systems["none"]
    assert systems["told"].index(sentence) < systems["told"].index("<<<HABITS")


def test_the_encoder_counts_habits_by_their_weights() -> None:
    model, habits = EncoderModel(), ("The mug is kept on the desk.", "The mug is kept in the fridge.")
    logit = {w: [model.label_logit("mug", habits, w, label) for label in ("desk", "fridge")] for w in ((), (4.0, 0.1))}
    assert logit[(4.0, 0.1)][0] - logit[(4.0, 0.1)][1] > logit[()][0] - logit[()][1]


def test_a_user_whom_the_household_does_not_have_is_refused_in_one_line() -> None:
    stranger = replace(EPISODES[0], context=replace(EPISODES[0].context, user="Zaphod"))
    with pytest.raises(EpisodeError, match=r"unknown user 'Zaphod'") as found:
        HabitSource().knowledge(stranger, "full")
    assert "\n" not in str(found.value)
