"""Detections as tokens: category, position, belief that the target is with the thing, and attention to the habits.

Attention scores are the similarity of vectors plus the log of the reader's support: how strongly a habit speaks for the
target being at a thing of this category.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor, nn

from models.nets.end_to_end.ego_view import THING_FEATURES
from models.nets.end_to_end.read_habits import HABIT_FEATURES, STATIC_FEATURES, words

REACH_M = 0.98
"""Horizontal distance of a thing's nearest seen point within which it can be opened or taken; the task allows 1 m."""
N_CUES = 10
TAKE_M = 1.0
"""Done is possible within this distance of the target's seen part.

That part lies in the target's box, so Done is then never said too far away: none of 25 searches ended too early; at a
distance a fifth larger, 14 of 50 did. Some stored solutions end a little farther away.
"""
_SCALE = {"ahead_m": 0.25, "left_m": 0.25, "up_m": 0.5, "nearest_m": 0.25, "pixels": 0.25}
_FLOOR = 0.02


class Seen(NamedTuple):
    """Results for the things in view at T steps of B episodes."""

    summary: Tensor
    """(T, B, 3 width): attention-weighted mean, maximum, and what the habits say of the things."""
    cues: Tensor
    """(T, B, N_CUES) facts that can decide alone: target in view, target in reach, a closed container in reach."""
    attention: Tensor
    """(T, B, N, K) attention of each thing to each habit."""
    focus: Tensor
    """(T, B, N) attention of the agent to each thing."""
    near: Tensor
    """(T, B) bool, True where the target may be in reach."""
    in_view: Tensor
    """(T, B) bool, True where the target shows."""
    openable: Tensor
    """(T, B) bool, True where Open may open something: a closed container shows and is in reach."""


class ThingsInView(nn.Module):
    """Network that reads the tokens of things."""

    vectors: Tensor
    static: Tensor
    anchor: Tensor
    openable: Tensor

    def __init__(self, width: int, known: tuple[str, ...], goal_dim: int) -> None:
        """Build the network.

        Args:
            width: of tokens.
            known: anchors that the reader knows.
            goal_dim: size of text embeddings.
        """
        super().__init__()
        book = words()
        vectors = torch.from_numpy(book.vectors).float()
        static = torch.zeros(len(vectors) + 1, len(STATIC_FEATURES))
        static[:-1, :-1] = torch.from_numpy(book.static)
        anchor = torch.full((len(vectors) + 1,), len(known))
        for k, name in enumerate(known):
            if name in book.number:
                anchor[book.number[name]] = k
                static[book.number[name], -1] = 1.0
        blank = torch.zeros(1, vectors.shape[1])
        # The last row is for names outside the catalogue.
        self.register_buffer("vectors", torch.cat([vectors, blank]), persistent=False)
        self.register_buffer("static", static, persistent=False)
        self.register_buffer("anchor", anchor, persistent=False)
        self.register_buffer("openable", static[:, 0] > 0.5, persistent=False)
        scale = torch.tensor([_SCALE.get(name, 1.0) for name in THING_FEATURES])
        self.register_buffer("scale", scale, persistent=False)
        self.name = nn.Linear(vectors.shape[1], width)
        self.numbers = nn.Linear(len(THING_FEATURES) + len(STATIC_FEATURES) + 9, width)
        self.mix = nn.Sequential(nn.ReLU(), nn.Linear(width, width), nn.ReLU())
        self.habit_key = nn.Linear(goal_dim + len(HABIT_FEATURES), width)
        self.habit_value = nn.Linear(goal_dim + len(HABIT_FEATURES), width)
        self.ask = nn.Linear(width, width)
        self.told = nn.Linear(width, width)
        self.goal = nn.Linear(goal_dim, width)
        self.key = nn.Linear(width, width)
        self.support_weight = nn.Parameter(torch.tensor(1.0))
        self.mass_weight = nn.Parameter(torch.tensor(1.0))

    scale: Tensor

    def forward(self, ids: Tensor, things: Tensor, opened: Tensor, mass: Tensor, context: dict[str, Tensor]) -> Seen:
        """Read the things of T steps of B episodes.

        Args:
            ids: (T, B, N) number of the category, -1 where there is no thing.
            things: (T, B, N, len(THING_FEATURES)).
            opened: (T, B, N) bool, was opened before.
            mass: (T, B, N, 4) relative belief: on top, beside or under, inside, behind closed doors.
            context: of :func:`models.nets.end_to_end.read_habits.read_habits`, (B, ...) by name.
        """
        there, row = ids >= 0, ids.clamp(min=0)
        is_target = (ids == context["target"][None, :, None]) & there
        reach = (things[..., THING_FEATURES.index("nearest_m")] <= REACH_M) & there
        closed = self.openable[row] & ~opened & reach
        flags = torch.stack([is_target, reach, closed, opened], -1).float()
        episode = torch.arange(ids.shape[1], device=ids.device)[None, :, None]
        advised = context["advice"].float()[episode, row][..., None]
        numbers = torch.cat([things * self.scale, self.static[row], mass.sqrt(), advised, flags], -1)
        names = self._names(row)
        tokens = self.mix(names + self.numbers(numbers))
        tokens, attention = self._attend(tokens, self.anchor[row], context)
        ask = self.goal(context["goal"].float())[None, :, None]
        score = (self.key(tokens) * ask).sum(-1) / tokens.shape[-1] ** 0.5
        score = score + self.mass_weight * torch.log(mass.sum(-1) + _FLOOR) + 4.0 * is_target
        focus = torch.softmax(score.masked_fill(~there, -1e4), -1) * there
        pooled = (focus[..., None] * tokens).sum(-2)
        largest = (tokens * there[..., None]).amax(-2)
        told = (focus[..., None] * self._value(attention, context)).sum(-2)
        summary = torch.cat([pooled, largest, told], -1)
        near = (is_target & (things[..., THING_FEATURES.index("nearest_m")] <= TAKE_M)).any(-1)
        return Seen(
            summary,
            _cues(is_target, reach, closed, things, mass),
            attention,
            focus,
            near,
            is_target.any(-1),
            closed.any(-1),
        )

    def _names(self, row: Tensor) -> Tensor:
        """Projected names of categories; projects rows or the whole table first, whichever is smaller."""
        if row.numel() < len(self.vectors):
            return self.name(self.vectors[row])  # type: ignore[no-any-return]
        return nn.functional.embedding(row, self.name(self.vectors))

    def _attend(self, tokens: Tensor, anchor: Tensor, context: dict[str, Tensor]) -> tuple[Tensor, Tensor]:
        """Cross-attention of tokens (T, B, N, D) to K habits; the new tokens, and the attention (T, B, N, K)."""
        habits = _habits(context)
        there = context["habit_features"][..., 0] > 0.5  # (B, K)
        support = nn.functional.pad(context["support"].float(), (0, 1)).transpose(1, 2)  # (B, A + 1, K)
        episode = torch.arange(len(there), device=anchor.device)[None, :, None]
        pair = support[episode, anchor]  # (T, B, N, K)
        score = torch.einsum("tbnd,bkd->tbnk", self.ask(tokens), self.habit_key(habits)) / tokens.shape[-1] ** 0.5
        score = score + self.support_weight * torch.log(pair + _FLOOR)
        score = score.masked_fill(~there[None, :, None], -1e4)
        attention = torch.softmax(score, -1) * there[None, :, None]
        return tokens + self._value(attention, context), attention

    def _value(self, attention: Tensor, context: dict[str, Tensor]) -> Tensor:
        value = self.habit_value(_habits(context))
        return self.told(torch.relu(torch.einsum("tbnk,bkd->tbnd", attention, value)))  # type: ignore[no-any-return]


def _habits(context: dict[str, Tensor]) -> Tensor:
    return torch.cat([context["habit_vectors"].float(), context["habit_features"].float()], -1)


def _cues(is_target: Tensor, reach: Tensor, closed: Tensor, things: Tensor, mass: Tensor) -> Tensor:
    """Facts of each frame, (T, B, N_CUES)."""
    seen = is_target.any(-1)
    where = (things[..., :6] * is_target[..., None]).sum(-2) / is_target.sum(-1, keepdim=True).clamp(min=1)
    hope = (mass[..., 3] * closed).amax(-1)
    return torch.cat(
        [
            torch.stack([seen, (is_target & reach).any(-1), closed.any(-1)], -1).float(),
            hope.sqrt()[..., None],
            where[..., :4] * 0.25,
            where[..., 4:],
        ],
        -1,
    )
