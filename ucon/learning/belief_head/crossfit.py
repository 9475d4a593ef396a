"""The fitted parts that the belief head stands on, as they read text they were not fitted on.

What reads habits well on the sentences it learned from says too much there; a head trained on top would believe it.
So the train categories are dealt into folds, and each fold is read by parts that were fitted on the other folds:
``folds(book(), ...)``. Fitting takes minutes a fold, so what comes of it is kept in the user's cache under the hash of
what it depends on.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.files import MANIFEST, canonical_json, sha256_bytes, user_cache, write_atomic, write_manifest
from ucon.core.rng import stream
from ucon.fitting import anchor_reader as fit
from ucon.fitting.place_encoder import PlaceRecipe, Say, fit_places, predicted
from ucon.habits.splits import entry_parts, split_categories
from ucon.habits.types import HabitDataset
from ucon.language.pairs import PairReader
from ucon.readers.evidence import DECIMALS, EvidenceReader
from ucon.readers.reader_weights import WEIGHTS, Array, ReaderWeights, default_weights, load_arrays

#: Raised whenever the fitting changes: what was kept before is fitted anew.
EDITION = 1
#: Half of the text is learned by heart sooner than all of it.
RECIPE = PlaceRecipe(epochs=2)


@dataclass(frozen=True, eq=False)
class CrossfittedFold:
    """Train entries of some categories, and what parts fitted on the train entries of the others make of them."""

    dataset: HabitDataset
    weights: ReaderWeights
    logits: NDArray[np.float32]
    """(n, A + 5) of :func:`train_texts`, as :class:`ucon.readers.tuned_evidence.TunedEvidence` has them."""


class ReadEvidence(EvidenceReader):
    """What was read beforehand: logits by text."""

    def __init__(self, weights: ReaderWeights, pairs: PairReader, logits: Mapping[str, Array]) -> None:
        super().__init__(weights, pairs)
        self._known = logits

    def _logits(self, texts: Sequence[str]) -> Array:
        return np.stack([self._known[text] for text in texts])

    @classmethod
    def of(cls, fold: CrossfittedFold, pairs: PairReader) -> ReadEvidence:
        """Of a fold's sentences."""
        rounded = np.round(fold.logits.astype(np.float64), DECIMALS)
        return cls(fold.weights, pairs, dict(zip(train_texts(fold.dataset), rounded, strict=True)))


def train_texts(data: HabitDataset) -> list[str]:
    """Sentences of the train entries, in order."""
    parts = entry_parts(data)
    return [habit.text for entry in data.entries if parts[entry.id] == "train" for habit in entry.habits]


def fold_categories(data: HabitDataset, count: int) -> list[tuple[str, ...]]:
    """The train categories, dealt at random but always alike.

    Raises:
        ConfigError: fewer than two folds, or more than categories.
    """
    names = split_categories(data.categories, "train")
    if not 2 <= count <= len(names):
        raise ConfigError(f"{count} folds of {len(names)} train categories: expected 2 to {len(names)}")
    order = stream(0, "crossfit", data.name).permutation(len(names))
    return [tuple(sorted(names[i] for i in order[k::count])) for k in range(count)]


def folds(
    data: HabitDataset,
    pairs: PairReader,
    count: int = 2,
    used: int | None = None,
    recipe: PlaceRecipe | None = None,
    say: Say = print,
) -> list[CrossfittedFold]:
    """The first ``used`` folds, or all; what was fitted before is read from the cache.

    Raises:
        ConfigError: fewer than two folds, or more than categories; more used than there are; an anchor that the shipped
            weights, which the folds share in part, do not know.
    """
    known = default_weights().anchors
    if odd := next((name for name in data.anchors if name not in known), None):
        raise ConfigError(
            f"habits {data.name}: the anchor {odd} is none of the {len(known)} that the shipped reader knows, on "
            "which the head stands; rename it or leave its entries out"
        )
    groups = fold_categories(data, count)
    if used is not None and not 1 <= used <= count:
        raise ConfigError(f"{used} of {count} folds: expected 1 to {count}")
    return [_fold(data, set(group), pairs, recipe or RECIPE, say) for group in groups[:used]]


def _fold(data: HabitDataset, names: set[str], pairs: PairReader, recipe: PlaceRecipe, say: Say) -> CrossfittedFold:
    own, rest = _part_of(data, names), _part_of(data, set(data.categories) - names)
    anchors = list(default_weights().anchors)  # those of the arrays that the shipped weights lend
    made_of = [EDITION, own.sha256, rest.sha256, anchors, pairs.encoder.name, str(asdict(recipe))]
    path = user_cache() / "crossfit" / sha256_bytes(canonical_json(made_of).encode())[:24] / "fold.npz"
    if not (path.parent / MANIFEST).is_file():  # written last
        say(f"fitting what reads {len(own.categories)} categories on {len(rest.categories)} others (minutes, once)")
        _keep(path, _fitted(own, rest, anchors, pairs, recipe, say))
    arrays, sha256 = load_arrays(path)
    shared = load_arrays(WEIGHTS)[0]
    return CrossfittedFold(own, ReaderWeights({**shared, **arrays}, sha256), arrays["logits"])


def _fitted(
    own: HabitDataset, rest: HabitDataset, anchors: list[str], pairs: PairReader, recipe: PlaceRecipe, say: Say
) -> fit.Arrays:
    """Common sense, gate and places. What is counted over relations, not categories, is the shipped reader's."""
    arrays = fit.fit_prior(rest, pairs, anchors)
    del arrays["relation_prior"]
    arrays |= fit.fit_gate(rest, pairs)
    arrays = {name: fit.stored(name, value) for name, value in arrays.items()}
    net = fit_places(rest, pairs, anchors, recipe, say)
    return {**arrays, "logits": predicted(net, train_texts(own), pairs, anchors)}


def _keep(path: Path, arrays: fit.Arrays) -> None:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]
    write_atomic(path, buffer.getvalue())
    write_manifest(path.parent, [path.name])


def _part_of(data: HabitDataset, names: set[str]) -> HabitDataset:
    return HabitDataset(data.name, tuple(e for e in data.entries if e.category in names), data.labelled)
