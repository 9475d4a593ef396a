"""Choosing as an expert would: the loss, and that a policy learns it from what it plays."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from torch import nn

from tests.learning.tiny_policy import TinyPolicy
from tests.learning.tiny_ppo import narrow_habit_policy, tiny_ppo
from ucon.core.errors import ConfigError
from ucon.envs.waypoint.search_env import UcONSearchEnv
from ucon.envs.waypoint.view_expert import NOTHING
from ucon.learning.expert_loss import ExpertLoss
from ucon.learning.ppo_loss import PPOLoss


def decisions(*worth: list[float]) -> dict[str, torch.Tensor]:
    """Decisions among three views each, and a row where there is none."""
    rows = torch.tensor([[*row, NOTHING] for row in worth])
    return {"expert": rows, "action_mask": torch.tensor([[1, 1, 1, 0]] * len(worth), dtype=torch.int8)}


def test_the_loss_is_the_divergence_from_the_expert() -> None:
    frames = decisions([0.0, 0.1, -0.2], [NOTHING] * 3)
    logits = torch.tensor([[1.0, -1.0, 0.5, -torch.inf], [3.0, 0.0, 0.0, -torch.inf]], requires_grad=True)
    loss, figures = ExpertLoss(2.0, sharpness=5.0)(frames, logits)
    wanted, own = torch.tensor([0.0, 0.5, -1.0]).softmax(0), logits.detach()[0, :3].softmax(0)
    apart = float((wanted * (wanted / own).log()).sum())
    assert float(loss.detach()) == pytest.approx(2 * apart, abs=1e-6)
    assert figures == {"expert_kl": pytest.approx(apart, abs=1e-6), "as_expert": 0.0}
    loss.backward()
    assert logits.grad is not None
    assert torch.allclose(logits.grad[0, :3], 2 * (own - wanted), atol=1e-6)
    assert logits.grad[0, 3] == 0
    assert not logits.grad[1].any()  # nothing was told of it
    alike = (5 * frames["expert"]).masked_fill(frames["action_mask"] == 0, -torch.inf)[:1]
    assert float(ExpertLoss(sharpness=5.0)(decisions([0.0, 0.1, -0.2]), alike)[0]) == pytest.approx(0, abs=1e-6)


def test_nothing_told_is_nothing_learned() -> None:
    logits = torch.tensor([[1.0, 0.0, 0.0, -torch.inf]], requires_grad=True)
    loss, figures = ExpertLoss()(decisions([NOTHING] * 3), logits)
    loss.backward()
    assert float(loss.detach()) == figures["expert_kl"] == 0.0
    assert logits.grad is not None
    assert not logits.grad.any()


@pytest.mark.parametrize("options", [{"weight": 0}, {"weight": "1"}, {"sharpness": -1.0}])
def test_options_that_make_no_sense(options: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match=rf"learner\.expert\.{next(iter(options))}"):
        ExpertLoss(**options)  # type: ignore[arg-type]


def test_it_is_learned_while_playing(tmp_path: Path) -> None:
    """The more passes over what was played the nearer to the expert, without any reward."""
    options = {"search": functools.partial(UcONSearchEnv, "mini", expert=True), "frames": 60, "kl_stop": 1e8}
    apart = {}
    for epochs in (1, 25):
        learner = tiny_ppo(
            tmp_path, narrow_habit_policy(), expert=ExpertLoss(), loss=PPOLoss(entropy=0.0, objective=0.0),
            epochs=epochs, **options,
        )  # fmt: skip
        apart[epochs] = learner.step()["expert_kl"]
        learner.rollouts.close()
        assert "an expert" in learner.card().title
    assert apart[25] < 0.8 * apart[1]


def test_who_is_told_nothing_learns_none_of_it(tmp_path: Path) -> None:
    search = functools.partial(UcONSearchEnv, "mini", expert=True)
    learner = tiny_ppo(tmp_path, narrow_habit_policy(), frames=20, search=search)
    assert "expert_kl" not in learner.step()
    learner.close()


@pytest.mark.parametrize(
    ("policy", "message"), [(narrow_habit_policy, r"search\.expert=true"), (TinyPolicy, "no expert says which")]
)
def test_an_expert_that_is_not_there(tmp_path: Path, policy: Callable[[], nn.Module], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        tiny_ppo(tmp_path, policy(), expert=ExpertLoss(), loss=PPOLoss(entropy=0.0, objective=0.0))
