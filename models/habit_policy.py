"""The habit policy: a transformer over the map, the belief and the habits, which scores the views to go to next.

Tokens are candidate views, things (closed containers among them), frontiers, habits and the agent's own state
(:mod:`ucon.search.search_tokens`); a convolutional network reads an image of the map, and adds to every token that has
a position what lies around it. Belief and evidence are computed by fixed rules
(:mod:`ucon.perception.belief.target_belief`), so the tokens already account for what was searched in vain. The score of
a view starts as its expected gain over its cost, which is how ``belief`` chooses. The network predicts what lies beyond
every view, which can be learned from many homes (as PEANUT predicts targets from partial maps), and adds a learned term
to the score.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import torch
from torch import Tensor, nn

from models.nets.map_net import MapNet
from models.nets.sizes import check_heads, check_sizes
from models.nets.token_transformer import TokenTransformer
from ucon.core.errors import ConfigError
from ucon.core.rng import derived_seed
from ucon.search.beyond import MOVES
from ucon.search.search_tokens import N_EGO, N_FRONTIER, N_THING, THING_AHEAD
from ucon.search.searcher import LOYALTY
from ucon.search.view_tokens import AHEAD, IS_KEPT, N_VIEW, RIVAL

#: Size of sentence and name embeddings.
TEXT = 384
#: Initial factor of log(gain over cost) in the logits.
_SHARPNESS: Final = 10.0
#: Initial foresight: about the mean over decisions.
_USUAL_BEYOND: Final = -1.0
#: Positions in tokens are in units of this many metres.
_UNIT_M: Final = 5.0


#: Bonus, in log gain, of the view that the agent is on its way to, as in :mod:`ucon.search.searcher`.
_KEPT: Final = math.log(LOYALTY)


class Scores(NamedTuple):
    """Outputs for B decisions with V views."""

    logits: Tensor
    """(B, V) float32; -inf where there is no view."""
    value: Tensor
    """(B,) float32, estimated return."""
    foresight: Tensor
    """(B, V, R) float32, predicted log10 of the share of possible target places left within R distances of each view.

    The distances are :data:`ucon.search.beyond.MOVES`. Not bounded.
    """


class Attended(NamedTuple):
    """Attention of each view to each token in B decisions, mean over blocks and heads; sums to 1 over all kinds."""

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
    """Scores candidate views from tokens of the search."""

    architecture = "habit_policy"
    chooses = "views"

    def __init__(
        self,
        width: int = 64,
        layers: int = 2,
        heads: int = 4,
        *,
        use_prior: bool = True,
        raster: bool = True,
        silent: bool = False,
        seed: int = 0,
    ) -> None:
        """Build the network with random weights; the last layers are zero, so that it starts as gain over cost.

        Args:
            width: of the transformer.
            layers: number of its blocks.
            heads: of attention in each block.
            use_prior: True: logits start from gain over cost, and views far below the best by that measure are not
                chosen. False: everything is learned.
            raster: True: the image of the map is read. False: only tokens are (ablation).
            silent: True: only the transformer is left out, whatever its weights, so views are chosen by gain over cost.
            seed: of the initial weights.

        Raises:
            ConfigError: a size below 1, a width that the heads do not divide, or ``silent`` without ``use_prior``.
        """
        super().__init__()
        check_heads("agent.policy", width, heads)
        check_sizes("agent.policy", layers=layers)
        if silent and not use_prior:
            raise ConfigError("agent.policy.silent=true with use_prior=false: nothing is left to choose views by")
        self.silent = silent
        self.arguments: Mapping[str, Any] = {"width": width, "layers": layers, "heads": heads, "use_prior": use_prior,
                                             "raster": raster}  # fmt: skip
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            self._build(width, layers, heads, raster)

    def _build(self, width: int, layers: int, heads: int, raster: bool) -> None:
        self.view, self.thing = nn.Linear(N_VIEW, width), nn.Linear(N_THING, width)
        self.frontier = nn.Linear(N_FRONTIER, width)
        self.state = nn.Linear(N_EGO, width)  # embeds ``ego``; stored weights have this name
        self.name = nn.Linear(TEXT, width, bias=False)
        self.habit, self.relevance = nn.Linear(TEXT, width), nn.Linear(1, width, bias=False)
        self.eye = MapNet(width) if raster else None
        self.body = TokenTransformer(width, layers, heads, 2 * width)
        self.foresee = nn.Sequential(nn.Linear(2 * width, width), nn.GELU(), nn.Linear(width, len(MOVES)))
        self.score = nn.Sequential(nn.Linear(2 * width + len(MOVES), width), nn.GELU(), nn.Linear(width, 1))
        self.worth = nn.Sequential(nn.Linear(width, width), nn.GELU(), nn.Linear(width, 1))
        self.sharpness = nn.Parameter(torch.tensor(_SHARPNESS).log())
        foretold = self.foresee[-1]
        assert isinstance(foretold, nn.Linear)
        nn.init.constant_(foretold.bias, _USUAL_BEYOND)
        for head in (self.score[-1], self.worth[-1]):
            assert isinstance(head, nn.Linear)
            nn.init.zeros_(head.weight)
            nn.init.zeros_(head.bias)

    def forward(self, tokens: Mapping[str, Tensor]) -> Scores:
        """Score B decisions of up to V views.

        Args:
            tokens: observations of ``UcONSearch-v0`` as float32 tensors (B, ...) by name, but with ``thing_names`` (B,
                T, 384), embeddings of the things' names, in place of ``thing_rows``.

        Returns:
            Logits (B, V), -inf where there is no view or one far below the best, values (B,) and foresight (B, V, R).
        """
        if self.silent:
            logits = self.by_gain_over_cost(tokens)
            return Scores(logits, torch.zeros_like(logits[:, 0]), logits.new_zeros(*logits.shape, len(MOVES)))
        positions = _positions(tokens)
        x = self.body(torch.cat(self._embedded(tokens, positions[0]), 1), *positions)
        own, seen = x[:, :1], x[:, 1 : 1 + tokens["views"].shape[1]]
        joined = torch.cat([seen, own.expand_as(seen)], -1)
        foresight = self.foresee(joined)
        logits = self.score(torch.cat([joined, foresight], -1))[..., 0]
        if self.use_prior:
            logits = logits + self.by_gain_over_cost(tokens)
        logits = logits.masked_fill(tokens["action_mask"] == 0, -torch.inf)
        return Scores(logits, self.worth(own[:, 0])[..., 0], foresight)

    def by_gain_over_cost(self, tokens: Mapping[str, Tensor]) -> Tensor:
        """Logits (B, V) without the transformer, -inf where there is no view or one far below the best.

        Args:
            tokens: ``prior``, ``views`` and ``action_mask`` of :meth:`forward`.
        """
        prior = tokens["prior"] + _KEPT * tokens["views"][..., IS_KEPT]
        there = prior.masked_fill(tokens["action_mask"] == 0, -torch.inf)
        among = there > there.amax(-1, keepdim=True) - RIVAL
        return (self.sharpness.exp() * prior).masked_fill(~among, -torch.inf)

    def attention(self, tokens: Mapping[str, Tensor]) -> Attended:
        """Attention of the views to all tokens in B decisions, for display only.

        Args:
            tokens: as for :meth:`forward`.
        """
        positions = _positions(tokens)
        parts = self._embedded(tokens, positions[0])
        weights = self.body.attention(torch.cat(parts, 1), *positions).mean((0, 2))  # (B, N, N)
        of_views = weights[:, 1 : 1 + tokens["views"].shape[1]]
        return Attended(*of_views.split([part.shape[1] for part in parts], 2))

    @property
    def adds(self) -> bool:
        """Whether the transformer changes any score: False where it is silent, and while its last layers are zero."""
        if self.silent:
            return False
        if not self.use_prior:
            return True
        return any(bool(parameter.any()) for parameter in self.score[-1].parameters())

    def _embedded(self, tokens: Mapping[str, Tensor], xy: Tensor) -> list[Tensor]:
        """Embeddings of ego, views, things, frontiers and habits, (B, N, width) each; ``xy`` (B, all, 2) in metres."""
        own = self.state(tokens["ego"]) + self.name(tokens["target"])
        habits = self.habit(tokens["habits"]) + self.relevance(tokens["habits_relevance"][..., None])
        things = self.thing(tokens["things"]) + self.name(tokens["thing_names"])
        placed = [own[:, None], self.view(tokens["views"]), things, self.frontier(tokens["frontiers"])]
        if self.eye is not None:
            counts = [part.shape[1] for part in placed]
            around = self.eye(tokens["map"], xy[:, : sum(counts)]).split(counts, 1)
            placed = [part + seen for part, seen in zip(placed, around, strict=True)]
        return [*placed, habits]

    @property
    def use_prior(self) -> bool:
        """Whether logits start from gain over cost."""
        return bool(self.arguments["use_prior"])


def _positions(tokens: Mapping[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
    """Positions of all tokens in metres (B, N, 2), which tokens have one, and which exist, (B, N) bool each."""
    zero = torch.zeros_like(tokens["ego"][:, None, :2])
    nowhere = torch.zeros_like(tokens["habits"][..., :2])
    xy = [zero, tokens["views"][..., AHEAD], tokens["things"][..., THING_AHEAD], tokens["frontiers"][..., :2], nowhere]
    masks = [tokens[name] for name in ("action_mask", "things_mask", "frontiers_mask", "habits_mask")]
    there = torch.cat([torch.ones_like(masks[0][:, :1]), *masks], 1) > 0
    placed = torch.ones_like(there)
    placed[:, placed.shape[1] - masks[-1].shape[1] :] = False
    return _UNIT_M * torch.cat(xy, 1), placed, there
