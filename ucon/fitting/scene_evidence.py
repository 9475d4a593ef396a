"""Fits an encoder that reads which places a dataset's sentences speak for; it learns only from where things are kept.

Such a dataset does not say which sentence names a place. So an entry's sentences are read together (multiple-instance
learning): the probability that a thing is at an anchor grows with the sum of evidence of its sentences, plus the prior,
and the fit maximises the likelihood of the true places. In addition every sentence has to be assigned to its owner
among some things of the scene. For both tasks all-MiniLM-L6-v2 gets one low-rank adapter. Names are compared with
sentences by their vectors, so unknown names can be asked about. Everything is seeded; minutes on one core. The result
is kept in the user's cache under a hash of everything that it depends on.
"""

from __future__ import annotations

import io
import sys
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from ucon.core.errors import DataError, DivergedError
from ucon.core.files import (
    MANIFEST,
    canonical_json,
    read_verified,
    sha256_bytes,
    user_cache,
    write_atomic,
    write_manifest,
)
from ucon.core.rng import derived_seed, stream
from ucon.core.untrusted.unpack import UnpackError, read_array
from ucon.fitting.rate_schedule import schedule
from ucon.fitting.scene_prior import fit_scene_prior
from ucon.habits.splits import scene_category_folds
from ucon.habits.types import Entry, HabitDataset
from ucon.language.adapted import AdaptedMiniLM
from ucon.language.adapter import adapter_bytes, add_adapters
from ucon.language.batch_encoder import BatchEncoder
from ucon.language.encoder import MINILM_SHA256, MiniLM
from ucon.language.pairs import N_FEATURES, PairReader
from ucon.language.phrases import phrase
from ucon.readers.anchor_prior import UNKNOWN_PRIOR, AnchorPrior
from ucon.readers.reader_weights import pack_names
from ucon.readers.sampled_homes import anchor_distribution
from ucon.readers.scene_evidence import ADAPTER, LAST, SCALE

#: Part of the cache's key; raise it when the fitting changes, so that nothing fitted before is used.
EDITION: Final = 2
#: Number of folds of the prior that is used in training.
_PRIOR_FOLDS: Final = 4
Say = Callable[[str], None]


def print_progress(text: str) -> None:
    """Print progress to stderr."""
    print(text, file=sys.stderr, flush=True)  # noqa: T201


@dataclass(frozen=True)
class SceneRecipe:
    """How the encoder is trained. Its text is part of the cache's key."""

    epochs: int = 3
    rank: int = 16
    entries: int = 8
    """Entries of one step: of one scene, each of another category."""
    hidden: float = 0.15
    """Share of tokens that are masked in training."""
    lr: float = 1e-3
    few_lr: float = 5e-3
    """Learning rate of biases and single weights."""
    mixed: float = 0.5
    """Weight of the loss where places are found among the sentences of all entries of a step.

    1 for those of each entry.
    """
    owner: float = 0.3
    """Weight of the loss of assigning sentences to their owners."""
    decay: float = 0.01
    precision: torch.dtype = torch.bfloat16


class SceneEvidenceNet(nn.Module):
    """The network (see the module).

    Args:
        anchors: A categories that are anchors in training.
        owners: categories that sentences are about.
        pairs: encodes names.
        recipe: has rank and precision.
    """

    def __init__(self, anchors: Sequence[str], owners: Sequence[str], pairs: PairReader, recipe: SceneRecipe) -> None:
        super().__init__()
        tokenizer, model = MiniLM().parts()
        self.adapter = add_adapters(model, recipe.rank, 0)
        self.encode = BatchEncoder(tokenizer, model, recipe.precision)
        self.anchors, self.owners = tuple(anchors), tuple(owners)
        self.name, self.owner = (_vectors(names, pairs) for names in (anchors, owners))
        d = self.name.shape[1]
        self.turn, self.ask = nn.Parameter(torch.eye(d)), nn.Parameter(SCALE * torch.eye(d))
        self.added, self.bias = nn.Parameter(torch.zeros(len(anchors), d)), nn.Parameter(torch.zeros(len(anchors)))
        self.silence, self.silence_bias = nn.Parameter(torch.zeros(d)), nn.Parameter(torch.tensor(0.6))
        self.pair, self.owner_pair = nn.Parameter(torch.ones(N_FEATURES)), nn.Parameter(torch.zeros(N_FEATURES))
        self.usual = nn.Parameter(torch.tensor([0.0, 1.0]))
        """Log weight of the prior relative to the evidence of an entry's own sentences, and of all sentences."""

    def spoken(self, vectors: Tensor, columns: Tensor, features: Tensor) -> Tensor:
        """Probability (H, C) that sentences speak for anchors.

        Args:
            vectors: (H, D) of the sentences.
            columns: (C,) indices of anchors.
            features: (H, C, 6) pair features.
        """
        rows = self.name[columns] @ self.turn + self.added[columns]
        silence = vectors @ self.silence + self.silence_bias
        score = SCALE * (vectors @ rows.T - silence[:, None]) + self.bias[columns] + features @ self.pair
        return score.sigmoid()

    def about(self, vectors: Tensor, owners: Tensor, features: Tensor) -> Tensor:
        """Scores (H, T) of which owner each sentence is about.

        Args:
            vectors: (H, D) of the sentences.
            owners: (T,) indices of owners.
            features: (H, T, 6) pair features.
        """
        return vectors @ (self.owner[owners] @ self.ask).T + features @ self.owner_pair

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """Arrays that :class:`~ucon.readers.scene_evidence.SceneEvidence` reads, float16; without the adapter."""
        names = {"anchors": pack_names(self.anchors), "owners": pack_names(self.owners)}
        learned = ("added", "bias", "turn", "silence", "silence_bias", "pair", "ask", "owner_pair")
        return {**names, **{n: getattr(self, n).detach().numpy().astype(np.float16) for n in learned}}


def _vectors(names: Sequence[str], pairs: PairReader) -> Tensor:
    return torch.from_numpy(pairs.encoder.encode([phrase(name) for name in names]))


@dataclass(frozen=True, eq=False)
class _Asked:
    """One training step: some entries of a scene, with all candidate places of the scene."""

    texts: list[str]
    """H sentences."""
    whose: Tensor
    """(H,) index of each sentence's entry."""
    names: list[str]
    """C candidate places."""
    columns: Tensor
    """(C,) their indices among the network's anchors."""
    owners: Tensor
    """(E,) indices of the entries' categories."""
    truth: Tensor
    """(E, C) true distribution."""
    usual: Tensor
    """(E, C) prior; 0 for the thing itself."""


def fit_scene_evidence(
    data: HabitDataset,
    entries: Sequence[Entry],
    pairs: PairReader,
    recipe: SceneRecipe | None = None,
    say: Say = print_progress,
) -> SceneEvidenceNet:
    """Train on entries of ``data``, which are bound to scenes with known content (``data.standing``).

    Args:
        data: the dataset.
        entries: to train on.
        pairs: encodes names and pairs.
        recipe: how to train.
        say: prints progress.

    Raises:
        DivergedError: the loss is not finite.
    """
    recipe = recipe or SceneRecipe()
    torch.manual_seed(0)
    standing = _standing(data, entries)
    net = SceneEvidenceNet(sorted(set().union(*standing.values())), data.categories, pairs, recipe)
    usual = {e.id: prior for asked, prior in _priors(entries, pairs) for e in asked}
    few = [net.pair, net.owner_pair, net.bias, net.usual, net.silence_bias]
    many = [*net.adapter.values(), net.turn, net.ask, net.added, net.silence]
    optimiser = torch.optim.AdamW([{"params": many}, {"params": few}], weight_decay=recipe.decay)
    batches = [batch for epoch in range(recipe.epochs) for batch in _batches(entries, epoch, recipe.entries)]
    for step, batch in enumerate(batches):
        asked = _asked(net, batch, standing[batch[0].scene or ""], usual, pairs)
        loss = _loss(net, asked, pairs, recipe, derived_seed(0, "mask", step))
        if not bool(torch.isfinite(loss)):
            raise DivergedError(f"places: step {step}: the loss is not finite; nothing was saved")
        share = schedule(step, len(batches), 20)
        for group, rate in zip(optimiser.param_groups, (recipe.lr, recipe.few_lr), strict=True):
            group["lr"] = rate * share
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_([*many, *few], 1.0)
        optimiser.step()
        if step % 50 == 0:
            say(f"places: step {step} of {len(batches)}, loss {float(loss.detach()):.3f}")
    return net


def _standing(data: HabitDataset, entries: Sequence[Entry]) -> dict[str, list[str]]:
    """Candidate places by scene: what stands there, and the anchors of the entries."""
    found: dict[str, set[str]] = defaultdict(set)
    for entry in entries:
        found[entry.scene or ""] |= {place.anchor for place in entry.placements}
    return {scene: sorted(names | set(data.standing.get(scene, ()))) for scene, names in found.items()}


def _priors(entries: Sequence[Entry], pairs: PairReader) -> list[tuple[list[Entry], AnchorPrior]]:
    """Folds of entries, each with the prior of all other entries."""
    out = []
    for fold in scene_category_folds(entries, _PRIOR_FOLDS, "places"):
        asked = [e for e in entries if (e.scene or "", e.category) in fold]
        out.append((asked, fit_scene_prior([e for e in entries if (e.scene or "", e.category) not in fold], pairs)))
    return out


def _batches(entries: Sequence[Entry], epoch: int, size: int) -> list[list[Entry]]:
    """All entries in random order; those of a batch share the scene and differ in category."""
    rng = stream(0, "own places", epoch)
    by_scene: dict[str, list[Entry]] = defaultdict(list)
    for i in rng.permutation(len(entries)):
        by_scene[entries[i].scene or ""].append(entries[i])
    batches: list[list[Entry]] = []
    for scene in sorted(by_scene):
        left = by_scene[scene]
        while left:
            batch: dict[str, Entry] = {}
            for entry in left:
                if len(batch) < size:
                    batch.setdefault(entry.category, entry)
            taken = {e.id for e in batch.values()}
            left = [e for e in left if e.id not in taken]
            batches.append(list(batch.values()))
    return [batches[i] for i in rng.permutation(len(batches))]


def _asked(
    net: SceneEvidenceNet, batch: Sequence[Entry], names: list[str], usual: dict[str, AnchorPrior], pairs: PairReader
) -> _Asked:
    number, owner = ({name: i for i, name in enumerate(names)} for names in (net.anchors, net.owners))
    truth, common = np.zeros((len(batch), len(names)), np.float32), np.zeros((len(batch), len(names)))
    vectors = pairs.encoder.encode([phrase(e.category) for e in batch]).astype(np.float64)
    for row, entry in enumerate(batch):
        found = anchor_distribution([entry])
        truth[row] = [found.get(name, 0.0) for name in names]
        common[row] = usual[entry.id].log_p(vectors[row : row + 1], names, UNKNOWN_PRIOR)[0]
        common[row, [name == entry.category for name in names]] = -np.inf
    return _Asked(
        texts=[habit.text for entry in batch for habit in entry.habits],
        whose=torch.tensor([row for row, entry in enumerate(batch) for _ in entry.habits]),
        names=names,
        columns=torch.tensor([number[name] for name in names]),
        owners=torch.tensor([owner[entry.category] for entry in batch]),
        truth=torch.from_numpy(truth),
        usual=torch.from_numpy(common).softmax(1).float(),
    )


def _loss(net: SceneEvidenceNet, asked: _Asked, pairs: PairReader, recipe: SceneRecipe, seed: int) -> Tensor:
    vectors = net.encode(asked.texts, recipe.hidden, seed)
    features = torch.from_numpy(pairs.features(asked.texts, asked.names))
    spoken = net.spoken(vectors, asked.columns, features)  # (H, C)
    own = functional.one_hot(asked.whose, len(asked.owners)).T.float()  # (E, H)
    things = torch.from_numpy(pairs.features(asked.texts, [net.owners[k] for k in asked.owners]))
    about = net.about(vectors, asked.owners, things).log_softmax(1).T  # (E, H) log p
    alone = _places_loss(own @ spoken, asked, net.usual[0])
    mixed = _places_loss(about.exp() @ spoken, asked, net.usual[1])
    return alone + recipe.mixed * mixed - recipe.owner * (own * about).sum() / own.sum()


def _places_loss(said: Tensor, asked: _Asked, usual: Tensor) -> Tensor:
    """Cross-entropy of the distribution from evidence (E, C) and prior to the true places."""
    mass = said * (asked.usual > 0) + usual.exp() * asked.usual
    p = mass / mass.sum(1, keepdim=True)
    return -(asked.truth * p.clamp_min(1e-9).log()).sum(1).mean()


class PrecomputedVectors:
    """Sentence vectors computed beforehand.

    Args:
        texts: n sentences.
        vectors: (n, D) float16.
    """

    def __init__(self, texts: Sequence[str], vectors: NDArray[np.float16]) -> None:
        self._row, self._vectors = {text: i for i, text in enumerate(texts)}, vectors

    def encode_half(self, texts: Sequence[str]) -> NDArray[np.float16]:
        """Unit vectors (n, D) float16 of texts, which have to be among those given."""
        return self._vectors[[self._row[text] for text in texts]]


def cached_scene_evidence(
    data: HabitDataset,
    entries: Sequence[Entry],
    pairs: PairReader,
    recipe: SceneRecipe | None = None,
    say: Say = print_progress,
) -> Path:
    """Folder with adapter and last layer fitted on ``entries``.

    Fitted on the first call, then found in the user's cache.

    Args:
        data: the dataset.
        entries: to train on.
        pairs: encodes names and pairs.
        recipe: how to train.
        say: prints progress.
    """
    recipe = recipe or SceneRecipe()
    ids, standing = sorted(e.id for e in entries), {scene: list(names) for scene, names in data.standing.items()}
    made_of = [EDITION, data.sha256, standing, ids, pairs.encoder.name, str(asdict(recipe))]
    folder = user_cache() / "own_places" / sha256_bytes(canonical_json(made_of).encode())[:24]
    if not (folder / MANIFEST).is_file():
        say(f"learning which places {sum(len(e.habits) for e in entries)} sentences support (minutes, once)")
        net = fit_scene_evidence(data, entries, pairs, recipe, say)
        write_atomic(folder / ADAPTER, adapter_bytes(net.adapter, MINILM_SHA256))
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **net.arrays())  # type: ignore[arg-type]
        write_atomic(folder / LAST, buffer.getvalue())
        write_manifest(folder, [ADAPTER, LAST])
    return folder


def precomputed_vectors(folder: Path, texts: Sequence[str]) -> PrecomputedVectors:
    """Vectors of many sentences by the adapter in ``folder``, cached below it.

    Args:
        folder: with the adapter.
        texts: sentences.

    Raises:
        DataError: the cached file is damaged.
    """
    distinct = list(dict.fromkeys(texts))
    path = folder / f"texts-{sha256_bytes(canonical_json(distinct).encode())[:16]}" / "vectors.npy"
    if not (path.parent / MANIFEST).is_file():
        encode = BatchEncoder(*AdaptedMiniLM(folder / ADAPTER).parts(), SceneRecipe.precision)
        with torch.no_grad():
            vectors = [encode(distinct[at : at + 1000]).numpy() for at in range(0, len(distinct), 1000)]
        buffer = io.BytesIO()
        np.save(buffer, np.concatenate(vectors).astype(np.float16), allow_pickle=False)
        write_atomic(path, buffer.getvalue())
        write_manifest(path.parent, [path.name])
    try:
        return PrecomputedVectors(distinct, read_array(read_verified(path)))
    except UnpackError as error:
        raise DataError(f"{path}: {error}; remove its folder and it is made again") from None
