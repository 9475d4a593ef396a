"""Explains an action of the end-to-end habit policy: the place it goes to, the thing there, and the habits behind it.

For display only: decisions do not depend on it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from models.nets.end_to_end.ego_view import CELL_M
from models.nets.end_to_end.floor_memory import HALF, REACH, State, cell_belief
from models.nets.end_to_end.inside import PolicyTrace
from models.nets.end_to_end.read_habits import kept_habits, words
from ucon.learning.policies.action_policy import Tensors
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS
from ucon.readers.protocol import Reader, read_info
from ucon.task.actions import Action

_NEAR = 6
"""Cells around a goal among which the thing with the highest belief counts as its reason."""
_SPEAKS = 0.05
"""Least support with which a habit counts as speaking for a place."""
_MOST_HABITS = 3


@dataclass(frozen=True)
class Reasons:
    """Explanation of one step of one episode."""

    goal_xy: tuple[float, float]
    """Most probable place to go to, in metres from the start."""
    goal_p: float
    """Probability of that place."""
    thing: str
    """Category of the remembered thing near that place with the highest belief; "" for none."""
    belief: tuple[tuple[str, str, float], ...]
    """The five most probable places of the target: anchor, relation, probability."""
    habits: tuple[tuple[str, float], ...]
    """Habits with the most support, in decreasing order, each with its support in [0, 1].

    Support is for the target being at ``thing``, else at the most probable anchor, else anywhere.
    """
    seen: tuple[tuple[str, float], ...]
    """Things in view, with the attention that each got."""
    actions: tuple[float, ...]
    """Probability of each of the seven actions."""
    goals: NDArray[np.float32]
    """(C, C) probability of going to each place around the agent, in 0.5 m cells along the map's axes; for drawing."""

    def table(self) -> str:
        """The explanation as a few lines of text."""
        likely = int(np.argmax(self.actions))
        lines = [
            f"action    {Action(likely).name} {self.actions[likely]:.2f}",
            f"goes to   ({self.goal_xy[0]:+.2f}, {self.goal_xy[1]:+.2f}) m  p {self.goal_p:.2f}  {self.thing}",
            "believes  " + ", ".join(f"{relation} {anchor} {p:.2f}" for anchor, relation, p in self.belief),
            "sees      " + ", ".join(f"{name} {weight:.2f}" for name, weight in self.seen),
        ]
        return "\n".join([*lines, *(f"habit     {support:.2f}  {text}" for text, support in self.habits)])


def reasons(
    reader: Reader,
    info: Mapping[str, Any],
    frame: Tensors,
    context: Tensors,
    state: Tensors,
    believed: Tensor,
    trace: PolicyTrace,
    logits: Any,
) -> Reasons:
    """Explain the last step of a call of ``HabitPolicyE2E.think`` with one episode.

    Args:
        reader: of the policy.
        info: of the episode's reset, with its habits.
        frame: of that step, (1, 1, ...) by name.
        context: (1, ...) by name.
        state: recurrent state after the step, (1, ...) by name.
        believed: (1, N_TRACKS, 4) belief of every track.
        trace: second result of ``think``.
        logits: (7,).
    """
    goals = trace.ways.log_goal[-1, 0].exp().sum(0)  # (C, C)
    at = divmod(int(goals.argmax()), goals.shape[1])
    i, j = (int(frame["pose"][-1, 0, k]) + 2 * at[k] - REACH for k in range(2))
    thing = _thing_near({**state}, believed, i, j)
    belief = context["belief"][0].float()
    best = belief.flatten().topk(5)
    names = catalogue().names
    places = tuple(
        (names[k // len(RELATIONS)], RELATIONS[k % len(RELATIONS)], round(p, 3))
        for p, k in zip(best.values.tolist(), best.indices.tolist(), strict=True)
    )
    focus, ids = trace.seen.focus[-1, 0], frame["thing_ids"][-1, 0]
    order = [k for k in focus.argsort(descending=True).tolist() if ids[k] >= 0][:4]
    seen = tuple((_name(int(ids[k])), round(float(focus[k]), 3)) for k in order)
    return Reasons(
        (i * CELL_M, j * CELL_M),
        float(goals.max()),
        thing,
        places,
        _speaking(reader, info, (thing, places[0][0])),
        seen,
        tuple(torch.softmax(torch.as_tensor(logits), -1).tolist()),
        goals.detach().cpu().numpy().astype(np.float32),
    )


def _thing_near(state: State, believed: Tensor, i: int, j: int) -> str:
    """Category of the remembered thing with the highest belief within 6 cells of cell (i, j); "" for none."""
    most = cell_belief(state, believed)
    a, b = max(i + HALF - _NEAR, 0), max(j + HALF - _NEAR, 0)
    around = most[:, a : a + 2 * _NEAR + 1, b : b + 2 * _NEAR + 1]
    if not around.size or float(around.max()) <= 0.0:
        return ""
    layer, k, m = (int(n) for n in np.unravel_index(int(around.argmax()), around.shape))
    return _name(int(state["kind"][0, int(state["who"][0, layer, a + k, b + m])]))


def _name(number: int) -> str:
    names = catalogue().names
    return names[number] if 0 <= number < len(words().number) else "?"


def _speaking(reader: Reader, info: Mapping[str, Any], anchors: Sequence[str]) -> tuple[tuple[str, float], ...]:
    """Habits with the most support for the first of ``anchors`` that has any, else for any place; at most three."""
    texts: Sequence[str] = tuple(info["habits"])
    if not texts:
        return ()
    reading = read_info(reader, info)
    for anchor in (name for name in anchors if name in tuple(reader.known)):
        support = np.asarray(reading.support(anchor))
        if support.max() > _SPEAKS:
            break
    else:
        support = kept_habits(reading, texts, tuple(reader.known))[1].max(1)
    order = np.argsort(-support, kind="stable")[:_MOST_HABITS]
    return tuple((texts[k], round(float(support[k]), 3)) for k in order.tolist() if support[k] > 0.005)
