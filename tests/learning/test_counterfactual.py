"""Learning from counterfactual rollouts: labels, loss, and the learner."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from models.habit_policy import HabitPolicy
from tests.learning.tiny_search import search_of
from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError
from ucon.learning.counterfactual.labels import Rollouts
from ucon.learning.counterfactual.learner import CounterfactualLearner, relative_worth
from ucon.learning.decisions import store
from ucon.learning.decisions.decisions import by_gain_over_cost, first_views, rivals
from ucon.learning.foresight.labels import Beyond
from ucon.perception.detectors.gt import GtDetector

ROLLOUTS = Rollouts(share=0.3, views=3, steps=20)


@pytest.fixture(scope="module")
def search() -> Factory:
    return search_of("counterfactual")


@pytest.fixture(scope="module")
def cache(search: Factory, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A separate cache with the labelled decisions of a few searches."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UCON_CACHE", str(folder))
        store.kept_decisions(ROLLOUTS, "mini", 8, search, ("retrieval",), 0, 2)
    return folder


@pytest.fixture
def kept(cache: Path, search: Factory, monkeypatch: pytest.MonkeyPatch) -> store.Decisions:
    monkeypatch.setenv("UCON_CACHE", str(cache))
    return store.kept_decisions(ROLLOUTS, "mini", 8, search, ("retrieval",), 0, 1)


def test_some_views_of_every_decision_are_labelled_the_first_among_them(kept: store.Decisions) -> None:
    worth, among = kept.frames["worth"], rivals(kept.frames)
    tried = ~np.isnan(worth)
    assert (tried.sum(1) >= 2).all()
    assert (tried.sum(1) == np.minimum(among.sum(1), 3)).mean() > 0.95  # unless float16 ties two
    assert (tried & ~among).sum() <= 0.01 * tried.sum()
    first = first_views(kept.frames)
    assert tried[np.arange(len(kept)), first].mean() > 0.95  # unless float16 ties two
    assert worth[tried].min() >= 0.0
    assert worth[tried].max() <= 1.0
    assert np.nanstd(worth, axis=1).mean() > 0.001


def test_rollouts_leave_the_search_as_it_was(search: Factory) -> None:
    def searched(*, tried: bool) -> tuple[float, list[int]]:
        env, total, rows = search(), 0.0, []
        observation, _ = env.reset(options={"episode": env.env.episodes[0], "habit_level": "retrieval"})
        labels, draw = Rollouts(1.0, 2, 10), np.random.default_rng(0)
        for _ in range(6):
            if tried:
                labels._worth(env, observation, rivals(observation), draw)
            rows.append(by_gain_over_cost(observation))
            observation, reward, *_ = env.step(rows[-1])
            total += reward
        env.close()
        return total, rows

    assert searched(tried=False) == searched(tried=True)


def test_only_differences_within_decisions_count() -> None:
    worth = torch.tensor([[0.2, 0.4, float("nan"), 0.3], [0.02, 0.02, 0.02, float("nan")]])
    relative, known, mean = relative_worth({"worth": worth})
    assert torch.equal(known, ~worth.isnan())
    assert mean[:, 0] == pytest.approx([0.3, 0.02])
    assert relative[0] == pytest.approx([-1 / 3, 1 / 3, 0.0, 0.0], abs=1e-6)
    assert relative[1] == pytest.approx([0.0] * 4, abs=1e-6)
    twice, *_ = relative_worth({"worth": 2.0 * worth})
    assert torch.allclose(twice, relative, atol=1e-6)


@pytest.mark.slow
def test_training_explains_more_in_the_homes_it_learns_in(
    kept: store.Decisions, search: Factory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ucon.learning.decisions.learner.check_parts", lambda *given: None)  # mini is no training set
    learner = CounterfactualLearner(
        HabitPolicy(32, 1, 2), search, {"gt": GtDetector()}, ROLLOUTS, Beyond(), 8, 0.25, steps=160, episodes="mini",
        n_searches=8, validation="mini", validation_searches=8, levels=("retrieval",), batch=64, lr=5e-3, warm_up=5,
        decay=0.0, average=0.5, device="cpu",
    )  # fmt: skip
    before = learner.validate()
    assert before["gain"] == pytest.approx(0.0, abs=1e-4), "an untrained policy goes by gain over cost"
    for _ in range(160):
        learner.step()
    assert all(bool(weight.isfinite().all()) for weight in learner.network.state_dict().values())
    after = learner.validate()
    assert after["explained"] > before["explained"] + 0.1
    assert after["gain"] > 0.0


@pytest.mark.parametrize(
    "wrong", [{"share": 0.0}, {"share": 2}, {"views": 1}, {"steps": 0}, {"rest": -1.0}, {"views": 2.5}]
)
def test_wrong_options_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match=rf"learner\.rollouts\.{next(iter(wrong))}"):
        Rollouts(**wrong)
