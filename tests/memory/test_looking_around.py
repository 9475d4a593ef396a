"""Looking around once before Done: a whole turn, one Done, and never past the last step."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.memory.looking_around import LookingAround
from ucon.perception.mapping.body import Body
from ucon.task.actions import Action
from ucon.task.rules import PAPER

N = Body.of({"task": "paper"}).headings


def began(task: str = "paper") -> LookingAround:
    around = LookingAround()
    around.begin({"task": task})
    return around


def test_it_turns_once_round_and_then_ends() -> None:
    around = began()
    wanted = [Action.MOVE_AHEAD, Action.OPEN, *[Action.DONE] * (N + 1)]
    assert [around.act(action, step) for step, action in enumerate(wanted)] == [
        Action.MOVE_AHEAD, Action.OPEN, *[Action.ROTATE_LEFT] * N, Action.DONE,
    ]  # fmt: skip


def test_what_the_agent_wants_meanwhile_does_not_count() -> None:
    around = began()
    rng = np.random.default_rng(0)
    others = [int(action) for action in rng.integers(0, 6, N)]
    assert around.act(Action.DONE, 0) == Action.ROTATE_LEFT
    done = [around.act(action, 1 + k) for k, action in enumerate(others)]
    assert done == [*[Action.ROTATE_LEFT] * (N - 1), Action.DONE]


def test_every_request_has_its_turn() -> None:
    around = began()
    for _ in range(3):
        around.begin({"task": "paper"})
        assert [around.act(Action.DONE, 5 + k) for k in range(N + 1)] == [*[Action.ROTATE_LEFT] * N, Action.DONE]


@pytest.mark.parametrize("left", range(1, 2 * N))
def test_it_ends_in_time(left: int) -> None:
    """Done is carried out within the request's steps: at once if a whole turn would leave no step for it."""
    around, first = began(), PAPER.max_steps - left
    actions = []
    for step in range(first, PAPER.max_steps):
        actions.append(around.act(Action.DONE, step))
        if actions[-1] == Action.DONE:
            break
    assert actions[-1] == Action.DONE
    assert len(actions) == (N + 1 if left > N else 1)
