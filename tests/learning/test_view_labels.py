"""Labels of views by a searching agent: against its decisions, in collections and in losses."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch

from models.agents.belief import BeliefAgent
from models.agents.random import RandomAgent
from tests.learning.tiny_policy import TinyPolicy
from ucon.envs.ucon_env import UcONEnv
from ucon.learning.imitation.collecting import CollectionPart, Collector
from ucon.learning.imitation.experts import KnowingExpert, SearchingExpert
from ucon.learning.imitation.sequence_loss import SequenceLoss
from ucon.learning.imitation.view_labels import BEST, N_VIEWS, no_views, views_label
from ucon.learning.policies.action_policy import PolicyOutputs
from ucon.learning.policies.playing import Job
from ucon.learning.policies.sequences import Batch
from ucon.search.searcher import LOYALTY
from ucon.task.actions import Action
from ucon.task.sets import load_episodes

EPISODES = load_episodes("mini")[:3]


def shown() -> UcONEnv:
    return UcONEnv("mini", observe="pixels", detector=True)


class Learns(TinyPolicy):
    """A policy that learns from labels of views."""

    learns_views = True


@pytest.fixture(scope="module")
def search():
    """For every step of one search: label, pose, decision, goal and action."""
    env, expert, found = shown(), SearchingExpert(agent := BeliefAgent()), []
    obs, info = env.reset(options={"episode": EPISODES[1], "habit_level": "retrieval"})
    expert.begin(0, EPISODES[1], env, info)
    over = False
    while not over:
        action = expert.label(0, obs, info)
        searcher, decision = agent.decided(0)
        goal = searcher.homing.goal if searcher.taking else None
        found.append((expert.views(0), searcher.map.view, decision, goal, action))
        obs, _, terminated, truncated, info = env.step(int(action))
        over = terminated or truncated
    assert info["episode_metrics"]["success"]
    return found


def placed(label: np.ndarray, here) -> list[tuple[int, int, int]]:
    """Map cells and headings of the views in a label."""
    rows = label[label[:, 3] > 0].astype(int)
    cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[here.heading]
    i, j = here.i + cos * rows[:, 0] - sin * rows[:, 1], here.j + sin * rows[:, 0] + cos * rows[:, 1]
    return [*zip(i.tolist(), j.tolist(), ((here.heading + rows[:, 2]) % 4).tolist(), strict=True)]


def test_a_choice_is_labelled_with_the_scores_of_its_views(search) -> None:
    chose = [(label, here, decision) for label, here, decision, _, _ in search if decision and decision.valued]
    assert len(chose) > 3
    for label, here, decision in chose:
        assert label.shape == (N_VIEWS, 4)
        valued = decision.valued
        score = valued.score.copy()
        if valued.kept_at[0] >= 0:
            score[valued.kept_at] *= LOYALTY
        score = score.max(2)
        at = {(int(i), int(j)): n for n, (i, j) in enumerate(valued.nodes)}
        scores = [score[at[i, j], h] for i, j, h in placed(label, here)]
        given = label[label[:, 3] > 0, 3]
        assert given.tolist() == pytest.approx((BEST * np.array(scores) / score.max()).round().tolist(), abs=1)
        assert given[0] == BEST
        assert (np.diff(given.astype(int)) <= 0).all(), "the best first"
        assert len(given) == N_VIEWS or len(given) <= score.size
        best = decision.best.view
        assert (best.i, best.j, best.heading) in placed(label, here)[:8], "ties aside, the first is what it chose"


def test_on_the_way_nothing_is_said_and_at_the_end_where_it_goes(search) -> None:
    between = [label for label, _, decision, goal, _ in search if decision is None and goal is None]
    assert between
    assert not any(label.any() for label in between)
    taking = [(label, here, goal) for label, here, _, goal, _ in search if goal is not None]
    assert taking
    for label, here, goal in taking:
        assert placed(label, here) == [(goal.i, goal.j, goal.heading)]
        assert label[0, 3] == BEST
    assert search[-1][4] is Action.DONE


def test_where_no_view_has_any_gain_the_nearest_node_is_the_label(search) -> None:
    _, here, decision, _, _ = next(found for found in search if found[2] is not None)

    class Seeking:
        taking, map = False, type("Map", (), {"view": here})

    label = views_label(Seeking(), dataclasses.replace(decision, valued=None))
    best = decision.best.view
    assert placed(label, here) == [(best.i, best.j, best.heading)]
    assert not views_label(Seeking(), dataclasses.replace(decision, valued=None, best=None)).any()


def test_who_values_no_views_says_nothing() -> None:
    env = shown()
    obs, info = env.reset(options={"episode": EPISODES[0], "habit_level": "none"})
    for expert in (KnowingExpert(), SearchingExpert(RandomAgent())):
        expert.begin(0, EPISODES[0], env, info)
        expert.label(0, obs, info)
        assert np.array_equal(expert.views(0), no_views())


def collected(policy):
    collector = Collector(policy, shown, SearchingExpert(BeliefAgent()), 2, 40)
    jobs = tuple(Job(episode, "retrieval") for episode in EPISODES)
    return collector, collector(CollectionPart(0, 0, jobs, policy.state_dict(), 0.5, 1.0, 0))


def test_labels_are_the_same_when_a_trajectory_is_played_again() -> None:
    """Half of the actions are not the expert's, so it has to plan again in between."""
    collector, played = collected(Learns())
    assert any(trajectory.actions != trajectory.labels for trajectory, _ in played)
    for trajectory, replay in played:
        again = collector.replayer(trajectory)
        assert replay.frames.keys() == again.frames.keys()
        assert all(np.array_equal(replay.frames[name], again.frames[name]) for name in again.frames)
        assert (replay.frames["views"][..., 3] > 0).any(1).sum() > 3
    collector.close()


def test_a_policy_that_does_not_learn_from_views_gets_none() -> None:
    collector, played = collected(TinyPolicy())
    assert all("views" not in replay.frames for _, replay in played)
    assert "views" not in collector.replayer(played[0][0]).frames
    collector.close()


def test_the_loss_of_views_is_the_mean_over_the_steps_that_tell() -> None:
    _, played = collected(Learns())
    batch = Batch(played, 0.99, "cpu")
    loss, plain = SequenceLoss(views=0.5), SequenceLoss()
    scale, sums, total, bare = loss.scale(batch), 0.0, 0.0, 0.0
    apart = 0.0
    for chunk in batch.chunks(8):
        steps, n = chunk.labels.shape
        told = (chunk.frames["views"][..., 3] > 0).any(-1)
        nats = torch.rand(steps, n) * told
        out = PolicyOutputs(torch.zeros(steps, n, 7), torch.zeros(steps, n), {}, views=nats)
        part, found = loss(out, chunk, scale)
        total, sums, bare = total + part, sums + found, bare + plain(out, chunk, scale)[0]
        apart += float(nats.sum())
    n_told = sum(int((replay.frames["views"][..., 3] > 0).any(1).sum()) for _, replay in played)
    assert scale[2] == n_told
    figures = loss.figures(sums)
    assert figures["views_loss"] == pytest.approx(apart / n_told, rel=1e-5)
    assert float(total - bare) == pytest.approx(0.5 * apart / n_told, rel=1e-4)
    assert figures["loss"] == pytest.approx(float(total), rel=1e-4)


def test_without_labels_of_views_no_figure_is_made_of_them() -> None:
    collector, played = collected(TinyPolicy())
    batch = Batch(played, 0.99, "cpu")
    loss = SequenceLoss(views=0.5)
    chunk = next(iter(batch.chunks(1000)))
    steps, n = chunk.labels.shape
    out = PolicyOutputs(torch.zeros(steps, n, 7), torch.zeros(steps, n), {})
    assert "views_loss" not in loss.figures(loss(out, chunk, loss.scale(batch))[1])
    collector.close()
