"""``learner=retriever``: trains the sentence encoder to retrieve a target's habits, by InfoNCE within knowledge bases.

Only a low-rank adapter is trained. One step is one knowledge base: each of its categories asks the paper's query, its
own habits are the positives, and the habits of other categories the negatives. Habits that support a placement weigh
more, since they are the ones that help a search. A step depends only on seed and number, so a resumed run repeats an
uninterrupted one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from ucon.core.device import torch_precision
from ucon.core.errors import ConfigError, brief
from ucon.core.files import sha256_file
from ucon.core.progress import part
from ucon.core.rng import derived_seed
from ucon.fitting.measures import measure_retrieval
from ucon.fitting.rate_schedule import schedule
from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.splits import entry_parts
from ucon.habits.types import HabitDataset
from ucon.language.adapter import adapter_bytes, add_adapters, begin_with, read_adapter
from ucon.language.batch_encoder import BatchEncoder
from ucon.language.encoder import MINILM_SHA256, MiniLM
from ucon.language.phrases import query_text
from ucon.learning.run.counted_steps import CountedSteps
from ucon.learning.run.options import RetrieverOptions
from ucon.learning.run.protocol import Card, Figures
from ucon.learning.run.updates import Updates
from ucon.readers.sampled_homes import part_kb
from ucon.retrieval.base import ranked
from ucon.retrieval.tuned import adapter_file

PRODUCT = "retriever.safetensors"


def info_nce(similarity: Tensor, own: Tensor, weight: Tensor, temperature: float) -> Tensor:
    """Contrastive loss of queries against habits, a scalar.

    For each positive of a query, the negatives are the habits of other targets; its other positives are left out.

    Args:
        similarity: (Q, N) cosines of queries and habits.
        own: (Q, N) bool, True where the habit is about the query's target.
        weight: (N,) weight of each habit as a positive.
        temperature: cosines are divided by it.
    """
    logits = similarity / temperature
    others = logits.masked_fill(own, -torch.inf).logsumexp(1, keepdim=True)  # (Q, 1)
    losses = torch.nn.functional.softplus(others - logits)  # -log of own / (own + others)
    weights = own * weight
    return ((losses * weights).sum(1) / weights.sum(1)).mean()


def owner_loss(similarity: Tensor, own: Tensor, weight: Tensor, temperature: float) -> Tensor:
    """Contrastive loss of habits against queries, a scalar: which query is each habit about?

    Args:
        similarity: (Q, N) cosines of queries and habits.
        own: (Q, N) bool; every habit is about at least one query's target.
        weight: (N,) weight of each habit.
        temperature: cosines are divided by it.
    """
    logits = similarity / temperature
    losses = logits.logsumexp(0) - logits.masked_fill(~own, -torch.inf).logsumexp(0)  # (N,)
    return (losses * weight).sum() / weight.sum()


class _Ranker:
    """Retriever with sentence vectors computed beforehand, for validation."""

    def __init__(self, vectors: Mapping[str, NDArray[np.float64]]) -> None:
        self._vectors = vectors

    def scores(self, target: str, kb: KnowledgeBase, told: str = "") -> NDArray[np.float64]:
        return np.stack([self._vectors[text] for text in kb.texts]) @ self._vectors[query_text(target, told)]

    def rank(self, target: str, kb: KnowledgeBase) -> NDArray[np.int32]:
        return ranked(self.scores(target, kb), kb.rows)


class RetrieverLearner(CountedSteps):
    """Trains an adapter of the sentence encoder (see the module).

    Args:
        dataset: habits; entries of ``train`` are trained on, entries of ``val`` choose the checkpoint.
        encoder: the frozen encoder; MiniLM by default.
        options: fields of :class:`ucon.learning.run.options.RetrieverOptions`.

    Raises:
        ConfigError: a value of the wrong type or out of range.
        DataError: ``initial`` holds no adapter, a damaged one, or one of another shape.
    """

    options_of = RetrieverOptions
    """Dataclass of the options that ``**options`` may hold; read by the check of configurations."""

    def __init__(
        self,
        dataset: HabitDataset,
        encoder: MiniLM | None = None,
        **options: Any,
    ) -> None:
        self.options = given = RetrieverOptions(**options)
        kind = torch_precision(given.precision)
        if not isinstance(dataset, HabitDataset):
            raise ConfigError(f"learner.dataset={brief(dataset)}: expected a dataset; choose one by habits=...")
        self.dataset, self.seed, self.steps = dataset, given.seed, given.steps
        tokenizer, model = (encoder or MiniLM()).parts()
        adapters, self._initial = add_adapters(model, given.rank, given.seed), ""
        if given.initial is not None:
            path = adapter_file(str(given.initial))
            begin_with(adapters, read_adapter(path, MINILM_SHA256), str(path))
            self._initial = sha256_file(path)
        self.updates = Updates(adapters, lr=given.lr, decay=given.decay, average=given.average)
        self._encode = BatchEncoder(tokenizer, model, kind)

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of the habits, of the frozen encoder and, if given, of the initial adapter."""
        initial = {"initial": self._initial} if self._initial else {}
        return {"habits": self.dataset.sha256, "base": MINILM_SHA256, **initial}

    def training_kb(self, step: int) -> KnowledgeBase:
        """Knowledge base of step number ``step``, from 0, with entries of the train part only."""
        return part_kb(self.dataset, "train", self.seed * 1_000_003 + step)

    @cached_property
    def validation_kbs(self) -> list[KnowledgeBase]:
        """Knowledge bases of validation; the same for every run and seed, so that runs can be compared."""
        return [part_kb(self.dataset, "val", number) for number in range(self.options.n_kbs)]

    def step(self) -> Figures:
        """Update the adapter on one knowledge base.

        Returns:
            ``loss``, ``gradient`` and ``rate``.

        Raises:
            DivergedError: a gradient that is not finite.
        """
        kb = self.training_kb(self._done)
        targets = list(kb.entries)
        texts = [*map(query_text, targets), *kb.texts]
        vectors = self._encode(texts, self.options.mask, derived_seed(self.seed, "mask", self._done))
        queries, habits = vectors[: len(targets)], vectors[len(targets) :]
        own = torch.from_numpy(np.stack([np.isin(kb.rows, kb.rows_about(target)) for target in targets]))
        similarity = queries @ habits.T
        weights = self._weights(kb)
        loss = info_nce(similarity, own, weights, self.options.temperature)
        if self.options.owner:
            loss = loss + self.options.owner * owner_loss(similarity, own, weights, self.options.temperature)
        self.updates.begin()
        loss.backward()  # type: ignore[no-untyped-call]
        updated = self.updates.take(
            self._done, self.options.lr * schedule(self._done, self.steps, self.options.warm_up)
        )
        self._done += 1
        return {"loss": float(loss.detach()), **updated}

    def _weights(self, kb: KnowledgeBase) -> Tensor:
        """(N,) weight of each habit as a positive; all 1 where supports are unknown."""
        known = self.dataset.labelled
        answers = [
            1.0 if self.dataset.habits[row].supports or not known else self.options.other_weight for row in kb.rows
        ]
        return torch.tensor(answers)

    def validate(self) -> Figures:
        """Recall and MRR of the averaged adapter for targets of the val part, and ``score``.

        ``score`` is the recall at 20 of supporting habits, or of all habits where supports are unknown. The other
        figures are those of :func:`ucon.fitting.measures.measure_retrieval`.
        """
        parts = entry_parts(self.dataset)
        texts = list(dict.fromkeys(text for kb in self.validation_kbs for text in kb.texts))
        texts += [query_text(target) for target in sorted({t for kb in self.validation_kbs for t in kb.entries})]
        with torch.no_grad(), self.updates.averaged(), part("validating"):
            vectors = self._encode(texts).numpy().astype(np.float64)
        ranker = _Ranker(dict(zip(texts, vectors, strict=True)))
        found = measure_retrieval(self.validation_kbs, ranker, lambda entry: parts[entry.id] == "val")
        score = found["supporting_at_20"] if self.dataset.labelled else found["recall_at_20"]
        return found | {"score": score}

    def lengthen(self, steps: int) -> bool:
        """Stretch the learning-rate schedule to ``steps`` in all; always True."""
        self.steps = steps
        return True

    def product(self) -> Mapping[str, bytes]:
        """File of the averaged adapter, as :class:`ucon.language.adapted.AdaptedMiniLM` reads it."""
        return {PRODUCT: adapter_bytes(self.updates.average, MINILM_SHA256)}

    def close(self) -> None:
        """Nothing to close: it has neither workers nor environments."""

    def card(self) -> Card:
        """Text of the model card: rank, size, training entries, how to use it, and limits."""
        parts = entry_parts(self.dataset)
        count: Callable[[str], int] = lambda part: sum(p == part for p in parts.values())  # noqa: E731
        size = sum(value.numel() for value in self.updates.parameters.values())
        return Card(
            "Habit retriever: an adapter of all-MiniLM-L6-v2",
            f"A low-rank adapter (rank {self.options.rank}, {size:,} parameters, fp16) of attention and MLP matrices. "
            "The frozen encoder is all-MiniLM-L6-v2 (Apache-2.0).\n\n"
            f"Trained with InfoNCE inside knowledge bases on the {count('train')} `train` entries of "
            f"`{self.dataset.name}`, chosen on its {count('val')} `val` entries; `test` entries were not read.\n\n"
            "Use: `python eval.py retriever=tuned retriever.encoder.adapter=RUN`.\n\n"
            "It ranks sentences in English about where people keep things. It is no general sentence encoder any "
            "more: similarity of other texts was not measured.",
            self.dataset.name,
        )
