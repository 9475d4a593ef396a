"""Whose habits the belief head learns from: knowledge bases of a dataset, and the anchors that are asked about in them.

The habit book belongs to no home: households are drawn from its entries, and all anchors that the fitted parts know
are candidates. A dataset that is bound to scenes, as the official release is, gives one scene's habits at a time, and
the anchors that its training entries name there.
"""

from __future__ import annotations

from collections.abc import Sequence

from ucon.core.rng import stream
from ucon.habits.knowledge import MODES, KnowledgeBase, Mode
from ucon.habits.splits import Split, entry_parts
from ucon.habits.types import Entry, HabitDataset
from ucon.retrieval.anchor_prior import scene_anchors
from ucon.retrieval.sampling import part_kb, sampled_kb


class KnowledgeBases:
    """Draws knowledge bases of one part of a dataset after the other."""

    def __init__(self, dataset: HabitDataset, known: Sequence[str]) -> None:
        """``known``: anchors that are candidates everywhere where the dataset is bound to no scenes."""
        self.dataset, self._known, self._part_of = dataset, tuple(known), entry_parts(dataset)
        self._anchors = scene_anchors(e for e in dataset.entries if self._part_of[e.id] == "train")

    def drawn(self, part: Split, seed: int, mode: Mode) -> KnowledgeBase:
        """A knowledge base with entries of a part."""
        return part_kb(self.dataset, part, seed) if self.dataset.scenes else sampled_kb(self.dataset, part, seed, mode)

    def several(self, part: Split, first: int, count: int) -> list[KnowledgeBase]:
        """As many, with both modes in turn."""
        return [self.drawn(part, first + number, MODES[1 - number % 2]) for number in range(count)]

    def targets(self, kb: KnowledgeBase, part: Split) -> list[str]:
        """What may be asked for: a scene's knowledge base is filled up with entries of the train part."""
        return [name for name, entries in kb.entries.items() if all(self._part_of[e.id] == part for e in entries)]

    def candidates(self, kb: KnowledgeBase) -> tuple[str, ...]:
        """Anchors that are asked about."""
        if not self.dataset.scenes:
            return self._known
        entries = [entry for entries in kb.entries.values() for entry in entries]
        named = {place.anchor for entry in entries for place in entry.placements}
        return tuple(sorted(named | self._anchors.get(entries[0].scene or "", set())))


def scene_folds(dataset: HabitDataset, count: int) -> list[tuple[HabitDataset, list[Entry]]]:
    """Pieces of a dataset by scene, each with the train entries of the other pieces' scenes."""
    parts, order = entry_parts(dataset), stream(0, "scene folds", dataset.name).permutation(len(dataset.scenes))
    out = []
    for k in range(min(count, len(order))):
        own = {dataset.scenes[i] for i in order[k::count]}
        piece = tuple(e for e in dataset.entries if e.scene in own)
        others = [e for e in dataset.entries if e.scene not in own and parts[e.id] == "train"]
        out.append((HabitDataset(dataset.name, piece, dataset.labelled), others))
    return out
