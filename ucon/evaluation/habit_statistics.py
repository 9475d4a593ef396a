"""What a habit dataset is like: variety of its text, repetition, and how well retrieval finds a target's habits."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.rng import stream
from ucon.habits import HabitDataset, KnowledgeBase, household
from ucon.retrieval import Retriever, mrr, recall_at
from ucon.scenes import SCENES

#: Vocabulary and distinct-2 grow with the text, so distinct-2 is measured on a fixed number of habits.
_DISTINCT_SAMPLE = 5_000
_NEAR_COSINE = 0.95
_KNOWLEDGE_BASES = 60
_CATEGORIES = 20
_WORD = re.compile(r"[a-z']+")


def text_statistics(dataset: HabitDataset) -> dict[str, Any]:
    """Counts, vocabulary, distinct-2, share of unique sentences once category names are masked, duplicates."""
    texts = dataset.texts
    words = [_WORD.findall(text.lower()) for text in texts]
    order = stream(0, "statistics", "distinct").permutation(len(texts))[:_DISTINCT_SAMPLE]
    pairs = [pair for i in order for pair in zip(words[i], words[i][1:], strict=False)]
    placements = [(e, i) for e in dataset.entries for i in range(len(e.placements))]
    unsupported = sum(all(i not in h.supports for h in e.habits) for e, i in placements)
    return {
        "habits": len(texts),
        "categories": len(dataset.categories),
        "households": len({e.household for e in dataset.entries}),
        "entries": len(dataset.entries),
        "words_per_habit": round(sum(map(len, words)) / len(words), 2),
        "vocabulary": len({word for sentence in words for word in sentence}),
        "distinct_2": round(len(set(pairs)) / max(1, len(pairs)), 4),
        "unique_masked": round(len(set(_masked(dataset))) / len(texts), 4),
        "duplicates": len(texts) - len(set(texts)),
        "unsupported_placements": round(unsupported / len(placements), 4) if dataset.labelled else None,
    }


def near_duplicates(vectors: NDArray[np.float16], block: int = 1024) -> float:
    """Share of rows (n, dim) whose cosine with an earlier row exceeds 0.95."""
    full = vectors.astype(np.float32)
    found = np.zeros(len(full), bool)
    for start in range(0, len(full), block):
        end = min(start + block, len(full))
        cosines = full[start:end] @ full[:end].T
        cosines[np.arange(end)[None] >= np.arange(start, end)[:, None]] = -1.0
        found[start:end] = cosines.max(1) > _NEAR_COSINE
    return round(float(found.mean()), 5)


def retrieval_statistics(dataset: HabitDataset, retriever: Retriever) -> dict[str, float]:
    """MRR and recall of a target's own habits with the paper's query, over seeded knowledge bases of 20 categories."""
    figures: dict[str, list[float]] = {"mrr": [], "recall_at_10": [], "recall_at_20": []}
    sizes = []
    scenes = dataset.scenes or SCENES
    for number in range(_KNOWLEDGE_BASES):
        people = household(scenes[number % len(scenes)], dataset)
        rng = stream(0, "statistics", "retrieval", number)
        names = [str(name) for name in rng.permutation(sorted(people))[:_CATEGORIES]]
        base = KnowledgeBase.build(dataset, {name: people[name] for name in names}, seed=number)
        sizes.append(len(base))
        for name in names[:5]:
            ranking, about = retriever.rank(name, base), base.rows_about(name)
            figures["mrr"].append(mrr(ranking, about))
            figures["recall_at_10"].append(recall_at(ranking, about, 10))
            figures["recall_at_20"].append(recall_at(ranking, about, 20))
    return {name: round(float(np.mean(values)), 4) for name, values in figures.items()} | {
        "knowledge_base_size": round(float(np.mean(sizes)), 1)
    }


def _masked(dataset: HabitDataset) -> Sequence[str]:
    """Sentences with every category name (targets and anchors) replaced."""
    names = sorted({n.replace("_", " ") for n in (*dataset.categories, *dataset.anchors)}, key=len, reverse=True)
    pattern = re.compile(r"\b(" + "|".join(map(re.escape, names)) + r")s?\b")
    return [pattern.sub("#", text.lower()) for text in dataset.texts]
