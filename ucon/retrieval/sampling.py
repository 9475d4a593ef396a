"""Knowledge bases without homes, for fitting and measuring readers, and the truth they are measured against."""

from __future__ import annotations

from collections.abc import Sequence

from ucon.core.rng import stream
from ucon.habits.hosting import N_ENTRIES_P
from ucon.habits.knowledge import KnowledgeBase, Mode
from ucon.habits.splits import Split, category_split, entry_parts
from ucon.habits.types import Entry, HabitDataset


def sampled_kb(
    data: HabitDataset, split: Split, seed: int, mode: Mode, k: int = 20, categories: Split | None = None
) -> KnowledgeBase:
    """Knowledge base of ``k`` categories, drawn from the entries of one part as households draw them.

    ``categories`` takes only categories of that part: ``test`` entries of ``train`` categories are unseen habits of
    seen categories.
    """
    rng = stream(seed, "sampled_kb", split, *([categories] if categories else []))
    parts = entry_parts(data)
    usable = {name: [e for e in data.entries_of(name) if parts[e.id] == split] for name in data.categories}
    names = [n for n, entries in usable.items() if entries and categories in (None, category_split(n))]
    drawn: dict[str, Sequence[Entry]] = {}
    for name in rng.choice(names, size=min(k, len(names)), replace=False):
        entries = usable[str(name)]
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
