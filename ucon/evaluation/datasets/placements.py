"""Figures of a dataset's placements: relations, support by habits, disagreement of households, contexts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np

from ucon.evaluation.datasets.sentences import names
from ucon.habits import Entry, HabitDataset
from ucon.habits.contexts import Condition, condition_of
from ucon.objects.model import RELATIONS

CONTEXT_KINDS = ("day", "time", "season", "event", "other")


def placement_statistics(dataset: HabitDataset) -> dict[str, Any]:
    """Figures of the placements and of the habits that support them; shares are of placements unless named otherwise.

    ``unsupported_placements`` follows the labels; in a dataset without labels a placement counts as supported if a
    habit of its entry names the anchor in full. ``unnamed_placements`` is that criterion for every dataset.
    """
    n_places = [len(entry.placements) for entry in dataset.entries]
    n_anchors = [len({place.anchor for place in entry.placements}) for entry in dataset.entries]
    total = sum(n_places)
    unnamed = sum(_unnamed(entry) for entry in dataset.entries) / total
    supported = sum(len({i for habit in entry.habits for i in habit.supports}) for entry in dataset.entries)
    relations = Counter(place.relation for entry in dataset.entries for place in entry.placements)
    return {
        "placements": total,
        "placements_per_entry": round(float(np.mean(n_places)), 3),
        "anchors": len(dataset.anchors),
        "anchors_per_entry": round(float(np.mean(n_anchors)), 3),
        "relations": {name: round(relations[name] / total, 4) for name in RELATIONS},
        "unsupported_placements": round(1 - supported / total if dataset.labelled else unnamed, 4),
        "unsupported_by": "labels" if dataset.labelled else "phrase",
        "unnamed_placements": round(unnamed, 4),
        "supporting_habits": _share(bool(h.supports) for h in dataset.habits) if dataset.labelled else None,
        "contradictions": _contradictions(dataset),
        "contexts": _contexts(dataset),
    }


def conditions(dataset: HabitDataset) -> list[Condition]:
    """The condition of every placement that has a context."""
    places = (place for entry in dataset.entries for place in entry.placements)
    return [condition_of(place.context) for place in places if place.context is not None]


def anchor_shares(dataset: HabitDataset) -> dict[str, float]:
    """Share of placements by anchor, most frequent first."""
    counts = Counter(place.anchor for entry in dataset.entries for place in entry.placements)
    total = sum(counts.values())
    return {name: count / total for name, count in sorted(counts.items(), key=lambda pair: (-pair[1], pair[0]))}


def _unnamed(entry: Entry) -> int:
    return sum(not any(names(habit.text, place.anchor) for habit in entry.habits) for place in entry.placements)


def _share(values: Iterator[bool]) -> float:
    return round(float(np.fromiter(values, bool).mean()), 4)


def _contradictions(dataset: HabitDataset) -> dict[str, Any]:
    """How much two households that may share a home disagree about one target, over all such pairs."""
    overlaps: list[float] = []
    for category in dataset.categories:
        for one, other in combinations(dataset.entries_of(category), 2):
            if one.scene == other.scene and (one.kind == other.kind or None in (one.kind, other.kind)):
                a, b = ({place.anchor for place in entry.placements} for entry in (one, other))
                overlaps.append(len(a & b) / len(a | b))
    return {
        "pairs": len(overlaps),
        "disjoint": round(float(np.mean(np.asarray(overlaps) == 0)), 4) if overlaps else None,
        "mean_jaccard": round(float(np.mean(overlaps)), 4) if overlaps else None,
    }


def _contexts(dataset: HabitDataset) -> dict[str, Any]:
    """Placements with a context, by kind of condition; one context may have two kinds."""
    places = [place for entry in dataset.entries for place in entry.placements]
    contexts = [place.context for place in places if place.context is not None]
    kinds = Counter(kind for condition in conditions(dataset) for kind in condition.kinds)
    return {
        "placements": len(contexts),
        "share": round(len(contexts) / len(places), 4),
        "distinct": len(set(contexts)),
        "kinds": {name: kinds[name] for name in CONTEXT_KINDS},
    }
