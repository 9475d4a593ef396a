"""Successful searches as demonstrations, by an agent that is given the habits of the policy's level."""

from __future__ import annotations

import functools
from pathlib import Path

import pytest

from models.agents.belief import BeliefAgent
from models.agents.checkpoint import UNTRAINED
from models.agents.frontier import FrontierAgent
from tests.learning.tiny_policy import tiny_dagger, tiny_imitation
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.learning.imitation.demonstrators import AgentDemonstrator, SolutionDemonstrator
from ucon.learning.imitation.replaying import Replayer
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

ENV = functools.partial(UcONEnv, "mini", observe="pixels", detector=True)


def mini() -> tuple[Episode, ...]:
    return load_episodes("mini")[:4]


def test_searches_end_in_success_and_can_be_played_again() -> None:
    shown = AgentDemonstrator(BeliefAgent(), ENV)
    found = [shown(episode, "retrieval") for episode in mini()]
    assert any(t.actions != t.episode.solution for t in found), "nothing was searched for"
    for trajectory in found:
        assert trajectory.labels == trajectory.actions
        env = ENV()
        env.reset(seed=0, options={"episode": trajectory.episode, "habit_level": trajectory.level})
        *_, info = [env.step(int(digit)) for digit in trajectory.actions][-1]
        assert info["episode_metrics"]["success"]


def test_who_finds_nothing_shows_the_stored_solution() -> None:
    class Idle:
        name = "idle"

        def reset(self, infos, slots=None):
            pass

        def act(self, observations, infos, slots=None):
            return [1 for _ in infos]

    episode = mini()[0]
    assert AgentDemonstrator(Idle(), ENV)(episode, "none") == SolutionDemonstrator()(episode, "none")


def test_what_it_does_depends_on_what_it_is_told() -> None:
    reads, explores = (AgentDemonstrator(agent, ENV) for agent in (BeliefAgent(), FrontierAgent()))
    same = {True: 0, False: 0}
    for shown, told in ((reads, True), (explores, False)):
        same[told] = sum(shown(e, "none").actions == shown(e, "gt").actions for e in mini())
    assert same[False] == len(mini()) > same[True]


def test_a_run_learns_from_it_and_repeats_itself(tmp_path: Path) -> None:
    learners = [tiny_imitation(tmp_path, demonstrator=AgentDemonstrator(BeliefAgent(), ENV)) for _ in range(2)]
    first, second = ([learner.step() for _ in range(2)] for learner in learners)
    assert first == second
    plain = tiny_imitation(tmp_path)
    assert first[0]["frames"] != plain.step()["frames"]
    assert learners[0].identity["demonstrator"].startswith("belief")
    assert "demonstrator" not in plain.identity
    assert "what the agent belief does" in learners[0].card().text


def test_what_was_seen_is_what_was_shown(tmp_path: Path) -> None:
    learner = tiny_imitation(tmp_path, demonstrator=AgentDemonstrator(FrontierAgent(), ENV))
    learner.step()
    trajectory = learner.demonstrator(*learner.assigned(0))
    assert len(Replayer(learner.act, ENV)(trajectory)) == len(trajectory.actions)


def test_each_is_played_once_and_later_runs_know_its_actions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    shown = AgentDemonstrator(BeliefAgent(), ENV)
    figures = [tiny_imitation(tmp_path, demonstrator=shown).step()]
    (file,) = (tmp_path / "cache" / "demonstrations").iterdir()
    lines = file.read_text().splitlines()
    assert len(lines) == 3
    monkeypatch.setattr(AgentDemonstrator, "__call__", None)  # playing again would fail
    figures.append(tiny_imitation(tmp_path, demonstrator=AgentDemonstrator(BeliefAgent(), ENV)).step())
    monkeypatch.undo()
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    file.write_text("\n".join([lines[0], "[1]", lines[1], lines[2][:-4]]))  # the last one was not fully written
    figures.append(tiny_imitation(tmp_path, demonstrator=AgentDemonstrator(BeliefAgent(), ENV)).step())
    assert figures[0] == figures[1] == figures[2]
    assert file.read_text().splitlines()[-1] == lines[2]


def test_where_nothing_can_be_written_learning_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / "demonstrations").write_text("in the way")
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    figures = tiny_imitation(tmp_path, demonstrator=AgentDemonstrator(BeliefAgent(), ENV)).step()
    assert figures["frames"] > 0


def test_another_agent_has_other_demonstrations_and_some_cannot_be_kept() -> None:
    class Local:
        name = "local"

        def reset(self, infos, slots=None):
            pass

        def act(self, observations, infos, slots=None):
            return [1 for _ in infos]

    keys = [AgentDemonstrator(agent, ENV).cache_key() for agent in (BeliefAgent(), BeliefAgent(), FrontierAgent())]
    assert keys[0] == keys[1] != keys[2]
    assert AgentDemonstrator(Local(), ENV).cache_key() == ""


def test_what_is_no_agent_and_who_has_no_weights_is_said(tmp_path: Path) -> None:
    from models.agents.habit_policy import HabitPolicyAgent
    from models.habit_policy import HabitPolicy

    with pytest.raises(ConfigError, match=r"learner.demonstrator.agent: SolutionDemonstrator is no agent"):
        AgentDemonstrator(SolutionDemonstrator(), ENV)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="no trained weights"):
        AgentDemonstrator(HabitPolicyAgent(HabitPolicy()), ENV)
    assert "untrained" in AgentDemonstrator(HabitPolicyAgent(HabitPolicy(), UNTRAINED), ENV).fingerprint()
    with pytest.raises(ConfigError, match=r"learner.demonstrator: only for learner=imitation"):
        tiny_dagger(tmp_path, demonstrator=SolutionDemonstrator())
