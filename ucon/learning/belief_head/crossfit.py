"""Cross-fitting for the belief head: the fitted readers read only text that they were not fitted on.

A reader is overconfident on sentences that it was fitted on, and a head trained on its outputs would trust it too much.
So the train categories are dealt into folds, and each fold is read by parts fitted on the other folds:
``folds(book(), ...)``. Fitting takes minutes per fold; results are kept in the user's cache, under a hash of everything
that they depend on.
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

#: Part of the cache's key; raise it when the fitting changes, so that nothing fitted before is used.
EDITION = 1
#: Fewer epochs than for the shipped reader: half of the text is overfitted sooner than all of it.
RECIPE = PlaceRecipe(epochs=2)


@dataclass(frozen=True, eq=False)
class CrossfittedFold:
    """Train entries of some categories, and the outputs of parts fitted on all other train categories."""

    dataset: HabitDataset
    weights: ReaderWeights
    logits: NDArray[np.float32]
    """(n, A + 5), one row per sentence of :func:`train_texts`.

    Columns as in :class:`ucon.readers.tuned_evidence.TunedEvidence`.
    """


class ReadEvidence(EvidenceReader):
    """Evidence reader that looks up logits computed beforehand.

    Args:
        weights: fitted arrays of the other parts.
        pairs: encodes sentences and pairs.
        logits: (A + 5,) float64 by sentence.
    """

    def __init__(self, weights: ReaderWeights, pairs: PairReader, logits: Mapping[str, Array]) -> None:
        super().__init__(weights, pairs)
        self._logits_of = logits

    def _logits(self, texts: Sequence[str]) -> Array:
        return np.stack([self._logits_of[text] for text in texts])

    @classmethod
    def of(cls, fold: CrossfittedFold, pairs: PairReader) -> ReadEvidence:
        """Reader of a fold's own sentences; logits rounded as in use.

        Args:
            fold: has the sentences and their logits.
            pairs: encodes sentences and pairs.
        """
        rounded = np.round(fold.logits.astype(np.float64), DECIMALS)
        return cls(fold.weights, pairs, dict(zip(train_texts(fold.dataset), rounded, strict=True)))


def train_texts(data: HabitDataset) -> list[str]:
    """Sentences of the dataset's train entries, in the order of entries and habits."""
    parts = entry_parts(data)
    return [habit.text for entry in data.entries if parts[entry.id] == "train" for habit in entry.habits]


def fold_categories(data: HabitDataset, count: int) -> list[tuple[str, ...]]:
    """Deal the train categories into ``count`` folds, at random but always the same way for a dataset's name.

    Args:
        data: the dataset.
        count: number of folds.

    Returns:
        Sorted category names of each fold.

    Raises:
        ConfigError: fewer than two folds, or more than train categories.
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
    """The first ``used`` cross-fitted folds; fitted now, or read from the user's cache.

    Args:
        data: the dataset; only its train entries are used.
        pairs: encodes sentences and pairs.
        count: number of folds.
        used: how many of them to return; None: all.
        recipe: how the place encoder is fitted.
        say: prints progress.

    Raises:
        ConfigError: a wrong ``count`` or ``used``, or an anchor that the shipped weights do not know (the folds share
            some of their arrays).
    """
    known = default_weights().anchors
    if odd := next((name for name in data.anchors if name not in known), None):
        raise ConfigError(
            f"habits {data.name}: the anchor {odd} is not among the {len(known)} that the shipped reader knows, "
            "which the head is based on; rename it or leave its entries out"
        )
    groups = fold_categories(data, count)
    if used is not None and not 1 <= used <= count:
        raise ConfigError(f"{used} of {count} folds: expected 1 to {count}")
    return [_fold(data, set(group), pairs, recipe or RECIPE, say) for group in groups[:used]]


def _fold(data: HabitDataset, names: set[str], pairs: PairReader, recipe: PlaceRecipe, say: Say) -> CrossfittedFold:
    """One fold: fit on all other categories, unless the cache has the result."""
    own, rest = _part_of(data, names), _part_of(data, set(data.categories) - names)
    anchors = list(default_weights().anchors)  # the shipped weights' anchors, since some of their arrays are shared
    made_of = [EDITION, own.sha256, rest.sha256, anchors, pairs.encoder.name, str(asdict(recipe))]
    path = user_cache() / "crossfit" / sha256_bytes(canonical_json(made_of).encode())[:24] / "fold.npz"
    if not (path.parent / MANIFEST).is_file():  # the manifest is written last
        say(f"fitting a reader for {len(own.categories)} categories on {len(rest.categories)} others (minutes, once)")
        _keep(path, _fitted(own, rest, anchors, pairs, recipe, say))
    arrays, sha256 = load_arrays(path)
    shared = load_arrays(WEIGHTS)[0]
    return CrossfittedFold(own, ReaderWeights({**shared, **arrays}, sha256), arrays["logits"])


def _fitted(
    own: HabitDataset, rest: HabitDataset, anchors: list[str], pairs: PairReader, recipe: PlaceRecipe, say: Say
) -> fit.Arrays:
    """Fit prior, gate and place encoder on ``rest``.

    The prior of relations stays the shipped one, which is counted over all train categories.

    Returns:
        Arrays by name, with ``logits`` of the sentences of ``own``.
    """
    arrays = fit.fit_prior(rest, pairs, anchors)
    del arrays["relation_prior"]
    arrays |= fit.fit_gate(rest, pairs)
    arrays = {name: fit.stored(name, value) for name, value in arrays.items()}
    net = fit_places(rest, pairs, anchors, recipe, say)
    return {**arrays, "logits": predicted(net, train_texts(own), pairs, anchors)}


def _keep(path: Path, arrays: fit.Arrays) -> None:
    """Write the arrays to the cache, then the manifest."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]
    write_atomic(path, buffer.getvalue())
    write_manifest(path.parent, [path.name])


def _part_of(data: HabitDataset, names: set[str]) -> HabitDataset:
    """The dataset's entries of some categories."""
    return HabitDataset(data.name, tuple(e for e in data.entries if e.category in names), data.labelled)
