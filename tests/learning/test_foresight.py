"""What is foretold of the way: its labels, its loss, and that a policy learns it from what it plays."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.learning.tiny_ppo import narrow_habit_policy, tiny_ppo
from ucon.core.errors import ConfigError
from ucon.envs.search.env import UcONSearchEnv
from ucon.learning.ppo.foresight import ForesightLoss, progress
from ucon.search.view_tokens import N_VIEW, moves_to


def decision(moves: list[float], distance_to_goal: list[float], here: float) -> dict[str, torch.Tensor]:
    """One decision among some views, and a row where there is none."""
    views = torch.zeros(1, len(moves) + 1, N_VIEW)
    views[0, :-1, 6] = (torch.tensor(moves) / 40).sqrt()
    mask = torch.tensor([[1] * len(moves) + [0]], dtype=torch.int8)
    return {"views": views, "action_mask": mask, "distance_to_goal": torch.tensor([[*distance_to_goal, -1.0, here]])}


def test_labels_are_the_part_of_each_move_that_counts() -> None:
    frames = decision([10, 10, 10, 20, 0, 5], [10, 30, 20, 10, 20, -1], 20.0)
    assert torch.allclose(moves_to(frames["views"])[0, :4], torch.tensor([10.0, 10.0, 10.0, 20.0]))
    shortened, told = progress(frames)
    assert told[0].tolist() == [True, True, True, True, False, False, False]
    assert torch.allclose(shortened[0, :4], torch.tensor([1.0, -1.0, 0.0, 0.5]))
    assert not shortened[0, 4:].any()


def test_a_move_counts_for_no_more_than_it_is_long() -> None:
    """Ways that are known only roughly may differ by more than the move between them: a label stays within [-1, 1]."""
    shortened, _ = progress(decision([10, 10, 10], [5, 35, 12], 20.0))
    assert shortened[0, :3].tolist() == pytest.approx([1.0, -1.0, 0.8])


def test_turning_on_the_spot_is_no_move() -> None:
    """A view less than half a move away tells nothing; from there to one move it counts as one."""
    frames = decision([0.0, 0.4, 0.6, 1.0], [19.5] * 4, 20.0)
    shortened, told = progress(frames)
    assert told[0, :4].tolist() == [False, False, True, True]
    assert shortened[0, :4].tolist() == pytest.approx([0.0, 0.0, 0.5, 0.5])


def test_the_way_may_be_none() -> None:
    """0 is a way like others, where the agent is and where it goes; less than 0 says that it is not known."""
    _, told = progress(decision([10], [0.0], 10.0))
    assert bool(told[0, 0])
    shortened, told = progress(decision([10], [10.0], 0.0))
    assert bool(told[0, 0])
    assert float(shortened[0, 0]) == -1.0
    _, told = progress(decision([10], [10.0], -1.0))
    assert not told.any()


def test_the_loss_counts_what_is_told_alone() -> None:
    frames = decision([10, 10], [10, 30], 20.0)
    foretold = torch.tensor([[0.5, -1.0, 9.0]], requires_grad=True)
    loss, figures = ForesightLoss(2.0)(frames, foretold)
    assert float(loss.detach()) == pytest.approx(2 * 0.5**2 / 2)
    assert figures["foresight_loss"] == pytest.approx(0.5**2 / 2)
    assert figures["foreseen"] == pytest.approx(1 - 0.125 / 2)
    loss.backward()
    assert foretold.grad is not None
    assert foretold.grad[0].tolist() == pytest.approx([-1.0, 0.0, 0.0])
    nothing = decision([0], [-1], -1.0)
    loss, _ = ForesightLoss()(nothing, torch.ones(1, 2, requires_grad=True))
    loss.backward()
    assert float(loss.detach()) == 0.0
    with pytest.raises(ConfigError, match=r"learner\.foresight\.weight"):
        ForesightLoss(-1.0)


def search(distance_to_goal: bool) -> UcONSearchEnv:
    return UcONSearchEnv("mini", distance_to_goal=distance_to_goal)


@pytest.mark.slow
def test_it_is_learned_while_playing(tmp_path: Path) -> None:
    """On what it plays again and again; without the label, or without the loss, there is nothing to learn."""
    options = {"search": functools.partial(search, True), "epochs": 30, "frames": 120, "kl_stop": 1e8, "lr": 3e-3}
    learner = tiny_ppo(tmp_path, narrow_habit_policy(), foresight=ForesightLoss(), **options)
    first, last = learner.step(), learner.step()
    assert np.isfinite(last["foresight_loss"])
    assert last["foreseen"] > 0.05
    assert first["foresight_loss"] > 0
    learner.rollouts.close()
    for more in ({"search": functools.partial(search, False), "foresight": ForesightLoss()}, {"foresight": None}):
        untold = tiny_ppo(tmp_path, narrow_habit_policy(), **{**options, "epochs": 1, **more})
        assert "foresight_loss" not in untold.step()
        untold.rollouts.close()
