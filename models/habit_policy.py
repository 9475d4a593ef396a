"""The habit policy: a transformer over what is known of the home and what its people do, scoring where to look next.

Tokens are candidate views, things (closed containers among them), frontiers, habits and the agent's own state
(:mod:`ucon.envs.waypoint.tokens`). Belief and evidence are arithmetic (:mod:`ucon.perception.belief`): what was
looked at in vain is in the numbers that tokens carry. The score of a view starts as its expected gain over its cost,
which is how ``belief`` chooses; what the network adds to it is learned.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import torch
from torch import Tensor, nn

from models.nets.token_transformer import TokenTransformer
from ucon.envs.waypoint.tokens import N_FRONTIER, N_STATE, N_THING
from ucon.envs.waypoint.view_tokens import N_VIEW

#: Width of sentence and name embeddings.
TEXT = 384
#: How much a view is preferred for being better than another one by gain over cost, at first.
_SHARPNESS = 10.0
_FAR = 5.0
"""Metres of one unit of position in tokens."""


class Scores(NamedTuple):
    """Of B decisions."""

    logits: Tensor
    """(B, V) float32; -inf where there is no view."""
    value: Tensor
    """(B,) float32, the expected return."""
    attention: Tensor | None = None


class HabitPolicy(nn.Module):
    """Scores candidate views.

    Args:
        width, layers, heads: of the transformer.
        use_prior: start from gain over cost.
    """

    def __init__(self, width: int = 128, layers: int = 3, heads: int = 4, *, use_prior: bool = True) -> None:
        super().__init__()
        self.use_prior = use_prior
        self.view, self.thing = nn.Linear(N_VIEW, width), nn.Linear(N_THING, width)
        self.frontier, self.state = nn.Linear(N_FRONTIER, width), nn.Linear(N_STATE, width)
        self.name = nn.Linear(TEXT, width, bias=False)
        self.habit, self.relevance = nn.Linear(TEXT, width), nn.Linear(1, width, bias=False)
        self.body = TokenTransformer(width, layers, heads, 2 * width)
        self.score = nn.Sequential(nn.Linear(2 * width, width), nn.GELU(), nn.Linear(width, 1))
        self.worth = nn.Sequential(nn.Linear(width, width), nn.GELU(), nn.Linear(width, 1))
        self.sharpness = nn.Parameter(torch.tensor(_SHARPNESS).log())
        for head in (self.score, self.worth):
            nn.init.zeros_(head[-1].weight)
            nn.init.zeros_(head[-1].bias)

    def forward(self, tokens: Mapping[str, Tensor]) -> Scores:
        """Score B decisions.

        Args:
            tokens: as in :class:`ucon.envs.waypoint.tokens.Tokens`, with a batch dimension, ``thing_names`` (B, T, 384) in
                place of ``thing_rows``, and of the episode ``target`` (B, 384), ``habits`` (B, P, 384), ``habits_relevance`` (B, P),
                ``habits_mask`` (B, P).
        """
        views, things, frontiers = tokens["views"], tokens["things"], tokens["frontiers"]
        state = self.state(tokens["state"]) + self.name(tokens["target"])
        habits = self.habit(tokens["habits"]) + self.relevance(tokens["habits_relevance"][..., None])
        parts = [state[:, None], self.view(views), self.thing(things) + self.name(tokens["thing_names"])]
        parts += [self.frontier(frontiers), habits]
        there = [torch.ones_like(tokens["views_mask"][:, :1])]
        there += [tokens[f"{name}_mask"] for name in ("views", "things", "frontiers", "habits")]
        zero = torch.zeros_like(tokens["state"][:, None, :2])
        xy = [zero, views[..., 10:12], things[..., 4:6], frontiers[..., :2], torch.zeros_like(tokens["habits"][..., :2])]
        n_habits = tokens["habits_mask"].shape[1]
        is_there = torch.cat(there, 1) > 0
        placed = is_there.clone()
        placed[:, placed.shape[1] - n_habits :] = False
        x = self.body(torch.cat(parts, 1), _FAR * torch.cat(xy, 1), placed, is_there)
        v = views.shape[1]
        own, seen = x[:, :1], x[:, 1 : 1 + v]
        logits = self.score(torch.cat([seen, own.expand_as(seen)], -1))[..., 0]
        if self.use_prior:
            logits = logits + self.sharpness.exp() * (tokens["prior"] + _KEPT * views[..., 9])
        logits = logits.masked_fill(tokens["views_mask"] == 0, float("-inf"))
        return Scores(logits, self.worth(own[:, 0])[..., 0])


#: Logarithm of the loyalty to the view on its way (:data:`ucon.envs.waypoint.searcher.LOYALTY`).
_KEPT = 0.2231
