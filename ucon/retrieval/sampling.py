"""Knowledge bases without homes, for fitting and measuring readers, and the truth they are measured against."""

from __future__ import annotations

from collections.abc import Sequence

from ucon.core.rng import stream
from ucon.habits.hosting import N_ENTRIES_P
from ucon.habits.knowledge import KnowledgeBase, Mode
from ucon.habits.splits import Split, split_categories
from ucon.habits.types import Entry, HabitDataset


def sampled_kb(data: HabitDataset, split: Split, seed: int, mode: Mode, k: int = 20) -> KnowledgeBase:
    """Knowledge base of ``k`` categories of one part, entries drawn as households do."""
    rng = stream(seed, "sampled_kb", split)
    names = split_categories(data.categories, split)
    drawn: dict[str, Sequence[Entry]] = {}
    for name in rng.choice(names, size=min(k, len(names)), replace=False):
        entries = data.entries_of(str(name))
        count = min(int(rng.choice(3, p=N_ENTRIES_P)) + 1, len(entries))
        drawn[str(name)] = [entries[i] for i in sorted(rng.choice(len(entries), size=count, replace=False))]
    return KnowledgeBase.build(data, drawn, seed, mode)


def location_distribution(entries: Sequence[Entry]) -> dict[tuple[str, str], float]:
    """Probability of each (anchor, relation) when a placement is drawn uniformly."""
    placements = [p for e in entries for p in e.placements]
    out: dict[tuple[str, str], float] = {}
    for p in placements:
        out[p.anchor, p.relation] = out.get((p.anchor, p.relation), 0.0) + 1 / len(placements)
    return out


def anchor_distribution(entries: Sequence[Entry]) -> dict[str, float]:
    """Probability of each anchor when a placement is drawn uniformly."""
    out: dict[str, float] = {}
    for (anchor, _), p in location_distribution(entries).items():
        out[anchor] = out.get(anchor, 0.0) + p
    return out
