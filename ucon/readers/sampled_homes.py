"""Knowledge bases without homes, for fitting and measuring readers, and the true distributions of their targets."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ucon.core.errors import DataError
from ucon.core.rng import stream
from ucon.habits.hosting import N_ENTRIES_P
from ucon.habits.knowledge import KnowledgeBase, Mode
from ucon.habits.splits import Split, entry_parts
from ucon.habits.types import Entry, HabitDataset


def sampled_kb(data: HabitDataset, split: Split, seed: int, mode: Mode, k: int = 20) -> KnowledgeBase:
    """Knowledge base of ``k`` categories, drawn from one part's entries as households draw them.

    Each category gets one to three entries.

    Args:
        data: the dataset.
        split: ``train``, ``val`` or ``test``.
        seed: decides what is drawn.
        mode: ``task`` keeps one entry per category, ``category`` all.
        k: number of categories.
    """
    rng = stream(seed, "sampled_kb", split)
    parts = entry_parts(data)
    usable = {name: [e for e in data.entries_of(name) if parts[e.id] == split] for name in data.categories}
    names = [name for name, entries in usable.items() if entries]
    drawn: dict[str, Sequence[Entry]] = {}
    for name in rng.choice(names, size=min(k, len(names)), replace=False):
        entries = usable[str(name)]
        count = min(int(rng.choice(3, p=N_ENTRIES_P)) + 1, len(entries))
        drawn[str(name)] = [entries[i] for i in sorted(rng.choice(len(entries), size=count, replace=False))]
    return KnowledgeBase.build(data, drawn, seed, mode)


def part_kb(data: HabitDataset, part: Split, seed: int, k: int = 20) -> KnowledgeBase:
    """Knowledge base of ``k`` categories with one entry each, from ``part`` where the category has one there.

    For a dataset bound to scenes all entries are from one scene, drawn in proportion to its categories of the part;
    where these are fewer than ``k``, train entries of the scene are added. For others all entries are of the part.

    Args:
        data: the dataset.
        part: ``train``, ``val`` or ``test``.
        seed: decides what is drawn.
        k: number of categories.

    Raises:
        DataError: the part has no entry.
    """
    rng, parts = stream(seed, "part_kb", part), entry_parts(data)
    own = [entry for entry in data.entries if parts[entry.id] == part]
    if not own:
        raise DataError(f"{data.name}: no entry in its {part} part; give a larger dataset")
    if data.scenes:
        groups = sorted({(e.scene or "", e.category) for e in own})
        scene = groups[int(rng.integers(len(groups)))][0]
        own = [e for e in own if e.scene == scene]
        others = [e for e in data.entries if e.scene == scene and parts[e.id] == "train"]
    else:
        others = []
    names = _drawn(rng, {e.category for e in own}, k)
    names += _drawn(rng, {e.category for e in others} - {e.category for e in own}, k - len(names))
    drawn = {name: [e for e in [*own, *others] if e.category == name] for name in names}
    return KnowledgeBase.build(data, drawn, seed, "task")


def entry_kb(data: HabitDataset, entry: Entry, seed: int, k: int = 20) -> KnowledgeBase:
    """Knowledge base about one entry that is bound to a scene.

    It is filled up with train entries of ``k`` - 1 other categories of the scene.

    Args:
        data: the dataset.
        entry: the entry, always included.
        seed: decides the order of the habits.
        k: number of categories.
    """
    parts = entry_parts(data)
    others = [e for e in data.entries if e.scene == entry.scene and parts[e.id] == "train"]
    names = _drawn(stream(seed, "entry_kb", entry.id), {e.category for e in others} - {entry.category}, k - 1)
    drawn = {name: [e for e in others if e.category == name] for name in names}
    return KnowledgeBase.build(data, drawn | {entry.category: [entry]}, seed, "task")


def _drawn(rng: np.random.Generator, names: Collection[str], k: int) -> list[str]:
    return [str(name) for name in rng.choice(sorted(names), size=min(k, len(names)), replace=False)] if names else []


def location_distribution(entries: Sequence[Entry]) -> dict[tuple[str, str], float]:
    """Probability of each (anchor, relation) when one of the entries' placements is drawn uniformly."""
    placements = [p for e in entries for p in e.placements]
    out: dict[tuple[str, str], float] = {}
    for p in placements:
        out[p.anchor, p.relation] = out.get((p.anchor, p.relation), 0.0) + 1 / len(placements)
    return out


def anchor_distribution(entries: Sequence[Entry]) -> dict[str, float]:
    """Probability of each anchor when one of the entries' placements is drawn uniformly."""
    out: dict[str, float] = {}
    for (anchor, _), p in location_distribution(entries).items():
        out[anchor] = out.get(anchor, 0.0) + p
    return out
