"""Fits the anchor reader and writes ``data/reader.npz``: ``python -m ucon data fit-reader``.

Prior, evidence and gate are fitted on train entries of the habit book only; the few weights that mix them, on val
categories; test entries are not used. Everything is seeded; about five minutes on one core.
"""

from __future__ import annotations

import argparse
import io
import sys
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from ucon.core.files import write_atomic
from ucon.core.rng import stream
from ucon.habits.book import book, book_anchors
from ucon.habits.knowledge import MODES
from ucon.habits.splits import entry_parts, split_categories
from ucon.habits.types import HabitDataset
from ucon.language.pairs import PairReader, default_pair_reader
from ucon.language.phrases import phrase
from ucon.language.store import write_manifest_of
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS
from ucon.readers.anchor_reader import N_MIX, AnchorReader
from ucon.readers.evidence import grams
from ucon.readers.gate import N_GATE, gate_features
from ucon.readers.reader_weights import WEIGHTS, ReaderWeights, pack_names
from ucon.readers.sampled_homes import anchor_distribution, location_distribution, sampled_kb
from ucon.retrieval.dense import DenseRetriever, dataset_vectors
from ucon.retrieval.levels import FIXED_LEVELS, habits_at_level

Arrays = dict[str, NDArray]
MIN_COUNT, MAX_GRAMS = 5, 48
N_CLUTTER = 40
HALF = frozenset({"dense", "gate_habit", "gate_target"})
"""Arrays that are stored in float16."""


def fit_prior(data: HabitDataset, pairs: PairReader, anchors: Sequence[str], l2: float = 1e-4) -> Arrays:
    """Fit p(anchor | name) by softmax regression, and p(relation | anchor) by smoothed counts over allowed relations.

    Args:
        data: the dataset; its train entries are used.
        pairs: encodes names.
        anchors: A names.
        l2: penalty of the weights.

    Returns:
        ``prior_dense`` (D, A), ``prior_bias`` (A,) and ``relation_prior`` (A, 4).
    """
    parts = entry_parts(data)
    names = split_categories(data.categories, "train")
    x = torch.tensor(pairs.encoder.encode([phrase(name) for name in names]))
    y = torch.zeros(len(names), len(anchors))
    counts = np.zeros((len(anchors), len(RELATIONS)))
    for i, name in enumerate(names):
        learned = [e for e in data.entries_of(name) if parts[e.id] == "train"]
        for (anchor, relation), p in location_distribution(learned).items():
            y[i, anchors.index(anchor)] += p
            counts[anchors.index(anchor), RELATIONS.index(relation)] += 1  # type: ignore[arg-type]
    weight = torch.zeros(x.shape[1], len(anchors), requires_grad=True)
    bias = torch.zeros(len(anchors), requires_grad=True)
    optimiser = torch.optim.LBFGS([weight, bias], max_iter=100)

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        loss = -(y * (x @ weight + bias).log_softmax(1)).sum(1).mean() + l2 * (weight**2).sum()
        loss.backward()
        return loss

    optimiser.step(closure)
    allowed = np.asarray([[relation in book_anchors()[anchor] for relation in RELATIONS] for anchor in anchors])
    table = (counts + 1) * allowed
    return {
        "prior_dense": weight.detach().numpy(),
        "prior_bias": bias.detach().numpy(),
        "relation_prior": table / table.sum(axis=1, keepdims=True),
    }


def fit_evidence(data: HabitDataset, pairs: PairReader, anchors: Sequence[str], epochs: int = 9) -> Arrays:
    """Fit which anchor and relation a habit speaks for, from words, word pairs, sentence vector and pair features.

    Args:
        data: the dataset; its train entries are used.
        pairs: encodes sentences and pairs.
        anchors: A names.
        epochs: passes over the sentences.

    Returns:
        Arrays of the evidence reader by name.
    """
    torch.manual_seed(0)
    parts = entry_parts(data)
    rows = np.asarray([r for r in range(len(data)) if parts[data.entry_of(r).id] == "train"])
    lists = [grams(data.texts[r]) for r in rows]
    counts = Counter(gram for found in lists for gram in found)
    vocabulary = sorted(gram for gram, n in counts.items() if n >= MIN_COUNT)
    number = {gram: i + 1 for i, gram in enumerate(vocabulary)}
    ids = torch.zeros(len(rows), MAX_GRAMS, dtype=torch.long)
    for i, found in enumerate(lists):
        known = [number[gram] for gram in found if gram in number][:MAX_GRAMS]
        ids[i, : len(known)] = torch.tensor(known, dtype=torch.long)
    vectors = torch.tensor(np.asarray(dataset_vectors(data, pairs.encoder)[rows], np.float32))
    features = torch.tensor(batched_features(pairs, [data.texts[r] for r in rows], anchors))
    spoken, relation = spoken_labels(data, rows, anchors)
    n = len(anchors)
    bow = torch.nn.Embedding(len(vocabulary) + 1, n + 5, padding_idx=0)
    dense, pair = torch.nn.Linear(vectors.shape[1], n + 5), torch.nn.Linear(features.shape[2], 1, bias=False)
    for parameter in (bow.weight, dense.weight, dense.bias, pair.weight):
        torch.nn.init.zeros_(parameter)
    optimiser = torch.optim.AdamW(
        [
            {"params": bow.parameters(), "weight_decay": 1e-4},
            {"params": dense.parameters(), "weight_decay": 1e-2},
            {"params": pair.parameters(), "weight_decay": 0.0},
        ],
        lr=3e-3,
    )
    for epoch in range(epochs):
        for batch in torch.randperm(len(rows)).split(128):
            kept = ids[batch] * (torch.rand(len(batch), MAX_GRAMS) > 0.5)
            noise = (torch.rand(len(batch), vectors.shape[1]) > 0.2) / 0.8
            logits = bow(kept).sum(1) + dense(10 * vectors[batch] * noise)
            anchor_logits = torch.cat([logits[:, :n] + pair(features[batch])[..., 0], logits[:, n : n + 1]], 1)
            loss = -(spoken[batch] * anchor_logits.log_softmax(1)).sum(1).mean()
            loss = loss - 0.5 * (relation[batch] * logits[:, n + 1 :].log_softmax(1)).sum(1).mean()
            _step(optimiser, loss)
        _say(f"evidence: epoch {epoch + 1} of {epochs}, last loss {float(loss.detach()):.3f}")
    # Dropout halves the words in training. In use all words count, unscaled: that is better on the validation part.
    return {
        "vocabulary": pack_names(vocabulary),
        "bow": bow.weight.detach().numpy()[1:].astype(np.float16),
        "dense": 10 * dense.weight.detach().numpy().T,
        "bias": dense.bias.detach().numpy(),
        "pair": pair.weight.detach().numpy()[0],
        "any": _fit_any(features, spoken[:, :n]),
    }


def batched_features(pairs: PairReader, texts: Sequence[str], names: Sequence[str]) -> NDArray[np.float32]:
    """Pair features (n, C, 6) of n texts with C names, computed in batches of 1,000 texts."""
    return np.concatenate([pairs.features(texts[i : i + 1000], names) for i in range(0, len(texts), 1000)])


def spoken_labels(data: HabitDataset, rows: NDArray, anchors: Sequence[str]) -> tuple[torch.Tensor, torch.Tensor]:
    """Labels of sentences: what they support.

    Args:
        data: the dataset.
        rows: (R,) sentences.
        anchors: A names.

    Returns:
        Distribution over anchors and "no place", (R, A + 1), and over relations, (R, 4), 0 where there is no place.
    """
    spoken, relation = torch.zeros(len(rows), len(anchors) + 1), torch.zeros(len(rows), len(RELATIONS))
    for i, row in enumerate(rows):
        placements = data.supports(int(row))
        spoken[i, -1] = float(not placements)
        for p in placements:
            spoken[i, anchors.index(p.anchor)] += 1 / len(placements)
            relation[i, RELATIONS.index(p.relation)] += 1 / len(placements)
    return spoken, relation


def _fit_any(features: torch.Tensor, spoken: torch.Tensor) -> NDArray:
    """Logistic regression of "speaks for this anchor" on pair features only, over habits that speak for a place."""
    x, y = features[spoken.sum(1) > 0], (spoken[spoken.sum(1) > 0] > 0).float()
    weight = torch.zeros(x.shape[2] + 1, requires_grad=True)
    optimiser = torch.optim.LBFGS([weight], max_iter=60)

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        loss = torch.nn.functional.binary_cross_entropy_with_logits(x @ weight[:-1] + weight[-1], y)
        loss.backward()
        return loss

    optimiser.step(closure)
    return weight.detach().numpy()


def fit_gate(data: HabitDataset, pairs: PairReader, n_kbs: int = 30, epochs: int = 6, width: int = 64) -> Arrays:
    """Fit the relevance gate: is a habit about the target?

    Habits that support a placement weigh 21 times as much as others.

    Args:
        data: the dataset; its train entries are used.
        pairs: encodes sentences and pairs.
        n_kbs: number of knowledge bases.
        epochs: passes over them.
        width: of the learned likeness.

    Returns:
        Arrays ``gate_*`` by name.
    """
    rng = torch.Generator().manual_seed(0)
    start = torch.randn(384, width, generator=rng) / width**0.5
    habit, target = start.clone().requires_grad_(), start.clone().requires_grad_()
    hidden = (0.3 * torch.randn(N_GATE, 16, generator=rng)).requires_grad_()
    bias, out = torch.zeros(16, requires_grad=True), torch.zeros(16 + N_GATE + 1, requires_grad=True)
    optimiser = torch.optim.AdamW([habit, target, hidden, bias, out], lr=1e-3, weight_decay=1e-2)
    samples = list(_gate_samples(data, pairs, n_kbs))
    for epoch in range(epochs):
        for i in stream(epoch, "gate", "order").permutation(len(samples)):
            features, vectors, name, label, weight = samples[i]
            keep = [(torch.rand(width, generator=rng) > 0.2) / 0.8 for _ in range(2)]
            likeness = ((vectors @ habit) * keep[0]) @ ((name @ target) * keep[1])
            x = torch.cat([features, likeness[:, None]], 1)
            logits = torch.tanh(x @ hidden + bias) @ out[:16] + x @ out[16:-1] + out[-1]
            loss = torch.nn.functional.binary_cross_entropy_with_logits(logits, label, weight=weight)
            _step(optimiser, loss)
        _say(f"gate: epoch {epoch + 1} of {epochs}")
    parts = {"habit": habit, "target": target, "hidden": hidden, "hidden_bias": bias, "out": out}
    return {f"gate_{name}": value.detach().numpy() for name, value in parts.items()}


def _gate_samples(data: HabitDataset, pairs: PairReader, n_kbs: int) -> Any:
    for seed in range(n_kbs):
        kb = sampled_kb(data, "train", seed, MODES[seed % 2])
        place = np.asarray([bool(data.habits[row].supports) for row in kb.rows])
        for target in kb.entries:
            features, vectors = gate_features(target, kb.texts, pairs)
            label = np.isin(kb.rows, kb.rows_about(target))
            name = pairs.encoder.encode([phrase(target)])[0]
            yield tuple(torch.tensor(v, dtype=torch.float32) for v in (features, vectors, name, label, 0.05 + place))


def fit_mix(data: HabitDataset, arrays: Arrays, pairs: PairReader, n_kbs: int = 30, epochs: int = 12) -> Arrays:
    """Fit the weights that mix prior and evidence, on val categories at all habit levels.

    This also calibrates the belief.

    Args:
        data: the dataset.
        arrays: of the other parts.
        pairs: encodes sentences and pairs.
        n_kbs: number of knowledge bases.
        epochs: passes over the samples.

    Returns:
        Arrays ``mix_*`` by name.
    """
    blank = {
        "mix_hidden": np.zeros((N_MIX, 8)),
        "mix_hidden_bias": np.zeros(8),
        "mix_out": np.zeros(8 + N_MIX + 1),
    }
    reader = AnchorReader(ReaderWeights({**arrays, **blank}, ""), pairs)
    samples = [_mix_sample(reader, *case) for case in _mix_cases(data, n_kbs)]
    x = torch.tensor(np.stack([s[0] for s in samples]), dtype=torch.float32)
    y = torch.tensor(np.stack([s[1] for s in samples]), dtype=torch.float32)
    rng = torch.Generator().manual_seed(0)
    hidden = (0.2 * torch.randn(N_MIX, 8, generator=rng)).requires_grad_()
    bias, out = torch.zeros(8, requires_grad=True), torch.zeros(8 + N_MIX + 1, requires_grad=True)
    optimiser = torch.optim.AdamW([hidden, bias, out], lr=1e-2, weight_decay=1e-3)
    for epoch in range(epochs):
        for batch in torch.randperm(len(x), generator=rng).split(32):
            logits = torch.tanh(x[batch] @ hidden + bias) @ out[:8] + x[batch] @ out[8:-1] + out[-1]
            loss = -(y[batch] * logits.log_softmax(1)).sum(1).mean()
            _step(optimiser, loss)
        _say(f"mix: epoch {epoch + 1} of {epochs}, last loss {float(loss.detach()):.3f}")
    return {
        "mix_hidden": hidden.detach().numpy(),
        "mix_hidden_bias": bias.detach().numpy(),
        "mix_out": out.detach().numpy(),
    }


def _mix_cases(data: HabitDataset, n_kbs: int) -> Any:
    retriever = DenseRetriever()
    for seed in range(n_kbs):
        kb = sampled_kb(data, "val", seed, MODES[seed % 2])
        for target, entries in kb.entries.items():
            for level in FIXED_LEVELS:
                rows = habits_at_level(level, kb, target, retriever)
                masked = stream(seed, "mask", target, level)
                yield target, [data.texts[row] for row in rows], level == "gt", anchor_distribution(entries), masked


def _mix_sample(
    reader: AnchorReader, target: str, texts: list[str], trusted: bool, truth: dict[str, float], rng: Any
) -> tuple[NDArray, NDArray]:
    """Inputs (A + N_CLUTTER, 6) and true probabilities of the known anchors and of random other categories.

    In every second sample a tenth of the anchors is treated as unknown, so that unknown names can win by evidence.
    """
    reading = reader.read(target, texts, trusted=trusted)
    hidden = [name for name in reader.known if rng.random() < 0.1] if rng.random() < 0.5 else []
    others = [name for name in catalogue().names if name not in reader.number and name != target]
    names = [*hidden, *rng.choice(others, size=N_CLUTTER, replace=False)]
    unknown = reading.unknown_features([str(name) for name in names])
    x = np.concatenate([reading.known_features, unknown[len(hidden) :]])
    x[[reader.number[name] for name in hidden]] = unknown[: len(hidden)]
    return x, np.asarray([truth.get(name, 0.0) for name in reader.known] + [0.0] * N_CLUTTER)


def _step(optimiser: torch.optim.Optimizer, loss: torch.Tensor) -> None:
    optimiser.zero_grad()
    loss.backward()
    optimiser.step()


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)  # noqa: T201


def stored(name: str, value: NDArray) -> NDArray:
    """An array as it is stored: large matrices in float16, other floats in float32, names unchanged."""
    if name in HALF:
        return value.astype(np.float16)
    return value.astype(np.float32) if value.dtype == np.float64 else value


def main(words: Sequence[str]) -> None:
    """Fit all parts and write them.

    Args:
        words: of the command line.
    """
    argparse.ArgumentParser(prog="ucon data fit-reader").parse_args(words)
    torch.set_num_threads(1)
    data, pairs = book(), default_pair_reader()
    anchors = list(data.anchors)
    arrays: Arrays = {"anchors": pack_names(anchors), **fit_prior(data, pairs, anchors)}
    arrays |= fit_evidence(data, pairs, anchors)
    arrays |= fit_gate(data, pairs)
    arrays = {name: value.astype(np.float16) if name in HALF else value for name, value in arrays.items()}
    arrays |= fit_mix(data, arrays, pairs)
    packed = {name: stored(name, value) for name, value in arrays.items()}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **packed)  # type: ignore[arg-type]
    write_atomic(WEIGHTS, buffer.getvalue())
    write_manifest_of(WEIGHTS.parent)
