"""Records of choices made by a model, and the habits that a model gets at level ``context``, in whole searches."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.models.playing import episodes, gone, play
from tests.models.test_asking_agents import MAKERS, home
from ucon.language.models.encoder import EncoderModel
from ucon.language.prompt import neutral
from ucon.retrieval.context import ContextHabits


@pytest.mark.parametrize("name", ["lgx", "lgx_object", "pixelnav"])
def test_a_record_says_which_option_was_answered_and_what_did_not_fit(name: str) -> None:
    """Two habits are dropped from each answer, and every third answer cannot be used."""
    agent = MAKERS[name](model := EncoderModel())
    answer, asked = model.answer, []

    def short(questions):  # type: ignore[no-untyped-def]
        asked.extend(questions)
        lost = len(asked) % 3 == 0
        return [replace(a, dropped=2, choice=-1 if lost else a.choice) for a in answer(questions)]

    model.answer = short  # type: ignore[method-assign]
    play(agent, home(), gone(episodes(1)[0]), 200)
    made = [d for d in agent.decisions(0) if d.asked]
    assert len(made) == len(asked) > 3
    for decision, question in zip(made, asked, strict=True):
        assert decision.dropped == 2
        assert (decision.answered == -1) == decision.fallback
        assert decision.options == tuple(o.name for o in question.options)
        if not decision.fallback:
            assert decision.scores[decision.answered] == max(decision.scores)
    assert 0 < sum(d.fallback for d in made) < len(made)


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("level", ["context", "retrieval"])
def test_at_level_context_what_was_seen_changes_what_is_told(
    name: str, level: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only detected things change the list; the prompt has the list as it is when the question is asked."""
    told: list[set[str]] = []
    update = ContextHabits.update

    def heard(self: ContextHabits, seen: set[str], emptied: dict[str, float]) -> bool:
        told.append(set(seen))
        assert emptied == {}
        return update(self, seen, emptied)

    monkeypatch.setattr(ContextHabits, "update", heard)
    agent, env = MAKERS[name](EncoderModel()), home(level=level)
    asked, questions = [], agent.questions
    agent.questions = lambda d, s: (asked.append(questions(d, s)), asked[-1])[1]
    obs, info = env.reset(options={"episode": gone(episodes(1)[0])})
    first_list, ranking = tuple(info["habits"]), info.get("reranking")
    agent.reset([info])
    detected: set[str] = set()
    for _ in range(100):
        detected |= set(info["detections"].category)
        before = len(asked)
        (action,) = agent.act([obs], [info])
        assert all(seen <= detected for seen in told)
        for question in (q for made in asked[before:] for q in made):
            assert question.habits == (ranking.texts if ranking else first_list)
            assert all(neutral(habit) in question.system for habit in question.habits)
        obs, _, _, _, info = env.step(action)
    lists = {question.habits for made in asked for question in made}
    assert (len(lists - {first_list}) > 0) == (level == "context") == bool(told)
