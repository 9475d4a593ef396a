"""Where to go: a distribution over the poses of the remembered floor, and the first action towards each.

A pose's score is what it promises, learned from the map around it, minus the cost of the way there. The probability of
an action is the sum over poses whose shortest path begins with it. As this is a mixture, imitating actions teaches what
places promise: which anchors named by habits, containers and frontiers are worth the way. All four headings share the
weights: what lies ahead of a pose is weighed by one kernel, rotated.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from models.nets.end_to_end.floor_memory import CHANNELS, Window, coarse
from models.nets.end_to_end.shortest_ways import FAR, shortest_ways

_INPUTS = len(CHANNELS) + 2
_KERNEL = 5
_NEVER = -1e4
"""Score of what cannot be; -inf would give NaN gradients."""
#: Added to the probability of each first action.
_LEAST = math.exp(-12.0)
#: Initial promise of a place by channel, in actions that one would spend for it.
_BEFORE = {"ontop": 6.0, "beside": 4.0, "inside": 4.0, "closed": 8.0, "target": 60.0, "frontier": 4.0}


class Ways(NamedTuple):
    """For N agents: log-probabilities of first actions, and of goals in C x C blocks of 2 x 2 cells around each."""

    log_p: Tensor
    """(N, 4) log-probability of MoveAhead, RotateRight, RotateLeft, and of staying in this pose."""
    goals: Tensor
    """(N, 4, C, C) probability of going to each pose, by heading there."""
    interest: Tensor
    """(N, F, C, C) learned features of places, which promises are computed from."""


class PlacesToGo(nn.Module):
    """Network that scores the poses around the agent."""

    def __init__(self, n_globals: int, width: int = 16, n_interests: int = 8) -> None:
        """Build the network; at first it scores by the fixed promises of the channels.

        Args:
            n_globals: number of features of the whole episode or step, which change what is worth going to.
            width: channels of the hidden layers.
            n_interests: learned features of a place.
        """
        super().__init__()
        self.near = nn.Conv2d(_INPUTS, width, 3, padding=1)
        self.wide = nn.Conv2d(width, width, 3, padding=2, dilation=2)
        self.interests = nn.Conv2d(width, n_interests, 1)
        self.globals = nn.Linear(n_globals, width)
        self.raw = nn.Conv2d(_INPUTS, 1, 1)
        self.view = nn.Parameter(torch.zeros(1, n_interests + 1, _KERNEL, _KERNEL))
        self.log_cost = nn.Parameter(torch.tensor(-1.2))
        self._begin()

    @torch.no_grad()
    def _begin(self) -> None:
        names = (*CHANNELS, "unknown", "frontier")
        self.raw.weight.zero_()
        self.raw.bias.zero_()  # type: ignore[union-attr]
        for name, worth in _BEFORE.items():
            self.raw.weight[0, names.index(name)] = worth
        nn.init.normal_(self.view[:, 1:], std=0.05)
        middle = _KERNEL // 2
        self.view[0, 0, middle + 1, middle] = 0.6  # weight of the block half a metre ahead of a pose
        self.view[0, 0, middle + 2, middle] = 0.2
        self.view[0, 0, middle + 1, middle - 1 : middle + 2 : 2] = 0.1

    def forward(self, window: Window, heading: Tensor, given: Tensor) -> Ways:
        """Score the poses around N agents.

        Args:
            window: of each agent.
            heading: (N,) int, quarter turns.
            given: (N, n_globals) features of episode and step.
        """
        steps, first = shortest_ways(window.free, heading)
        seen = coarse(window.cells)
        hidden = functional.relu(self.near(seen) + self.globals(given)[:, :, None, None])
        hidden = functional.relu(self.wide(hidden))
        interest = torch.cat([self.raw(seen), self.interests(hidden)], 1)
        promise = functional.conv2d(interest, self._kernels(), padding=_KERNEL // 2)  # (N, 4, C, C)
        score = promise - torch.exp(self.log_cost) * steps
        score = score.masked_fill(steps == FAR, _NEVER).flatten(1)
        log_goal = torch.log_softmax(score, 1)
        return Ways(_by_first(log_goal, first.flatten(1)), log_goal.exp().view_as(promise), interest)

    def _kernels(self) -> Tensor:
        """The kernel for headings 0 to 3; heading 0 looks along the first axis, 1 along the second."""
        return torch.cat([torch.rot90(self.view, turns, (2, 3)) for turns in range(4)])


def _by_first(log_goal: Tensor, first: Tensor) -> Tensor:
    """(N, 4) log of the summed probability of the goals whose path begins with each action, at least -12."""
    summed = torch.zeros(len(first), 4, dtype=log_goal.dtype, device=log_goal.device)
    summed = summed.scatter_add(1, first.clamp(max=3).long(), log_goal.exp() * (first < 4))
    return (summed + _LEAST).log()
