"""DAgger: what is collected, who acts, and that it can be stopped anywhere."""

import dataclasses
import functools
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
import torch

from models.agents.belief import BeliefAgent
from tests.learning.test_imitation import files
from tests.learning.tiny_policy import ENV, Stays, TinyPolicy, on_a_gpu, tiny_dagger
from ucon.core.errors import ConfigError, DataError
from ucon.learning.imitation.dagger import DaggerRollouts
from ucon.learning.imitation.demonstrators import AgentDemonstrator
from ucon.learning.imitation.experts import SearchingExpert
from ucon.learning.imitation.feeding import _unpacked
from ucon.learning.imitation.replaying import Replayer
from ucon.learning.run.training_run import Plan, TrainingRun
from ucon.task.actions import Action
from ucon.task.expert import Expert

#: The environment that searching agents need.
SHOWN = functools.partial(ENV, detector=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("episodes")


@pytest.fixture
def learner(folder):
    return functools.partial(tiny_dagger, folder)


def test_the_first_collection_is_the_expert_s(learner):
    found = learner(rollouts={"max_steps": 60})
    figures = found.step()
    assert len(found.collected) == figures["collected"] == 4
    for one in found.collected:
        assert one.actions == one.labels
        moves = one.actions.count(str(int(Action.MOVE_AHEAD)))
        assert moves * 0.25 == one.episode.shortest_path_m
        assert len(one.actions) <= len(one.episode.solution)
    assert figures["labels"] == sum(len(one.actions) for one in found.collected)


def test_a_share_begins_near_the_end_of_the_solution(learner):
    found = learner(rollouts={"episodes": 12, "backplay": 1.0, "backplay_steps": 9})
    found.step()
    left = []
    for one in found.collected:
        assert one.episode.solution.startswith(one.led)
        left.append(len(one.episode.solution) - len(one.led))
        assert one.actions == one.labels
        assert len(one.actions) <= left[-1]
        assert one.actions[-1] == str(int(Action.DONE))
    assert len(set(left)) > 3
    assert 1 <= min(left) <= max(left) <= 9
    half = learner(rollouts={"backplay": 0.5, "backplay_steps": 5})
    assert 70 < sum(bool(half.job(item).led) for item in range(200)) < 130


def test_later_ones_stray_and_every_step_is_labelled_by_the_expert(learner):
    found = learner(rollouts={"mixture": 0.3})
    for _ in range(7):
        found.step()
    assert len(found.collected) == 12
    strayed = [one for one in found.collected[4:] if one.actions != one.labels]
    assert len(strayed) >= 6
    env, done = ENV(), str(int(Action.DONE))
    for one in found.collected:
        env.reset(options={"episode": one.episode})
        expert = Expert(one.episode)
        for digit, label in zip(one.actions, one.labels, strict=True):
            assert str(int(expert.action(env.search))) == label
            env.step(int(digit))
        assert done not in one.actions[:-1]
        assert one.actions[-1:] != done or one.labels[-1:] == done, "a Done that fails was carried out"
    shares = [sum(a == b for a, b in zip(one.actions, one.labels, strict=True)) / len(one.labels) for one in strayed]
    assert min(shares) > 0, "the expert has a share in the actions"


def test_an_agent_that_searches_says_what_it_would_do_wherever_the_policy_went(learner):
    found = learner(rollouts={"mixture": 0.3, "max_steps": 60}, expert=SearchingExpert(BeliefAgent()), env=SHOWN)
    for _ in range(4):
        found.step()
    first, later = found.collected[:4], found.collected[4:]
    for one in first:  # equal to its play without a policy
        played = AgentDemonstrator(BeliefAgent(), SHOWN)(one.episode, one.level)
        assert one.actions == one.labels == played.actions[:60] or played.actions == one.episode.solution
    assert any(one.actions != one.labels for one in later)
    assert all(label != "." for one in later for label in one.labels)
    assert found.identity["expert"].startswith("belief")
    assert "what the agent belief would do" in found.card().text


def test_an_expert_that_is_not_obeyed_makes_new_plans(learner):
    """Every fourth action differs from the expert's, and yet it gets to the target."""
    expert, env = SearchingExpert(BeliefAgent()), SHOWN()
    for number in range(3):
        episode = learner().episodes[number]
        observation, info = env.reset(options={"episode": episode, "habit_level": "retrieval"})
        expert.begin(0, episode, env, info)
        over, step = False, 0
        while not over:
            action = expert.label(0, observation, info)
            if step % 4 == 3 and action != Action.DONE:
                action = Action.ROTATE_LEFT
            observation, _, terminated, truncated, info = env.step(int(action))
            over, step = terminated or truncated, step + 1
        if info["episode_metrics"]["success"]:
            return
    raise AssertionError("nothing was found in three homes")


def test_the_collections_take_episodes_and_levels_in_turn(learner):
    found = learner()
    for _ in range(4):
        found.step()
    names = [one.episode.id for one in found.collected]
    assert sorted(names[:6]) == sorted(e.id for e in found.episodes)
    assert {one.level for one in found.collected} == {"none", "retrieval"}


def test_collections_are_the_same_with_any_number_of_workers(learner):
    """Parts of three episodes and of one, played ahead by workers and kept with their frames."""
    found = []
    for workers in (0, 2):
        with closing(learner(TinyPolicy(dropout=0.1), steps=9, average=0.5, workers=workers)) as one:
            for _ in range(7):
                one.step()
            found.append((one.collected, {name: tensor.clone() for name, tensor in one.state_dict().tensors.items()}))
    for collected, tensors in found[1:]:
        assert collected == found[0][0]
        assert all(torch.equal(tensor, found[0][1][name]) for name, tensor in tensors.items())
    assert len(found[0][0]) == 12


@pytest.mark.parametrize(("wanted", "found"), [("cpu", "cpu"), ("auto", "cuda"), ("cuda:0", "cuda:0")])
def test_a_collection_is_played_on_the_device_of_one_s_choice(learner, monkeypatch, wanted, found):
    on_a_gpu(monkeypatch)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 1)
    one = learner(Stays(), play_device=wanted)
    one.step()
    assert one.feeder._collector._policy.sent == found
    assert one.policy.sent == "cpu"
    assert one.resolved_options["play_device"] == found


def test_a_collection_is_played_in_the_precision_of_one_s_choice(learner):
    precise, half = learner(), learner(play_precision="bfloat16")
    assert [one.resolved_options["play_precision"] for one in (precise, half)] == ["float32", "bfloat16"]
    played = [one.feeder._collector._players._precision for one in (precise, half)]
    assert played == [torch.float32, torch.bfloat16]
    with pytest.raises(ConfigError, match="unknown precision 'half'"):
        learner(play_precision="half")


@pytest.mark.parametrize("backplay", [0.0, 0.7])
def test_what_was_seen_in_a_collection_is_what_is_seen_when_it_is_played_again(learner, backplay):
    found = learner(rollouts={"backplay": backplay})
    found.step()
    assert any(one.led for one in found.collected) == (backplay > 0)
    assert found.feeder._kept
    for one in found.collected:
        kept, again = _unpacked(found.feeder._kept[found.feeder._key(one)]), Replayer(found.act, ENV)(one)
        assert kept.frames.keys() == again.frames.keys()
        for before, after in ((kept.frames, again.frames), (kept.context, again.context)):
            assert all(np.array_equal(before[name], after[name]) for name in after)
        assert np.array_equal(kept.rewards, again.rewards)


def test_the_expert_acts_at_least_so_often(learner):
    found = learner(rollouts={"mixture": 0.0, "least": 1.0})
    for _ in range(4):
        found.step()
    assert all(one.actions == one.labels for one in found.collected[4:])


def test_a_share_of_each_batch_is_new(learner):
    found = learner(rollouts={"newest": 1.0}, batch=2)
    for _ in range(5):
        found.step()
    new = found.collected[4:]
    assert all(one in new for batch in found.batches() for one in batch)
    found.rollouts = replace(found.rollouts, newest=0.0, per_iteration=60)
    assert any(one not in new for batch in found.batches() for one in batch)


def test_nothing_is_collected_beyond_the_end_but_where_a_run_is_lengthened(learner):
    found = learner(steps=3)
    found.step()
    assert not found._ahead
    found.lengthen(6)
    found.step()
    assert found._ahead


@pytest.mark.parametrize("at", [2, 3, 5])
def test_a_run_that_is_killed_goes_on_to_the_same_bytes(learner, tmp_path, at):
    """A run killed before a collection, halfway between two, or just after one."""

    class KilledError(Exception):
        pass

    def kill(step, figures):
        if step == at and "loss" in figures:
            raise KilledError

    plan = Plan(steps=7, validate_every=7, save_every=1, keep=2)

    def made():
        return learner(TinyPolicy(dropout=0.1), rollouts={"backplay": 0.5}, steps=7, average=0.5)

    whole = TrainingRun(tmp_path / "whole", made(), plan, {})
    whole.start("a: 1\n")
    whole.run()
    parts = TrainingRun(tmp_path / "parts", made(), plan, {})
    parts.start("a: 1\n")
    with pytest.raises(KilledError):
        parts.run(kill)
    again = TrainingRun(tmp_path / "parts", made(), plan, {})
    again.resume()
    again.run()
    assert files(tmp_path / "parts") == files(tmp_path / "whole")


def test_a_run_that_finds_nothing_better_than_its_start_ends_with_its_start(learner, tmp_path):
    """The state before the first step, without weights that play, is loaded at the end."""
    found = learner(steps=2)
    before = {name: tensor.clone() for name, tensor in found.policy.state_dict().items()}
    scores = iter([1.0, 0.5])
    found.validate = lambda: {"score": next(scores)}
    run = TrainingRun(tmp_path / "run", found, Plan(steps=2, validate_every=2, save_every=1, keep=2), {})
    run.start("a: 1\n")
    run.run()
    assert run.best["step"] == 0
    with found.updates.averaged():
        assert all(torch.equal(tensor, before[name]) for name, tensor in found.policy.state_dict().items())


def test_a_state_without_the_weights_that_play_is_refused(learner):
    found = learner()
    found.step()
    state = found.state_dict()
    kept = {name: tensor for name, tensor in state.tensors.items() if not name.startswith("playing/")}
    with pytest.raises(DataError, match="the weights that play are missing"):
        learner().load_state_dict(dataclasses.replace(state, tensors=kept))


def test_a_state_with_other_episodes_is_refused(learner):
    found = learner()
    found.step()
    state = found.state_dict()
    state.values["collected"][0][0] = "elsewhere"
    with pytest.raises(DataError, match="trajectory of other episodes"):
        learner().load_state_dict(state)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"episodes": 0}, r"rollouts\.episodes=0: must be a whole number from 1"),
        ({"mixture": 1.5}, r"rollouts\.mixture=1\.5: must be from 0 to 1"),
        ({"per_iteration": 2.5}, r"rollouts\.per_iteration=2\.5"),
        ({"least": -0.1}, r"rollouts\.least=-0\.1: must be from 0 to 1"),
        ({"newest": True}, r"rollouts\.newest=True: must be from 0 to 1"),
        ({"backplay": 2}, r"rollouts\.backplay=2: must be from 0 to 1"),
        ({"backplay_steps": 0}, r"rollouts\.backplay_steps=0: must be a whole number from 1"),
        ({"temperature": -1}, r"rollouts\.temperature=-1: must be from 0 to 100"),
    ],
)
def test_rollouts_that_make_no_sense(options, message):
    with pytest.raises(ConfigError, match=message):
        DaggerRollouts(**options)
