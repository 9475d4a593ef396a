"""The belief head: maps habits and candidate anchors to a distribution over the target's places.

A candidate's score is the sum of two paths. The direct path adds up what the habits say for the candidate, each
weighted by its relevance to the target; nearly all of the gain comes from this path. The other path attends from
(target, candidate) pairs to the sentences, with pair features as bias and relevance as gate. Candidates do not see each
other, and habits enter only through sums and maxima, so there can be any number of either, in any order.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Final

import torch
from torch import Tensor, nn
from torch.nn import functional

from models.nets.belief.pooling import N_POOLS, pooled, strongest
from models.nets.sizes import check_heads, check_sizes
from ucon.core.errors import ConfigError
from ucon.language.encoder import DIM
from ucon.readers.evidence import SUPPORT_FLOOR
from ucon.readers.head_inputs import N_CANDIDATE, N_HABIT, N_PAIR, N_RELATIONS, N_RELEVANCE, HeadInputs

_LEAST: Final = 1e-4
#: Logit of an impossible candidate.
NEVER: Final = -60.0
SENTENCE_SCALE: Final = DIM**0.5
"""Unit vectors of DIM components times this have components of about 1."""
#: Columns of the direct path besides its channels: prior, similarity of names, gated sum and maximum, kinds, context.
N_DIRECT: Final = 4 + N_CANDIDATE + 5


@dataclass(frozen=True, eq=False)
class Inputs:
    """:class:`~ucon.readers.head_inputs.HeadInputs` as tensors, with the same names and shapes."""

    sentence: Tensor
    habit: Tensor
    pair: Tensor
    name: Tensor
    candidate: Tensor
    relation_prior: Tensor
    target: Tensor
    prior: Tensor
    relevance: Tensor
    given: Tensor
    trusted: Tensor
    open: Tensor
    holds: Tensor | None = None

    @classmethod
    def of(cls, inputs: HeadInputs) -> Inputs:
        """Convert arrays to tensors, without copies where possible."""
        values = {f.name: getattr(inputs, f.name) for f in fields(cls)}
        tensors: dict[str, Any] = {name: v if v is None else torch.as_tensor(v) for name, v in values.items()}
        return cls(**tensors)


@dataclass(frozen=True, eq=False)
class HeadOutputs:
    """Logits for T targets, C candidates and H habits.

    Probabilities are the softmax of ``anchor`` and ``unseen`` together.
    """

    anchor: Tensor
    """(T, C) logits; NEVER where a candidate cannot be the anchor."""
    unseen: Tensor
    """(T,) logit of everything that is not a candidate."""
    relation: Tensor
    """(T, C, 4) logits of the relation given the anchor."""
    relevance: Tensor
    """(T, H) logits of "the habit is about the target"."""

    @property
    def log_p(self) -> Tensor:
        """(T, C + 1) log-probabilities of the candidates and, in the last column, of everything else."""
        return torch.cat([self.anchor, self.unseen[:, None]], 1).log_softmax(1)


class BeliefHead(nn.Module):
    """Network from habits to p(anchor), p(relation | anchor) and relevance (see the module).

    Args:
        width: of tokens in the attention path.
        heads: of attention.
        blocks: of attention and feed-forward layers.
        channels: of the direct path.
        hidden: units of the layer that combines the direct path.
        dropout: in the attention path.
        pairs: use pair features (this and the next four are switches for ablations).
        evidence: use the outputs of the evidence reader.
        gate: weight habits by their relevance.
        sentences: use sentence and name vectors, which the attention path reads.
        prior: use the prior of usual places.
        pools: give the direct path the pair inputs too, pooled over the habits. It helps with text that the evidence
            reader was not fitted on; on the habit book it does not.
        mixture: give the direct path, as its initial score, the log of what the habits say plus the scaled prior. The
            reader of a dataset's own sentences was fitted in that form (:mod:`ucon.fitting.scene_evidence`).

    Raises:
        ConfigError: a size below 1, a width that the heads do not divide, or a dropout outside [0, 1).
    """

    def __init__(
        self,
        width: int = 128,
        heads: int = 4,
        blocks: int = 1,
        channels: int = 8,
        hidden: int = 48,
        dropout: float = 0.2,
        pairs: bool = True,
        evidence: bool = True,
        gate: bool = True,
        sentences: bool = True,
        prior: bool = True,
        pools: bool = False,
        mixture: bool = False,
    ) -> None:
        super().__init__()
        check_heads("learner.head", width, heads)
        check_sizes("learner.head", blocks=blocks, channels=channels, hidden=hidden)
        if not 0 <= dropout < 1:
            raise ConfigError(f"learner.head.dropout={dropout}: expected 0 to below 1")
        self.options = {
            "width": width,
            "heads": heads,
            "blocks": blocks,
            "channels": channels,
            "hidden": hidden,
            "dropout": dropout,
            "pairs": pairs,
            "evidence": evidence,
            "gate": gate,
            "sentences": sentences,
            "prior": prior,
            "pools": pools,
            "mixture": mixture,
        }
        self.pairs, self.evidence, self.gate, self.sentences, self.common = pairs, evidence, gate, sentences, prior
        self.pools, self.mixture = pools, mixture
        columns = N_DIRECT + N_POOLS * pools + channels + mixture
        self.relevance = Relevance(width, dropout)
        self.said = nn.Sequential(nn.Linear(N_PAIR + N_HABIT, 32), nn.GELU(), nn.Linear(32, channels))
        self.mix = nn.Sequential(nn.Linear(columns, hidden), nn.Tanh(), nn.Linear(hidden, 1))
        self.straight = nn.Linear(columns, 1)
        self.unseen = nn.Sequential(nn.Linear(5, 16), nn.Tanh(), nn.Linear(16, 1))
        self.relation = nn.Sequential(nn.Linear(2 * N_RELATIONS + 1, 16), nn.Tanh(), nn.Linear(16, N_RELATIONS))
        self.look = Look(width, heads, blocks, dropout)
        self.register_buffer("temperature", torch.ones(()))
        _set_to_zero(self.mix[-1], self.relation[-1])
        last = self.unseen[-1]
        assert isinstance(last, nn.Linear)
        nn.init.constant_(last.bias, -5.0)
        with torch.no_grad():  # initial score: prior plus half of each summary of what the habits say
            self.straight.weight.zero_()
            self.straight.weight[0, [0, 2, 3]] = torch.tensor([1.0, 0.5, 0.5])
            if mixture:  # initial score: the log of their sum
                self.usual = nn.Parameter(torch.zeros(()))
                self.straight.weight.zero_()
                self.straight.weight[0, -1] = 1.0

    def forward(self, inputs: HeadInputs) -> HeadOutputs:
        """Read T targets of one household.

        Args:
            inputs: arrays of T targets, C candidates and H habits; shapes in
                :class:`~ucon.readers.head_inputs.HeadInputs`.
        """
        x = self._switched(Inputs.of(inputs))
        relevance = self.relevance(x)
        gate = self._gate(relevance, x)  # (T, H)
        context = self._context(gate, x)  # (T, 5)
        direct = self._direct(gate, context, x)  # (T, C, columns)
        score = (self.mix(direct) + self.straight(direct))[..., 0]
        relation = self._relation(gate, x)
        if self.sentences:
            seen_score, seen_relation = self.look(gate, x)
            score, relation = score + seen_score, relation + seen_relation
        score, unseen = score / self.temperature, self.unseen(context)[:, 0] / self.temperature
        return HeadOutputs(score.masked_fill(~x.open, NEVER), unseen, relation, relevance)

    def _switched(self, x: Inputs) -> Inputs:
        """The inputs with ablated parts set to a constant."""
        values = {f.name: getattr(x, f.name) for f in fields(x)}
        n = N_PAIR - 3
        if not self.pairs:
            values["pair"] = torch.cat([torch.zeros_like(x.pair[..., :n]), x.pair[..., n:]], -1)
        if not self.evidence:
            values["pair"] = torch.cat([values["pair"][..., :n], torch.zeros_like(x.pair[..., n:])], -1)
            values["habit"] = torch.zeros_like(x.habit)
        if not self.sentences:
            values |= {key: torch.zeros_like(values[key]) for key in ("sentence", "name", "target")}
        if not self.common:
            values["prior"] = torch.full_like(x.prior, -4.0)
        return Inputs(**values)

    def _gate(self, relevance: Tensor, x: Inputs) -> Tensor:
        """(T, H) weight of each habit for each target, 0 where the habit is not given.

        It is at most 1, except where the habit's condition holds in the given context.
        """
        known = torch.ones_like(relevance) if not self.gate else relevance.sigmoid()
        gate = torch.where(x.trusted[:, None], 1.0, known) * x.given
        return gate if x.holds is None else gate * x.holds

    def _context(self, gate: Tensor, x: Inputs) -> Tensor:
        """(T, 5) how much text there is: logs of counts, and whether the habits are trusted and any are given."""
        place = x.habit[:, 0]
        amount = [gate @ place, gate.sum(1), x.given.sum(1).to(gate)]
        counts = torch.log1p(torch.stack(amount, 1))
        kinds = torch.stack([x.trusted.to(gate), (amount[2] > 0).to(gate)], 1)
        return torch.cat([counts, kinds], 1)

    def _direct(self, gate: Tensor, context: Tensor, x: Inputs) -> Tensor:
        """(T, C, columns) features of each candidate: prior, names, and what the habits say for it."""
        said = x.pair[..., N_PAIR - 3]  # (H, C)
        every = torch.cat([x.pair, x.habit[:, None].expand(-1, x.pair.shape[1], -1)], -1)
        channels = functional.softplus(self.said(every) - 2.0)  # (H, C, K)
        counted = torch.einsum("th,hck->tck", gate, channels)
        total = gate @ said
        most = strongest(gate, said)
        alike = (functional.normalize(x.target, dim=1) @ functional.normalize(x.name, dim=1).T)[..., None]
        c = x.prior.shape[1]
        parts = [
            x.prior[..., None],
            alike,
            torch.log(SUPPORT_FLOOR + total)[..., None],
            torch.log(SUPPORT_FLOOR + most)[..., None],
            x.candidate.expand(len(gate), -1, -1),
            context[:, None].expand(-1, c, -1),
            torch.log(SUPPORT_FLOOR + counted),
        ]
        if self.pools:
            parts.append(pooled(gate, x.pair))
        if self.mixture:
            parts.append(torch.log(_LEAST + total + self.usual.exp() * x.prior.exp())[..., None])
        return torch.cat(parts, -1)

    def _relation(self, gate: Tensor, x: Inputs) -> Tensor:
        """(T, C, 4) logits of relations, from the prior and from the habits that speak for the candidate."""
        said, how = x.pair[..., N_PAIR - 3], x.habit[:, 1:]
        heard = torch.einsum("th,hc,hr->tcr", gate, said, how)
        usual = x.relation_prior.expand(len(gate), -1, -1)
        amount = torch.log(SUPPORT_FLOOR + heard.sum(-1, keepdim=True))
        plain = torch.log(1e-4 + 0.5 * usual + heard * (usual > 0))
        return plain + self.relation(torch.cat([torch.log(SUPPORT_FLOOR + heard), usual, amount], -1))


class Relevance(nn.Module):
    """Relevance of habits to targets: the fitted gate's logit plus learned corrections.

    Args:
        width: of the projections that compare habit and target.
        dropout: of their inputs.
    """

    def __init__(self, width: int, dropout: float) -> None:
        super().__init__()
        self.habit, self.target = nn.Linear(DIM, width), nn.Linear(DIM, width)
        self.correct = nn.Sequential(nn.Linear(N_RELEVANCE + N_HABIT, 32), nn.GELU(), nn.Linear(32, 1))
        self.drop = nn.Dropout(dropout)
        self.scale = nn.Parameter(torch.zeros(()))
        _set_to_zero(self.correct[-1])

    def forward(self, x: Inputs) -> Tensor:
        """(T, H) logits of "the habit is about the target"."""
        t = len(x.target)
        alike = self.drop(self.target(x.target)) @ self.drop(self.habit(x.sentence)).T  # (T, H)
        every = torch.cat([x.relevance, x.habit.expand(t, -1, -1)], -1)
        return x.relevance[..., -1] + self.correct(every)[..., 0] + self.scale * alike


class Look(nn.Module):
    """Attention path: (target, candidate) pairs attend to the sentences.

    Args:
        width: of tokens.
        heads: of attention.
        blocks: number of blocks.
        dropout: of inputs and blocks.
    """

    def __init__(self, width: int, heads: int, blocks: int, dropout: float) -> None:
        super().__init__()
        self.habit = nn.Linear(DIM + N_HABIT, width)
        self.name, self.target = nn.Linear(DIM + N_CANDIDATE, width), nn.Linear(DIM, width)
        self.drop = nn.Dropout(dropout)
        self.blocks = nn.ModuleList(HeadBlock(width, heads, dropout) for _ in range(blocks))
        self.norm = nn.LayerNorm(width)
        self.score, self.relation = nn.Linear(width, 1), nn.Linear(width, N_RELATIONS)
        _set_to_zero(self.score, self.relation)

    def forward(self, gate: Tensor, x: Inputs) -> tuple[Tensor, Tensor]:
        """Read all pairs of targets and candidates.

        Args:
            gate: (T, H) weight of each habit.
            x: the inputs.

        Returns:
            Scores (T, C) and logits of relations (T, C, 4).
        """
        habits = self.habit(torch.cat([self.drop(x.sentence * SENTENCE_SCALE), x.habit], 1))  # (H, d)
        names = self.name(torch.cat([self.drop(x.name * SENTENCE_SCALE), x.candidate], 1))  # (C, d)
        query = names + self.target(self.drop(x.target * SENTENCE_SCALE))[:, None]  # (T, C, d)
        for block in self.blocks:
            query = block(query, habits, x.pair, gate)
        query = self.norm(query)
        return self.score(query)[..., 0], self.relation(query)


class HeadBlock(nn.Module):
    """Attention of (target, candidate) tokens over habits, with pair features as bias and the gate as weight.

    Args:
        width: of tokens.
        heads: of attention.
        dropout: after attention and in the feed-forward layers.
    """

    def __init__(self, width: int, heads: int, dropout: float) -> None:
        super().__init__()
        self.heads = heads
        self.norm, self.habit_norm = nn.LayerNorm(width), nn.LayerNorm(width)
        self.q, self.kv, self.out = nn.Linear(width, width), nn.Linear(width, 2 * width), nn.Linear(width, width)
        self.bias = nn.Linear(N_PAIR, heads)
        self.feed = nn.Sequential(
            nn.LayerNorm(width),
            nn.Linear(width, 2 * width),
            nn.GELU(),
            nn.Dropout(dropout),
            nn.Linear(2 * width, width),
        )
        self.drop = nn.Dropout(dropout)

    def forward(self, query: Tensor, habits: Tensor, pair: Tensor, gate: Tensor) -> Tensor:
        """Update the tokens of all pairs.

        Args:
            query: (T, C, d) tokens.
            habits: (H, d).
            pair: (H, C, N_PAIR) features.
            gate: (T, H) weight of each habit.

        Returns:
            (T, C, d).
        """
        t, c, d = query.shape
        k, v = self.kv(self.habit_norm(habits)).view(-1, 2, self.heads, d // self.heads).unbind(1)  # (H, n, e)
        q = self.q(self.norm(query)).view(t, c, self.heads, d // self.heads)
        logits = torch.einsum("tcne,hne->tnch", q, k) / q.shape[-1] ** 0.5
        logits = logits + self.bias(pair).permute(2, 1, 0) + torch.log(gate + 1e-9)[:, None, None]
        # A constant logit of 0 takes the attention that no habit claims; without habits the result is 0.
        weights = torch.cat([logits, logits.new_zeros(t, self.heads, c, 1)], -1).softmax(-1)[..., :-1]
        looked = torch.einsum("tnch,hne->tcne", weights, v).reshape(t, c, d)
        query = query + self.drop(self.out(looked))
        return query + self.drop(self.feed(query))


def _set_to_zero(*layers: nn.Module) -> None:
    """Set linear layers to zero, so that they add nothing at first."""
    for layer in layers:
        assert isinstance(layer, nn.Linear)
        nn.init.zeros_(layer.weight)
        nn.init.zeros_(layer.bias)
