"""The condition reader: does what a sentence says hold in the told context?

For each kind of condition (day, hour, season, occasion) a softmax regression gives three probabilities: the sentence
holds, fails, or is silent about it. Its features are the calendar's words, the likeness of the sentence to what was
told and to the rest of the calendar, and a linear probe that tells whether the sentence has a condition of that kind at
all. Fitted on train entries (:mod:`ucon.fitting.conditions`). Who asks is read by name.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared, is_the_one
from ucon.habits.contexts import SEASONS, Context, part_of_day
from ucon.language.store import StoredEncoder, default_encoder
from ucon.language.words import stems
from ucon.readers.conditions.calendar_words import days_named, hours_named, names_in, seasons_named
from ucon.readers.reader_weights import Array, load_arrays, softmax, unpacked_names

WEIGHTS: Final = Path(__file__).parents[1] / "data" / "conditions.npz"
KINDS: Final = ("day", "time", "season", "occasion")
"""Kinds of conditions that are fitted; who asks is the fifth column of :class:`Holding`."""
N_FEATURES: Final = 8
USES: Final = ("fitted", "head", "retrieval", "language")
"""Who weighs sentences: the fitted reader, the belief head, retrieval, the sentence encoder as a language model."""
PARTS_OF_DAY: Final = ("morning", "afternoon", "evening", "night")
DECIMALS: Final = 4
#: Likeness of a sentence and a time of the calendar is multiplied by this, so that features have similar scales.
_SCALE: Final = 10.0
#: Most sentences whose readings are cached, over all knowledge bases; one of these is cached whatever its size.
_REMEMBERED: Final = 60_000
_PHRASES: Final[Mapping[str, Sequence[str]]] = {
    "day": ("on weekdays, from Monday to Friday", "at the weekend, on Saturday and Sunday"),
    "time": ("in the morning, at breakfast", "in the afternoon", "in the evening, after supper", "at night, in bed"),
    "season": tuple(f"in {season}" for season in SEASONS),
}


@dataclass(frozen=True, eq=False)
class Holding:
    """What H sentences say about the told context, by kind: day, time, season, occasion, user."""

    holds: Array
    """(H, 5) probability that a sentence has a condition of this kind and that it holds."""
    fails: Array
    """(H, 5) probability that it has one and that it does not hold."""

    def weights(self, strength: Strength) -> Array:
        """(H,) how much each sentence counts: 1 where it is silent, above 1 where it holds, below where it fails.

        Args:
            strength: of the reader that uses them.
        """
        parts = 1.0 + (strength.holds - 1.0) * self.holds - (1.0 - strength.fails) * self.fails
        return np.round(np.prod(parts, axis=1), DECIMALS)


@dataclass(frozen=True)
class Strength:
    """How a reader follows conditions; fitted for each use."""

    holds: float
    """Weight of a sentence whose condition holds for certain."""
    fails: float
    """Weight of one whose condition fails for certain."""
    sharpness: float = 1.0
    """Power to which the fitted anchor reader raises the effect of the weights; others do not use it."""


@dataclass(frozen=True, eq=False)
class ReadSentences:
    """What is read from H sentences before any context is told."""

    named: Mapping[str, NDArray[np.bool_]]
    """By kind: which days (H, 7), hours (H, 24), seasons (H, 4) or known occasions (H, O) they name."""
    likeness: Mapping[str, Array]
    """By kind: cosine (H, n) with each of n phrases of the calendar, or each known occasion."""
    half: NDArray[np.float16]
    """(H, D) embeddings."""
    stems: tuple[frozenset[str], ...]
    names: tuple[frozenset[str], ...]
    """By sentence: capitalised words, among them the names of people."""

    def __len__(self) -> int:
        return len(self.stems)

    @property
    def vectors(self) -> Array:
        """(H, D) embeddings in float64."""
        return self.half.astype(np.float64)

    def one(self, k: int) -> ReadSentences:
        """The k-th sentence alone."""
        named = {kind: rows[k : k + 1] for kind, rows in self.named.items()}
        like = {kind: rows[k : k + 1] for kind, rows in self.likeness.items()}
        return ReadSentences(named, like, self.half[k : k + 1], self.stems[k : k + 1], self.names[k : k + 1])


class ConditionReader(Shared):
    """Reads conditions of sentences. One per process; it caches what it has read.

    Args:
        probe: (D + 1, 4) weights and bias of the probes, one per kind.
        shares: (4, N_FEATURES, 3) weights of holds, fails and silent, by kind.
        occasions: O known occasions.
        words: (O,) stems that refer to each occasion.
        strengths: by use (:data:`USES`).
        encoder: of sentences.
    """

    def __init__(
        self,
        probe: Array,
        shares: Array,
        occasions: Sequence[str],
        words: Sequence[frozenset[str]],
        strengths: Mapping[str, Strength],
        encoder: StoredEncoder | None = None,
    ) -> None:
        self.probe, self.shares, self.strengths = probe, shares, dict(strengths)
        self.occasions, self.words = tuple(occasions), tuple(words)
        self.encoder = encoder or default_encoder()
        phrases = {**_PHRASES, "occasion": [occasion_phrase(name) for name in self.occasions]}
        self._calendar = {kind: self.encoder.encode_half(texts).astype(np.float64) for kind, texts in phrases.items()}
        self._times = np.concatenate([self._calendar[kind] for kind in KINDS])
        self._ends_like = np.cumsum([len(self._calendar[kind]) for kind in KINDS])
        self._ends_named = np.cumsum([7, 24, len(SEASONS), len(self.occasions)])
        self._occasions_by_stem: dict[str, list[int]] = {}
        for k, one in enumerate(self.words):
            for stem in one:
                self._occasions_by_stem.setdefault(stem, []).append(k)
        self._rows: dict[str, tuple[NDArray[np.bool_], Array]] = {}
        self._read: OrderedDict[tuple[str, ...], tuple[ReadSentences, Array]] = OrderedDict()
        known = zip(self._calendar["occasion"], self.words, strict=True)
        self._told_occasions = dict(zip(self.occasions, known, strict=True))

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickle the shipped reader by name; its weights are checked wherever they are loaded."""
        return (default_conditions, ()) if is_the_one(default_conditions, self) else super().__reduce_ex__(protocol)

    def holding(self, texts: Sequence[str], context: Context) -> Holding:
        """Read H sentences in a context.

        Args:
            texts: the sentences.
            context: the context that was told.
        """
        read, mention = self._known(tuple(texts))
        holds, fails = np.zeros((len(read), len(KINDS) + 1)), np.zeros((len(read), len(KINDS) + 1))
        if not len(read):
            return Holding(holds, fails)
        for k, kind in enumerate(KINDS):
            x = self.features(read, context, kind, mention[:, k])
            share = softmax(np.round(x @ self.shares[k], DECIMALS))
            holds[:, k], fails[:, k] = share[:, 0], share[:, 1]
        if context.user is not None:
            mine = names_in(context.user)
            others = names_in(context.asker) - mine
            holds[:, -1] = [bool(names & mine) for names in read.names]
            fails[:, -1] = [bool(names & others) and not names & mine for names in read.names]
        return Holding(holds, fails)

    def weights(self, texts: Sequence[str], context: Context, use: str) -> Array:
        """(H,) how much each sentence counts in the told context.

        Args:
            texts: H sentences.
            context: the context that was told.
            use: whose strength, of :data:`USES`.
        """
        return self.holding(texts, context).weights(self.strengths[use])

    def mentions(self, read: ReadSentences) -> Array:
        """(H, 4) logit that each sentence has a condition, by kind, whatever was told."""
        return read.vectors @ self.probe[:-1] + self.probe[-1]

    def features(self, read: ReadSentences, context: Context, kind: str, mention: Array) -> Array:
        """Features of H sentences in a context, (H, N_FEATURES).

        Bias; told time named; other times named; another day, but of the same part of the week, named; likeness to what
        was told, and how far that exceeds the largest other likeness; whether no occasion was told; the probe's logit.

        Args:
            read: of :meth:`sentences`.
            context: the context that was told.
            kind: of :data:`KINDS`.
            mention: (H,) of :meth:`mentions`.
        """
        named, like = read.named[kind], read.likeness[kind]
        x = np.zeros((len(read), N_FEATURES))
        x[:, 0], x[:, 7] = 1.0, mention
        if kind == "occasion" and context.occasion is None:
            x[:, 2], x[:, 5], x[:, 6] = named.any(1), -_SCALE * like.max(1), 1.0
            return x
        if kind == "occasion":
            vector, words = self._occasion(str(context.occasion))
            others = [k for k, name in enumerate(self.occasions) if name != context.occasion]
            hit = np.asarray([not said.isdisjoint(words) for said in read.stems])
            told = np.round(read.vectors @ vector, DECIMALS)
            rest = like[:, others].max(1)
        else:
            value, phrase = _told(context, kind)
            hit, told, rest = named[:, value], like[:, phrase], np.delete(like, phrase, 1).max(1)
        x[:, 1], x[:, 2] = hit, named.any(1) & ~hit
        if kind == "day":
            week, end = named[:, :5].any(1), named[:, 5:].any(1)
            x[:, 3] = (x[:, 2] > 0) & ((end & ~week) if context.day > 4 else (week & ~end))
        x[:, 4], x[:, 5] = _SCALE * told, _SCALE * (told - rest)
        return x

    def _occasion(self, name: str) -> tuple[Array, frozenset[str]]:
        """Vector and stems of an occasion; if no train entry names it, from its own words."""
        if name not in self._told_occasions:
            vector = self.encoder.encode_half([occasion_phrase(name)])[0].astype(np.float64)
            self._told_occasions[name] = vector, frozenset(stems(name.replace("/", " ").replace("-", " ")))
        return self._told_occasions[name]

    def sentences(self, texts: Sequence[str]) -> ReadSentences:
        """What H sentences say about the calendar, each read once."""
        half = self.encoder.encode_half(texts)
        rows = self._rows_of(texts, half)
        named = np.stack([row[0] for row in rows]) if rows else np.zeros((0, self._ends_named[-1]), bool)
        like = np.stack([row[1] for row in rows]) if rows else np.zeros((0, self._ends_like[-1]))
        return ReadSentences(
            dict(zip(KINDS, np.split(named, self._ends_named[:-1], axis=1), strict=True)),
            dict(zip(KINDS, np.split(like, self._ends_like[:-1], axis=1), strict=True)),
            half,
            tuple(frozenset(stems(text)) for text in texts),
            tuple(map(names_in, texts)),
        )

    def _rows_of(self, texts: Sequence[str], half: NDArray[np.float16]) -> list[tuple[NDArray[np.bool_], Array]]:
        """For each sentence, what it names and its likeness, kinds side by side; new sentences are read together."""
        new = {text: k for k, text in enumerate(texts) if text not in self._rows}
        if len(self._rows) + len(new) > _REMEMBERED:
            self._rows.clear()
            new = {text: k for k, text in enumerate(texts)}
        if new:
            like = np.round(half[list(new.values())].astype(np.float64) @ self._times.T, DECIMALS)
            named = np.zeros((len(new), self._ends_named[-1]), bool)
            for row, text in zip(named, new, strict=True):
                row[self._named(text)] = True
            self._rows.update(zip(new, zip(named, like, strict=True), strict=True))
        return [self._rows[text] for text in texts]

    def _named(self, text: str) -> list[int]:
        """Columns of the days, hours, seasons and known occasions that a sentence names."""
        hours, seasons, occasions = self._ends_named[:3]
        occasion = {k for stem in stems(text) for k in self._occasions_by_stem.get(stem, ())}
        return [
            *days_named(text),
            *(hours + hour for hour in hours_named(text)),
            *(seasons + season for season in seasons_named(text)),
            *(occasions + k for k in occasion),
        ]

    def _known(self, texts: tuple[str, ...]) -> tuple[ReadSentences, Array]:
        """Sentences as read, and their mentions; cached, since the same ones are asked about in many contexts."""
        if texts not in self._read:
            read = self.sentences(texts)
            self._read[texts] = read, self.mentions(read)
        self._read.move_to_end(texts)
        while len(self._read) > 1 and sum(map(len, self._read)) > _REMEMBERED:
            self._read.popitem(last=False)
        return self._read[texts]


@cache
def default_conditions() -> ConditionReader:
    """The shipped reader, one per process.

    Raises:
        DataError: its weights are missing or altered.
    """
    arrays, _ = load_arrays(WEIGHTS)
    strengths = zip(USES, arrays["strengths"].astype(np.float64).tolist(), strict=True)  # (4, 3)
    return ConditionReader(
        arrays["probe"].astype(np.float64),
        arrays["shares"].astype(np.float64),
        unpacked_names(arrays["occasions"]),
        [frozenset(line.split()) for line in unpacked_names(arrays["words"])],
        {use: Strength(*pair) for use, pair in strengths},
    )


def counting(
    conditions: ConditionReader, texts: Sequence[str], use: str, context: Context | None, valid: Array | None
) -> Array | None:
    """How much each of H sentences counts, (H,): by what was told, and by whether it still holds; None: all alike.

    Args:
        conditions: reads what was told.
        texts: H sentences.
        use: whose strength, of :data:`USES`.
        context: the context that was told; None: none was told.
        valid: (H,) probability that each habit has not changed since it was told; None: none has changed.
    """
    holds = None if context is None else conditions.weights(texts, context, use)
    if valid is None:
        return holds
    return np.round(valid if holds is None else holds * valid, DECIMALS)


def _told(context: Context, kind: str) -> tuple[int, int]:
    """The told time: its number, and the number of its phrase."""
    if kind == "day":
        return context.day, int(context.day > 4)
    if kind == "time":
        return context.hour, PARTS_OF_DAY.index(part_of_day(context.hour))
    return SEASONS.index(context.season), SEASONS.index(context.season)


def occasion_phrase(occasion: str) -> str:
    """An occasion as a text to compare sentences with: ``when there is visit (guests)``."""
    group, _, name = occasion.partition("/")
    return f"when there is {name.replace('-', ' ')} ({group})"
