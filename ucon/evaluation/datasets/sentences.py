"""Figures of a dataset's sentences: length, variety, repetition, and what they name."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.rng import stream
from ucon.habits import HabitDataset
from ucon.habits.splits import category_split, entry_parts

#: Number of habits for vocabulary and distinct-2, which depend on the amount of text.
_DISTINCT_SAMPLE = 5_000
_NEAR_COSINE = 0.95
_WORD = re.compile(r"[a-z']+")


def text_statistics(dataset: HabitDataset) -> dict[str, Any]:
    """Counts, words per habit, vocabulary, distinct-2, repetition, and what the sentences name.

    ``unique_masked`` is the share of unique sentences with category names masked; ``names_target`` and
    ``names_true_anchor`` are the shares of habits that name their target, or an anchor of their entry, in full;
    ``length_tells_support`` is the AUROC of the number of words for telling supporting habits from others.
    """
    texts = dataset.texts
    words = [_WORD.findall(text.lower()) for text in texts]
    order = stream(0, "statistics", "distinct").permutation(len(texts))[:_DISTINCT_SAMPLE]
    pairs = [pair for i in order for pair in zip(words[i], words[i][1:], strict=False)]
    lengths = [len(sentence) for sentence in words]
    target, anchor = _named(dataset)
    return {
        "habits": len(texts),
        "categories": len(dataset.categories),
        # Entries bound to scenes have an instruction instead of people.
        "households": None if dataset.scenes else len({e.household for e in dataset.entries}),
        "entries": len(dataset.entries),
        "entries_by_part": dict(sorted(Counter(entry_parts(dataset).values()).items())),
        "categories_by_part": dict(sorted(Counter(map(category_split, dataset.categories)).items())),
        "words_per_habit": round(float(np.mean(lengths)), 2),
        "words_per_habit_p5": int(np.percentile(lengths, 5)),
        "words_per_habit_p95": int(np.percentile(lengths, 95)),
        "vocabulary": len({word for sentence in words for word in sentence}),
        "vocabulary_on_5000": len({word for i in order for word in words[i]}),
        "distinct_2": round(len(set(pairs)) / max(1, len(pairs)), 4),
        "unique_masked": round(len(set(_masked(dataset))) / len(texts), 4),
        "duplicates": len(texts) - len(set(texts)),
        "length_tells_support": _length_auroc(dataset) if dataset.labelled else None,
        "names_target": target,
        "names_true_anchor": anchor,
    }


def near_duplicates(vectors: NDArray[np.float16], block: int = 1024) -> float:
    """Share of rows whose cosine with an earlier row exceeds 0.95.

    Args:
        vectors: (n, D) unit vectors.
        block: rows that are compared at once.
    """
    full = vectors.astype(np.float32)
    found = np.zeros(len(full), bool)
    for start in range(0, len(full), block):
        end = min(start + block, len(full))
        cosines = full[start:end] @ full[:end].T
        cosines[np.arange(end)[None] >= np.arange(start, end)[:, None]] = -1.0
        found[start:end] = cosines.max(1) > _NEAR_COSINE
    return round(float(found.mean()), 5)


def word_counts(dataset: HabitDataset) -> NDArray[np.int64]:
    """Words of every habit by row, (n_rows,) int64."""
    return np.asarray([len(_WORD.findall(text.lower())) for text in dataset.texts])


def names(text: str, category: str) -> bool:
    """Whether a sentence contains a category's full name, singular or plural, with or without underscores."""
    return _pattern(category).search(text.lower().replace("_", " ")) is not None


def _length_auroc(dataset: HabitDataset) -> float | None:
    """Probability that a supporting habit has more words than another one; ties count half.

    None if one kind is missing.
    """
    words, supporting = word_counts(dataset), np.asarray([bool(habit.supports) for habit in dataset.habits])
    n = int(words.max()) + 1
    longer, other = (np.bincount(words[rows], minlength=n) for rows in (supporting, ~supporting))
    if not longer.any() or not other.any():
        return None
    won = longer @ (other.cumsum() - other / 2)
    return round(float(won / (longer.sum() * other.sum())), 4)


@lru_cache(maxsize=4096)
def _pattern(category: str) -> re.Pattern[str]:
    return re.compile(rf"\b{re.escape(category.replace('_', ' '))}(?:s|es)?\b")


def _named(dataset: HabitDataset) -> tuple[float, float]:
    """Shares of habits that name their target, and an anchor of their entry."""
    target = anchor = 0
    for entry in dataset.entries:
        anchors = {place.anchor for place in entry.placements}
        target += sum(names(habit.text, entry.category) for habit in entry.habits)
        anchor += sum(any(names(habit.text, name) for name in anchors) for habit in entry.habits)
    return round(target / len(dataset), 4), round(anchor / len(dataset), 4)


def _masked(dataset: HabitDataset) -> Sequence[str]:
    """Sentences with every category name (targets and anchors) replaced."""
    known = sorted({n.replace("_", " ") for n in (*dataset.categories, *dataset.anchors)}, key=len, reverse=True)
    pattern = re.compile(r"\b(" + "|".join(map(re.escape, known)) + r")s?\b")
    return [pattern.sub("#", text.lower()) for text in dataset.texts]
