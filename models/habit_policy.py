"""The habit policy: a transformer over what is known of the home and what its people do, scoring where to look next.

Tokens are candidate views, things (closed containers among them), frontiers, habits and the agent's own state
(:mod:`ucon.search.search_tokens`). Belief and evidence are arithmetic (:mod:`ucon.perception.belief.target_belief`):
what was looked at in vain is in the numbers that tokens carry. The score of a view starts as its expected gain over its
cost, which is how ``belief`` chooses. The network foretells which views lie on the way to the target, which knowing
many homes can tell, and what they show of unexplored space counts by that; what it adds beside is learned as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import torch
from torch import Tensor, nn

from models.nets.sizes import check_heads, check_sizes
from models.nets.token_transformer import TokenTransformer
from ucon.core.rng import derived_seed
from ucon.search.search_tokens import N_EGO, N_FRONTIER, N_THING, THING_AHEAD
from ucon.search.searcher import LOYALTY
from ucon.search.view_tokens import AHEAD, IS_KEPT, N_VIEW

#: Width of sentence and name embeddings.
TEXT = 384
#: How much a view is preferred for being better than another one by gain over cost, at first.
_SHARPNESS: Final = 10.0
#: Metres of one unit of position in tokens.
_UNIT_M: Final = 5.0


#: Preference for the view on its way, as :mod:`ucon.search.searcher` has it.
_KEPT: Final = math.log(LOYALTY)


class Scores(NamedTuple):
    """Of B decisions."""

    logits: Tensor
    """(B, V) float32; -inf where there is no view."""
    value: Tensor
    """(B,) float32, the expected return."""
    foresight: Tensor
    """(B, V) float32, by how much going to each view is expected to shorten the way to the target: 1 right towards it,
    -1 straight away. Not bounded."""


class Attended(NamedTuple):
    """Of B decisions: what share of a view's attention goes to each token, mean over blocks and heads; sums to 1."""

    ego: Tensor
    """(B, V, 1)."""
    views: Tensor
    """(B, V, V)."""
    things: Tensor
    """(B, V, T)."""
    frontiers: Tensor
    """(B, V, F)."""
    habits: Tensor
    """(B, V, P)."""


class HabitPolicy(nn.Module):
    """Scores candidate views."""

    architecture = "habit_policy"
    chooses = "views"

    def __init__(
        self, width: int = 64, layers: int = 2, heads: int = 4, *, use_prior: bool = True, seed: int = 0
    ) -> None:
        """Make the network.

        Args:
            width: of the transformer.
            layers: its blocks.
            heads: of their attention.
            use_prior: start from gain over cost; without, everything is learned.
            seed: of the weights that learning begins with.

        Raises:
            ConfigError: a size below 1, or a width that the heads cannot share.
        """
        super().__init__()
        check_heads("agent.policy", width, heads)
        check_sizes("agent.policy", layers=layers)
        self.arguments: Mapping[str, Any] = {"width": width, "layers": layers, "heads": heads, "use_prior": use_prior}
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            self._build(width, layers, heads)

    def _build(self, width: int, layers: int, heads: int) -> None:
        self.view, self.thing = nn.Linear(N_VIEW, width), nn.Linear(N_THING, width)
        self.frontier = nn.Linear(N_FRONTIER, width)
        self.state = nn.Linear(N_EGO, width)  # of ``ego``, by the name that it has in checkpoints
        self.name = nn.Linear(TEXT, width, bias=False)
        self.habit, self.relevance = nn.Linear(TEXT, width), nn.Linear(1, width, bias=False)
        self.body = TokenTransformer(width, layers, heads, 2 * width)
        self.score = nn.Sequential(nn.Linear(2 * width, width), nn.GELU(), nn.Linear(width, 1))
        self.worth = nn.Sequential(nn.Linear(width, width), nn.GELU(), nn.Linear(width, 1))
        self.foresee = nn.Sequential(nn.Linear(2 * width, width), nn.GELU(), nn.Linear(width, 1))
        self.trust = nn.Parameter(torch.zeros(()))
        self.sharpness = nn.Parameter(torch.tensor(_SHARPNESS).log())
        for head in (self.score[-1], self.worth[-1], self.foresee[-1]):
            assert isinstance(head, nn.Linear)
            nn.init.zeros_(head.weight)
            nn.init.zeros_(head.bias)

    def forward(self, tokens: Mapping[str, Tensor]) -> Scores:
        """Score B decisions.

        Args:
            tokens: what ``UcONSearch-v0`` observes, as float32 tensors with a batch dimension, with ``thing_names``
                (B, T, 384), the embeddings of their names, in place of ``thing_rows``.
        """
        x = self.body(torch.cat(self._embedded(tokens), 1), *_positions(tokens))
        own, seen = x[:, :1], x[:, 1 : 1 + tokens["views"].shape[1]]
        joined = torch.cat([seen, own.expand_as(seen)], -1)
        logits, foresight = self.score(joined)[..., 0], self.foresee(joined)[..., 0]
        if self.use_prior:
            prior = tokens["prior"] + _KEPT * tokens["views"][..., IS_KEPT] + self._redirected(tokens, foresight)
            logits = logits + self.sharpness.exp() * prior
        logits = logits.masked_fill(tokens["action_mask"] == 0, float("-inf"))
        return Scores(logits, self.worth(own[:, 0])[..., 0], foresight)

    def attention(self, tokens: Mapping[str, Tensor]) -> Attended:
        """What the views attend to in B decisions, for people: no part of this reaches a score."""
        parts = self._embedded(tokens)
        weights = self.body.attention(torch.cat(parts, 1), *_positions(tokens)).mean((0, 2))  # (B, N, N)
        of_views = weights[:, 1 : 1 + tokens["views"].shape[1]]
        return Attended(*of_views.split([part.shape[1] for part in parts], 2))

    @property
    def adds(self) -> bool:
        """Whether the transformer says anything beside gain over cost: it begins with weights that say nothing."""
        last = (self.score[-1], self.foresee[-1])
        return any(bool(parameter.any()) for layer in last for parameter in layer.parameters())

    def _embedded(self, tokens: Mapping[str, Tensor]) -> list[Tensor]:
        """Ego, views, things, frontiers and habits: (B, N, width) each."""
        own = self.state(tokens["ego"]) + self.name(tokens["target"])
        habits = self.habit(tokens["habits"]) + self.relevance(tokens["habits_relevance"][..., None])
        things = self.thing(tokens["things"]) + self.name(tokens["thing_names"])
        return [own[:, None], self.view(tokens["views"]), things, self.frontier(tokens["frontiers"]), habits]

    def _redirected(self, tokens: Mapping[str, Tensor], foresight: Tensor) -> Tensor:
        """What is added to the logarithm of a gain whose part in unexplored space counts more on the way to the target.

        No gradient reaches the foresight, which is told the truth and is to stay it.
        """
        factor = (self.trust.exp() * foresight.detach().clamp(-1, 1)).exp()
        return (1 + tokens["unexplored"] * (factor - 1)).log()

    @property
    def use_prior(self) -> bool:
        """Whether scores start from gain over cost."""
        return bool(self.arguments["use_prior"])


def _positions(tokens: Mapping[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
    """Positions of all tokens in metres (B, N, 2), which have one, and which are there, (B, N) bool each."""
    zero = torch.zeros_like(tokens["ego"][:, None, :2])
    nowhere = torch.zeros_like(tokens["habits"][..., :2])
    xy = [zero, tokens["views"][..., AHEAD], tokens["things"][..., THING_AHEAD], tokens["frontiers"][..., :2], nowhere]
    masks = [tokens[name] for name in ("action_mask", "things_mask", "frontiers_mask", "habits_mask")]
    there = torch.cat([torch.ones_like(masks[0][:, :1]), *masks], 1) > 0
    placed = torch.ones_like(there)
    placed[:, placed.shape[1] - masks[-1].shape[1] :] = False
    return _UNIT_M * torch.cat(xy, 1), placed, there
