"""A policy plays several episodes at once, each as if it were alone."""

import numpy as np
import pytest
import torch

from tests.learning.tiny_policy import ENV, TinyPolicy
from ucon.core.errors import ConfigError
from ucon.learning.policies.playing import Job, Players, PolicyChooser, Seen
from ucon.learning.policies.validation import Validation
from ucon.task.sets import load_episodes

EPISODES = load_episodes("mini")[:4]


def noisy_policy():
    """A random policy whose choices depend on everything it has seen."""
    policy = TinyPolicy(seed=3)
    with torch.no_grad():
        policy.choose.weight.mul_(8)
        policy.memory.weight_hh_l0.mul_(3)
    return policy


JOBS = [Job(episode, level) for episode, level in zip(EPISODES, ("none", "gt", "full", "none"), strict=True)]


def played(jobs, slots, sample=False, policy=None):
    players = Players(policy or noisy_policy(), ENV, slots, max_steps=15)
    found = players.play(jobs, PolicyChooser(sample, 5, "test"))
    players.close()
    return [one.actions for one in found]


def test_every_episode_is_played_as_if_it_were_alone():
    """This would fail if a recurrent state leaked between slots, or from one episode to the next in a slot."""
    alone = [played([job], 1)[0] for job in JOBS]
    assert len(set(alone)) > 1
    assert played(JOBS, 1) == alone
    assert played(JOBS, 3) == alone
    assert played(JOBS[::-1], 3) == alone[::-1]


def test_the_recurrent_state_matters_to_this_policy():
    class Forgetful(TinyPolicy):
        def forward(self, frames, context, state):
            return super().forward(frames, context, self.initial_state(frames["did"].shape[1]))

    forgetful = Forgetful()
    forgetful.load_state_dict(noisy_policy().state_dict())
    assert played(JOBS, 1, policy=forgetful) != played(JOBS, 1)


def test_draws_are_a_function_of_seed_and_step():
    assert played(JOBS, 3, sample=True) == played(JOBS, 2, sample=True)
    assert played(JOBS, 3, sample=True) != played(JOBS, 3)
    draws = [PolicyChooser(True, 0, "a").choose(1, step, np.log([0.7, 0.2, 0.1]), Seen({}, {})) for step in range(600)]
    assert np.bincount(draws) / 600 == pytest.approx([0.7, 0.2, 0.1], abs=0.06)
    cold = PolicyChooser(True, 0, "a", temperature=0.5)  # squares the odds
    draws = [cold.choose(1, step, np.log([0.7, 0.2, 0.1]), Seen({}, {})) for step in range(600)]
    assert np.bincount(draws, minlength=3) / 600 == pytest.approx([0.907, 0.074, 0.019], abs=0.04)


def test_what_is_measured_is_what_the_environment_says():
    class Replaying(PolicyChooser):
        def begin(self, number, job, env, info):
            self.solution = job.episode.solution

        def choose(self, number, step, logits, seen):
            return int(self.solution[step])

    short = min(load_episodes("mini"), key=lambda episode: len(episode.solution))
    (one,) = Players(TinyPolicy(), ENV, 1, 300).play([Job(short, "none")], Replaying(False, 0))
    assert (one.success, one.spl, one.actions) == (True, 1.0, short.solution)
    (cut,) = Players(TinyPolicy(), ENV, 1, len(short.solution) - 1).play([Job(short, "none")], Replaying(False, 0))
    assert (cut.success, cut.spl, len(cut.actions)) == (False, 0.0, len(short.solution) - 1)


def test_frozen_networks_look_once_at_what_is_played_and_kept():
    class Looks(TinyPolicy):
        looked, precisions = 0, set()

        def features(self, frames):
            if "depth" not in frames:
                return frames
            self.looked += frames["did"].numel()
            return {"did": frames["did"], "seen": frames["depth"] * 2}

        def forward(self, frames, context, state):
            self.precisions.add(torch.is_autocast_enabled("cpu"))
            given = self.features(frames)
            return super().forward({"did": given["did"], "depth": given["seen"] / 2}, context, state)

    def kept(precision):
        policy = Looks()
        policy.load_state_dict(noisy_policy().state_dict())
        players = Players(policy, ENV, 2, max_steps=15, keep_frames=True, precision=precision)
        found = players.play(JOBS, PolicyChooser(False, 5, "test"))
        players.close()
        return policy, found

    policy, found = kept(None)
    assert [one.actions for one in found] == played(JOBS, 2)
    assert {tuple(one.replay.frames) for one in found} == {("did", "seen")}
    assert policy.looked == sum(len(one.actions) for one in found) == sum(len(one.replay) for one in found)
    assert policy.precisions == {False}
    Looks.precisions = set()
    assert kept(torch.bfloat16)[0].precisions == {True}


def test_validation_draws_at_its_temperature():
    """At a low temperature it nearly always draws the best action."""

    def steps(**options):
        players = Players(noisy_policy(), ENV, 3, max_steps=15, keep_frames=True)
        validation = Validation("mini", n_play=3, level="none", **options)
        seen = []
        play = players.play
        players.play = lambda *given: seen.extend(play(*given)) or seen
        validation.played(players, 0)
        players.close()
        return [one.actions for one in seen]

    best, cold, warm = steps(), steps(sample=True, temperature=0.01), steps(sample=True, temperature=3.0)
    begun = [sum(a[:5] == b[:5] for a, b in zip(best, other, strict=True)) for other in (cold, warm)]
    assert begun[0] >= 2 > begun[1]


@pytest.mark.parametrize("temperature", [0, -1.0, 101, True, "1"])
def test_a_temperature_of_validation_that_makes_no_sense(temperature):
    with pytest.raises(ConfigError, match=r"learner\.validation\.temperature=.*from 0\.01 to 100"):
        Validation(temperature=temperature)
