"""Where to go: a distribution over the poses of the remembered floor, and the first action towards each.

A pose's score is the logarithm of the worth of what it would show, minus the logarithm of the cost of the way there.
The worth of a unit of each count is learned, and depends on target, habits and step. A small network adds a further
term to the score. The probability of an action is the sum over poses whose shortest path begins with it.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import torch
from torch import Tensor, nn

from models.nets.end_to_end.floor_memory import BLOCKS, OUTLOOK, Outlook
from models.nets.end_to_end.way_kernels import FAR

_NEVER: Final = -1e4
"""Score of what cannot be; -inf would give NaN gradients."""
#: Added to the probability of each first action.
_LEAST: Final = math.exp(-12.0)
#: Worth of a pose that shows nothing.
_NOTHING: Final = 1e-7
#: Initial worth of a unit of each count: of belief, of a square metre, of the target.
_WORTH: Final = {
    "on": 1.0, "beside": 0.6, "inside": 1.0, "used": 0.05, "closed": 1.0, "space": 0.01, "thin": 0.002, "target": 10.0,
}  # fmt: skip
#: Initial loss of score for each unit of having been there.
_STALE: Final = {"been": 0.5, "around": 0.0}
#: Initial factor by which the pose that the agent is on its way to is preferred.
_LOYALTY: Final = 1.25
#: Log-probabilities are rounded to this when poses are compared: last bits depend on what else is in the batch.
_TIE: Final = 1e-3
#: Initial cost of every pose in addition to the actions.
_OVERHEAD: Final = 0.5


class Ways(NamedTuple):
    """For T steps of B agents: first actions, and poses in C x C blocks of 2 x 2 cells around each agent."""

    log_p: Tensor
    """(T, B, 4) log-probability of MoveAhead, RotateRight, RotateLeft, and of staying in this pose."""
    log_goal: Tensor
    """(T, B, 4, C, C) log-probability of going to each pose, by heading there."""
    aim: Tensor
    """(B, 3) int64, the likeliest pose at the last step: cell (i, j) from the start and heading."""


class PlacesToGo(nn.Module):
    """Network that scores the poses around the agent."""

    def __init__(self, n_globals: int, sharpness: float, width: int = 24) -> None:
        """Build the network; at first it scores by fixed worths.

        Args:
            n_globals: number of features of episode and step, on which worths depend.
            sharpness: factor of the scores; the higher, the more the best pose dominates.
            width: of the hidden layers.
        """
        super().__init__()
        self._sharpness = sharpness
        self.worths = nn.Sequential(nn.Linear(n_globals, width), nn.ReLU(), nn.Linear(width, len(_WORTH)))
        self.stale = nn.Parameter(torch.tensor([*_STALE.values()]))
        self.overhead = nn.Parameter(torch.tensor(math.log(_OVERHEAD)))
        self.loyalty = nn.Parameter(torch.tensor(math.log(_LOYALTY)))
        self.numbers = nn.Linear(len(OUTLOOK) + 2, width)
        self.globals = nn.Linear(n_globals, width, bias=False)
        self.also = nn.Sequential(nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, 1))
        self._begin()

    @torch.no_grad()
    def _begin(self) -> None:
        last, extra = self.worths[-1], self.also[-1]
        assert isinstance(last, nn.Linear) and isinstance(extra, nn.Linear)  # noqa: PT018
        for layer in (last, extra):
            nn.init.normal_(layer.weight, std=0.01)
            nn.init.zeros_(layer.bias)
        last.bias.copy_(torch.tensor([*_WORTH.values()]).log())

    def forward(self, seen: Outlook, given: Tensor, aim: Tensor, pose: Tensor) -> Ways:
        """Score the poses around B agents at T steps.

        Args:
            seen: of T * B agents, step by step.
            given: (T, B, n_globals) features of episode and step.
            aim: (B, 3) int64, the pose that was likeliest before the first step; heading -1 for none.
            pose: (T, B, 4) int64 of the agents.
        """
        n_steps, batch = given.shape[:2]
        score = self._scores(seen, given.flatten(0, 1)).unflatten(0, (n_steps, batch))  # (T, B, 4 * C * C)
        cell = seen.cell.unflatten(0, (n_steps, batch))
        log_goals = []
        for t in range(n_steps):
            log_goals.append(torch.log_softmax(self._sharpness * self._loyal(score[t], aim, pose[t]), -1))
            aim = aimed_at(log_goals[-1].detach(), pose[t], cell[t])
        log_goal = torch.stack(log_goals)
        first = seen.first.flatten(1).unflatten(0, (n_steps, batch))
        shape = (n_steps, batch, *seen.steps.shape[1:])
        return Ways(_by_first(log_goal, first), log_goal.view(shape), aim)

    def _scores(self, seen: Outlook, given: Tensor) -> Tensor:
        """Scores (N, 4 * C * C) of all poses without loyalty, ``_NEVER`` where there is no way.

        Most poses show nothing. Their score depends only on the agent's features and the number of steps, so it is
        computed once for each agent and number.
        """
        counts, steps = seen.counts.flatten(2), seen.steps.flatten(1)  # (N, len(OUTLOOK), P), (N, P)
        there = steps != FAR
        agent, at = (there & (counts != 0).any(1)).nonzero(as_tuple=True)
        shows = self._score_of(counts[agent, :, at], steps[agent, at].float(), given, agent)
        farthest = int(steps[there].max()) if bool(there.any()) else 0
        every = torch.arange(len(given), device=given.device).repeat_interleave(farthest + 1)
        numbers = torch.arange(farthest + 1, device=given.device, dtype=torch.float32).repeat(len(given))
        empty = self._score_of(counts.new_zeros(len(every), counts.shape[1]), numbers, given, every)
        score = empty.view(len(given), farthest + 1).gather(1, steps.long().clamp(max=farthest))
        return torch.where(there, score, _NEVER).index_put((agent, at), shows)

    def _score_of(self, counts: Tensor, steps: Tensor, given: Tensor, agent: Tensor) -> Tensor:
        """Scores (Q,) of poses, from their counts (Q, len(OUTLOOK)), the steps there (Q,) and the agents (Q,)."""
        n = len(_WORTH)
        with torch.autocast(given.device.type, enabled=False):
            worth = (counts[:, :n] * self.worths(given.float()).float().exp()[agent]).sum(-1)
            cost = torch.log(steps + self.overhead.exp())
            score = torch.log(worth + _NOTHING) - cost - counts[:, n:] @ self.stale
        logs = torch.log1p(100.0 * counts[:, :n]) / 4
        numbers = torch.cat([logs, counts[:, n:], cost[:, None], steps[:, None] / 50], 1)
        return score + self.also(self.numbers(numbers) + self.globals(given)[agent]).squeeze(-1).float()  # type: ignore[no-any-return]

    def _loyal(self, score: Tensor, aim: Tensor, pose: Tensor) -> Tensor:
        """Scores (B, 4 * C * C), raised for the block of the pose that the agent is on its way to."""
        block = (aim[:, :2] - pose[:, :2] + BLOCKS - 1) // 2
        known = (aim[:, 2] >= 0) & ((block >= 0) & (block < BLOCKS)).all(1)
        block = block.clamp(0, BLOCKS - 1)
        at = (aim[:, 2].clamp(min=0) * BLOCKS + block[:, 0]) * BLOCKS + block[:, 1]
        return score.scatter_add(1, at[:, None], (self.loyalty * known)[:, None].to(score.dtype))


def aimed_at(log_goal: Tensor, pose: Tensor, cell: Tensor) -> Tensor:
    """The likeliest poses, (B, 3) int64: cell (i, j) from the start and heading.

    Args:
        log_goal: (B, 4 * C * C).
        pose: (B, 4) int64 of the agents.
        cell: (B, C, C) which cell stands for each block.
    """
    at = (log_goal / _TIE).round().argmax(-1)
    heading, block = at // (BLOCKS * BLOCKS), at % (BLOCKS * BLOCKS)
    which = cell.flatten(1).gather(1, block[:, None]).squeeze(1).long()
    i = pose[:, 0] - (BLOCKS - 1) + 2 * (block // BLOCKS) + which // 2
    j = pose[:, 1] - (BLOCKS - 1) + 2 * (block % BLOCKS) + which % 2
    return torch.stack([i, j, heading], 1)


def divergence(log_goal: Tensor, views: Tensor, pose: Tensor, sharpness: float) -> Tensor:
    """Divergence of a policy's goals from an expert's scores of the poses, (N,) nats; 0 where there are no scores.

    The Kullback-Leibler divergence from the expert's distribution, in which a view has weight ``score ** sharpness``.

    Args:
        log_goal: (N, 4, C, C).
        views: (N, V, 4) int: cells ahead and to the left, heading from the agent's, and score relative to the best
            view's, which is 10,000; 0 for none.
        pose: (N, 4) int of the agents.
        sharpness: the higher, the more the best view counts.
    """
    heading = pose[:, 2:3].long()
    f, left, turned, score = (views[..., k].long() for k in range(4))
    cos, sin = (torch.tensor(v, device=views.device)[heading] for v in ((1, 0, -1, 0), (0, 1, 0, -1)))
    block = torch.stack([cos * f - sin * left, sin * f + cos * left], -1).add(BLOCKS - 1).div(2, rounding_mode="floor")
    inside = ((block >= 0) & (block < BLOCKS)).all(-1) & (score > 0)
    block = block.clamp(0, BLOCKS - 1)
    at = ((heading + turned) % 4 * BLOCKS + block[..., 0]) * BLOCKS + block[..., 1]
    weight = torch.where(inside, score.float() / 1e4, 0.0) ** sharpness
    flat = log_goal.flatten(1)
    best = torch.zeros_like(flat).scatter_reduce_(1, at, weight, "amax")  # views of one block count once
    total = best.sum(1, keepdim=True)
    wanted = best / total.clamp(min=1e-9)
    apart = (wanted * (wanted.clamp(min=1e-9).log() - flat.clamp(min=-30.0))).sum(1)
    return apart * (total.squeeze(1) > 0)


def _by_first(log_goal: Tensor, first: Tensor) -> Tensor:
    """(T, B, 4) log of the summed probability of the goals whose path begins with each action, at least -12."""
    summed = torch.zeros(*log_goal.shape[:-1], 4, dtype=log_goal.dtype, device=log_goal.device)
    summed = summed.scatter_add(-1, first.clamp(max=3).long(), log_goal.exp())
    return (summed + _LEAST).log()
