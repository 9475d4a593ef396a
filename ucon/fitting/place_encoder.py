"""Fits the encoder that reads which place a sentence speaks for: ``python -m ucon data fit-place-encoder``.

Words that never occur with a place in training ("the cistern's lid", "where the kettle boils") have no weight in
:mod:`ucon.fitting.anchor_reader`, but an encoder knows what they are similar to. So all-MiniLM-L6-v2 gets a low-rank
adapter, trained on sentences of the habit book's train entries to predict the anchor (or none) and the relation that
they speak for. The last layer is initialised with the anchors' name vectors. Written are the adapter, the last layer,
and the logits of all sentences of the book, which then need no encoder. Everything is seeded; about half an hour on one
core.
"""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from ucon.core.files import write_atomic
from ucon.core.rng import derived_seed, stream
from ucon.fitting.anchor_reader import batched_features, spoken_labels
from ucon.fitting.rate_schedule import schedule
from ucon.habits.book import book
from ucon.habits.splits import entry_parts
from ucon.habits.types import HabitDataset
from ucon.language.adapted import AdaptedMiniLM
from ucon.language.adapter import adapter_bytes, add_adapters
from ucon.language.batch_encoder import BatchEncoder
from ucon.language.encoder import MINILM_SHA256, MiniLM
from ucon.language.pairs import PairReader, default_pair_reader
from ucon.language.phrases import phrase
from ucon.language.store import write_manifest_of, write_table
from ucon.readers.reader_weights import default_weights, pack_names
from ucon.readers.tuned_evidence import ADAPTER, LAST, SCALE, TABLE, TunedEvidence

RATES = {"adapter": 2e-3, "last": 2e-3, "pair": 5e-3}
Say = Callable[[str], None]


@dataclass(frozen=True)
class PlaceRecipe:
    """How the encoder is trained. Its text is part of the cache's key of cross-fitted folds."""

    epochs: int = 4
    rank: int = 16
    batch: int = 64
    hidden: float = 0.15
    """Share of tokens that are masked in training."""
    precision: torch.dtype = torch.bfloat16


class PlaceNet(nn.Module):
    """The adapted encoder with a linear layer over anchors, "no place" and relations, plus weighted pair features.

    Args:
        anchors: A names.
        pairs: encodes names.
        recipe: has rank and precision.
    """

    def __init__(self, anchors: Sequence[str], pairs: PairReader, recipe: PlaceRecipe) -> None:
        super().__init__()
        tokenizer, model = MiniLM().parts()
        self.adapter = add_adapters(model, recipe.rank, 0)
        self.encode = BatchEncoder(tokenizer, model, recipe.precision)
        names = torch.from_numpy(pairs.encoder.encode([phrase(anchor) for anchor in anchors]))
        self.last = nn.Linear(names.shape[1], len(anchors) + 5)
        self.pair = nn.Parameter(torch.zeros(6))
        with torch.no_grad():
            self.last.weight.zero_()
            self.last.weight[: len(anchors)] = names
            self.last.bias.zero_()

    def forward(self, texts: Sequence[str], features: Tensor, hidden: float = 0.0, seed: int = 0) -> Tensor:
        """Logits (n, A + 5).

        Args:
            texts: n sentences.
            features: (n, A, 6) pair features.
            hidden: share of tokens to mask.
            seed: of the masks.
        """
        logits = self.last(SCALE * self.encode(texts, hidden, seed))
        n = features.shape[1]
        return torch.cat([logits[:, :n] + features @ self.pair, logits[:, n:]], 1)


def fit_places(
    data: HabitDataset, pairs: PairReader, anchors: Sequence[str], recipe: PlaceRecipe | None = None, say: Say = print
) -> PlaceNet:
    """Train on the train entries of a dataset that says what its habits support.

    Args:
        data: the dataset.
        pairs: encodes names and pairs.
        anchors: A names.
        recipe: how to train.
        say: prints progress.
    """
    recipe, parts = recipe or PlaceRecipe(), entry_parts(data)
    torch.manual_seed(0)
    net = PlaceNet(anchors, pairs, recipe)
    rows = np.asarray([row for row in range(len(data)) if parts[data.entry_of(row).id] == "train"])
    texts = [data.texts[row] for row in rows]
    spoken, relation = spoken_labels(data, rows, anchors)
    features = torch.from_numpy(batched_features(pairs, texts, anchors))
    groups = {"adapter": [*net.adapter.values()], "last": [*net.last.parameters()], "pair": [net.pair]}
    optimiser = torch.optim.AdamW([{"params": groups[n], "lr": RATES[n]} for n in groups], weight_decay=0.01)
    steps = recipe.epochs * (len(rows) // recipe.batch)
    for step in range(steps):
        epoch, at = divmod(step, len(rows) // recipe.batch)
        order = stream(0, "places", epoch).permutation(len(rows))
        batch = order[at * recipe.batch : (at + 1) * recipe.batch]
        seed = derived_seed(0, "mask", step)
        logits = net([texts[i] for i in batch], features[batch], recipe.hidden, seed)
        n = len(anchors) + 1
        loss = -(spoken[batch] * logits[:, :n].log_softmax(1)).sum(1).mean()
        loss = loss - 0.5 * (relation[batch] * logits[:, n:].log_softmax(1)).sum(1).mean()
        for group, rate in zip(optimiser.param_groups, RATES.values(), strict=True):
            group["lr"] = rate * schedule(step, steps, 20)
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(net.adapter.values(), 1.0)
        optimiser.step()
        if step % 50 == 0:
            say(f"places: step {step} of {steps}, loss {float(loss.detach()):.3f}")
    return net


def predicted(net: PlaceNet, texts: Sequence[str], pairs: PairReader, anchors: Sequence[str]) -> NDArray[np.float32]:
    """Logits (n, A + 5) of many texts, in batches of 1,000; their last bits depend on the batch.

    For training and measuring only.

    Args:
        net: the trained network.
        texts: n sentences.
        pairs: pair features.
        anchors: A names.
    """
    out = []
    with torch.no_grad():
        for at in range(0, len(texts), 1000):
            part = texts[at : at + 1000]
            out.append(net(part, torch.from_numpy(pairs.features(part, anchors))).numpy())
    return np.concatenate(out)


def last_layer(net: PlaceNet, anchors: Sequence[str]) -> Mapping[str, NDArray]:
    """Arrays of the layer after the encoder, by name, as they are stored."""
    return {
        "anchors": pack_names(list(anchors)),
        "dense": (SCALE * net.last.weight.detach().numpy().T).astype(np.float32),
        "bias": net.last.bias.detach().numpy(),
        "pair": net.pair.detach().numpy(),
    }


def main(words: Sequence[str]) -> None:
    """Fit, and write adapter, last layer and the table of the book; with ``--table`` write only the table.

    Args:
        words: of the command line.
    """
    parser = argparse.ArgumentParser(prog="ucon data fit-place-encoder")
    parser.add_argument("--table", action="store_true", help="write only the table, with the existing adapter")
    args = parser.parse_args(words)
    torch.set_num_threads(1)
    data, pairs = book(), default_pair_reader()
    say: Say = lambda text: print(text, file=sys.stderr, flush=True)  # noqa: E731, T201
    if not args.table:
        net = fit_places(data, pairs, data.anchors, say=say)
        write_atomic(ADAPTER, adapter_bytes(net.adapter, MINILM_SHA256))
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **last_layer(net, data.anchors))  # type: ignore[arg-type]
        write_atomic(LAST, buffer.getvalue())
        write_manifest_of(ADAPTER.parent)
    say(f"reading {len(data)} sentences (a minute or more)")
    texts = list(dict.fromkeys(data.texts))
    write_table(texts, table_logits(texts, pairs, say).astype(np.float16), TABLE)
    write_manifest_of(ADAPTER.parent)


def table_logits(texts: Sequence[str], pairs: PairReader, say: Say) -> NDArray[np.float64]:
    """Logits (n, A + 5) float64 by the stored adapter, in batches of 1,000 texts, in full precision."""
    tokenizer, model = AdaptedMiniLM(ADAPTER).parts()
    encode = BatchEncoder(tokenizer, model, torch.float32)
    evidence, out = TunedEvidence(default_weights(), pairs, table=None), []
    for at in range(0, len(texts), 1000):
        part = texts[at : at + 1000]
        with torch.no_grad():
            out.append(evidence.of_vectors(encode(part).numpy().astype(np.float16), part))
        say(f"read {at + len(part)}")
    return np.concatenate(out)
