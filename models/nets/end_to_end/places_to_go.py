"""Where to go: a distribution over the poses of the remembered floor, and the first action towards each.

A pose's score is what it promises, learned from the map around it, minus the cost of the way there. The probability of
an action is the sum over poses whose shortest path begins with it. As this is a mixture, imitating actions teaches what
places promise: which anchors named by habits, containers and frontiers are worth the way. All four headings share the
weights: what lies around a pose is weighed by one kernel, rotated.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from models.nets.end_to_end.floor_memory import LAYERS, LEFT, Window, coarse
from models.nets.end_to_end.shortest_ways import FAR, shortest_ways

_KERNEL = 5
_NEVER = -1e4
"""Score of what cannot be; -inf would give NaN gradients."""
#: Added to the probability of each first action.
_LEAST = math.exp(-12.0)
#: Initial promise of a place by channel, in actions that one would spend for it.
_BEFORE = dict(zip(LEFT, (6.0, 4.0, 4.0, 8.0), strict=True)) | {"target": 60.0, "frontier": 4.0}
#: The way's cost also grows with the logarithm of its length; one unit of it is this many actions.
_FEW_STEPS = 4.0


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

    def __init__(self, n_globals: int, width: int = 16, n_wide: int = 32) -> None:
        """Build the network; at first it scores by the fixed promises of the layers.

        Args:
            n_globals: number of features of the whole episode or step, which change what is worth going to.
            width: channels of the hidden layer, and learned features of a place.
            n_wide: channels at a quarter of the resolution, which see 5 m around.
        """
        super().__init__()
        self.near = nn.Conv2d(len(LAYERS), width, 3, padding=1)
        self.wide = nn.Sequential(
            *(nn.Conv2d(width, n_wide, 3, stride=2, padding=1), nn.ReLU()),
            *(nn.Conv2d(n_wide, n_wide, 3, padding=2, dilation=2), nn.ReLU()),
        )
        self.back = nn.Conv2d(n_wide, width, 1)
        self.interests = nn.Conv2d(width, width - 1, 1)
        self.globals = nn.Linear(n_globals, width)
        self.raw = nn.Conv2d(len(LAYERS), 1, 1)
        self.view = nn.Parameter(torch.zeros(1, width, _KERNEL, _KERNEL))
        self.wide_view = nn.Parameter(torch.zeros(1, n_wide, _KERNEL, _KERNEL))
        self.log_cost = nn.Parameter(torch.tensor([-1.2, -3.0]))
        self._begin()

    @torch.no_grad()
    def _begin(self) -> None:
        self.raw.weight.zero_()
        self.raw.bias.zero_()  # type: ignore[union-attr]
        for name, worth in _BEFORE.items():
            self.raw.weight[0, LAYERS.index(name)] = worth
        nn.init.normal_(self.view[:, 1:], std=0.05)
        nn.init.normal_(self.wide_view, std=0.03)
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
        near = functional.relu(self.near(seen) + self.globals(given)[:, :, None, None])
        wide = self.wide(near)
        near = near + _finer(self.back(wide))
        interest = torch.cat([self.raw(seen), self.interests(near)], 1)
        promise = _seen_from(interest, self.view) + _finer(_seen_from(wide, self.wide_view))  # (N, 4, C, C)
        each, few = torch.exp(self.log_cost)
        score = promise - each * steps - few * torch.log1p(steps / _FEW_STEPS)
        score = score.masked_fill(steps == FAR, _NEVER).flatten(1)
        log_goal = torch.log_softmax(score.float(), 1)
        return Ways(_by_first(log_goal, first.flatten(1)), log_goal.exp().view_as(promise), interest)


def _seen_from(features: Tensor, kernel: Tensor) -> Tensor:
    """(N, 4, C, C), ``features`` (N, F, C, C) weighed by the kernel (1, F, K, K) as turned to headings 0 to 3.

    Heading 0 looks along the first axis, 1 along the second.
    """
    kernels = torch.cat([torch.rot90(kernel, turns, (2, 3)) for turns in range(4)])
    return functional.conv2d(features, kernels, padding=_KERNEL // 2)


def _finer(coarse: Tensor) -> Tensor:
    """(N, F, 2 C - 1, 2 C - 1) from (N, F, C, C); the middle stays in the middle."""
    side = 2 * coarse.shape[-1] - 1
    return functional.interpolate(coarse, (side, side), mode="bilinear", align_corners=True)


def _by_first(log_goal: Tensor, first: Tensor) -> Tensor:
    """(N, 4) log of the summed probability of the goals whose path begins with each action, at least -12."""
    summed = torch.zeros(len(first), 4, dtype=log_goal.dtype, device=log_goal.device)
    summed = summed.scatter_add(1, first.clamp(max=3).long(), log_goal.exp() * (first < 4))
    return (summed + _LEAST).log()
