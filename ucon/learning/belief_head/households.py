"""Whose habits the belief head learns from: knowledge bases of a dataset, and the anchors that are asked about in them.

The habit book belongs to no home: households are drawn from its entries, and all anchors that the fitted parts know
are candidates. A dataset that is bound to scenes, as the official release is, gives one scene's habits at a time;
candidates are what stands in the scene, or, where nothing says so, the anchors that its training entries name there;
and in either case those of the entries that are asked about, so that each has a place among them.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Final

from ucon.core.errors import DataError
from ucon.core.rng import derived_seed
from ucon.habits.knowledge import MODES, KnowledgeBase, Mode
from ucon.habits.splits import Split, entry_parts, scene_category_folds
from ucon.habits.types import Entry, HabitDataset
from ucon.readers.anchor_prior import scene_anchors
from ucon.readers.sampled_homes import part_kb, sampled_kb

#: A scene and a target category.
Pair = tuple[str, str]
#: Knowledge bases that are drawn to find one about some pairs.
_ATTEMPTS: Final = 50


class KnowledgeBases:
    """Draws knowledge bases of one part of a dataset after the other."""

    def __init__(self, dataset: HabitDataset, known: Sequence[str]) -> None:
        """``known``: anchors that are candidates everywhere where the dataset is bound to no scenes."""
        self.dataset, self._known, self._part_of = dataset, tuple(known), entry_parts(dataset)
        self._anchors = scene_anchors(e for e in dataset.entries if self._part_of[e.id] == "train")
        for scene, names in dataset.standing.items():
            self._anchors.setdefault(scene, set()).update(names)

    def drawn(self, part: Split, seed: int, mode: Mode) -> KnowledgeBase:
        """A knowledge base with entries of a part."""
        return part_kb(self.dataset, part, seed) if self.dataset.scenes else sampled_kb(self.dataset, part, seed, mode)

    def several(self, part: Split, first: int, count: int) -> list[KnowledgeBase]:
        """As many, with both modes in turn."""
        return [self.drawn(part, first + number, MODES[1 - number % 2]) for number in range(count)]

    def targets(self, kb: KnowledgeBase, part: Split) -> list[str]:
        """What may be asked for: a scene's knowledge base is filled up with entries of the train part."""
        return [name for name, entries in kb.entries.items() if all(self._part_of[e.id] == part for e in entries)]

    def asked(self, part: Split, seed: int, mode: Mode, pairs: Collection[Pair]) -> KnowledgeBase:
        """A knowledge base about at least one of some pairs, the first of those that ``seed`` begins."""
        for attempt in range(_ATTEMPTS):
            kb = self.drawn(part, derived_seed(seed, "kb", attempt), mode)
            if any((e[0].scene or "", e[0].category) in pairs for e in kb.entries.values()):
                return kb
        raise DataError(f"{self.dataset.name}: too few {part} targets; give a larger dataset")

    def candidates(self, kb: KnowledgeBase) -> tuple[str, ...]:
        """Anchors that are asked about.

        Those of the knowledge base's own entries are among them, also of entries that are not of the train part: a
        truth that is no candidate could not be told well or badly.
        """
        if not self.dataset.scenes:
            return self._known
        entries = [entry for entries in kb.entries.values() for entry in entries]
        named = {place.anchor for entry in entries for place in entry.placements}
        return tuple(sorted(named | self._anchors.get(entries[0].scene or "", set())))


def pair_folds(dataset: HabitDataset, count: int) -> list[tuple[frozenset[Pair], list[Entry]]]:
    """Train (scene, category) pairs dealt into folds: the pairs of each, and the train entries of the others.

    So what is usual is known to a pair as it will be to those held out: by the same scene's other things, and by the
    same things of other scenes.
    """
    parts = entry_parts(dataset)
    taught = [e for e in dataset.entries if parts[e.id] == "train"]
    folds = scene_category_folds(taught, count, dataset.name)
    return [(fold, [e for e in taught if (e.scene or "", e.category) not in fold]) for fold in folds]
