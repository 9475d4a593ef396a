"""Knowledge bases that the belief head is trained on, and the candidate anchors in each.

The habit book belongs to no home: households are drawn from its entries, and all anchors that the fitted parts know
are candidates. A dataset bound to scenes, such as the official release, gives one scene's habits at a time; candidates
are the categories that stand in the scene, or, where the dataset does not say, the anchors that its train entries name
there. The anchors of the knowledge base's own entries are always added, so that every true place is a candidate.
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
#: Most knowledge bases that are drawn to find one about given pairs.
_ATTEMPTS: Final = 50


class KnowledgeBases:
    """Draws knowledge bases from a part of a dataset."""

    def __init__(self, dataset: HabitDataset, known: Sequence[str]) -> None:
        """Prepare the candidates.

        Args:
            dataset: habits.
            known: candidates of every knowledge base, if the dataset is bound to no scenes.
        """
        self.dataset, self._known, self._part_of = dataset, tuple(known), entry_parts(dataset)
        self._anchors = scene_anchors(e for e in dataset.entries if self._part_of[e.id] == "train")
        for scene, names in dataset.standing.items():
            self._anchors.setdefault(scene, set()).update(names)

    def drawn(self, part: Split, seed: int, mode: Mode) -> KnowledgeBase:
        """A knowledge base with entries of one part.

        Args:
            part: ``train``, ``val`` or ``test``.
            seed: decides the entries.
            mode: one entry per category, or all; ignored for a dataset bound to scenes.
        """
        return part_kb(self.dataset, part, seed) if self.dataset.scenes else sampled_kb(self.dataset, part, seed, mode)

    def several(self, part: Split, first: int, count: int) -> list[KnowledgeBase]:
        """``count`` knowledge bases with seeds from ``first`` on; the two modes alternate."""
        return [self.drawn(part, first + number, MODES[1 - number % 2]) for number in range(count)]

    def targets(self, kb: KnowledgeBase, part: Split) -> list[str]:
        """Targets whose entries are all of ``part``; a scene's knowledge base is filled up with train entries."""
        return [name for name, entries in kb.entries.items() if all(self._part_of[e.id] == part for e in entries)]

    def asked(self, part: Split, seed: int, mode: Mode, pairs: Collection[Pair]) -> KnowledgeBase:
        """A knowledge base that has at least one of the pairs: the first such one in a sequence drawn from ``seed``.

        Args:
            part: ``train``, ``val`` or ``test``.
            seed: of the sequence.
            mode: as for :meth:`drawn`.
            pairs: (scene, category) pairs.

        Raises:
            DataError: none of 50 knowledge bases has one.
        """
        for attempt in range(_ATTEMPTS):
            kb = self.drawn(part, derived_seed(seed, "kb", attempt), mode)
            if any((e[0].scene or "", e[0].category) in pairs for e in kb.entries.values()):
                return kb
        raise DataError(f"{self.dataset.name}: too few {part} targets; give a larger dataset")

    def candidates(self, kb: KnowledgeBase) -> tuple[str, ...]:
        """Candidate anchors of a knowledge base, sorted where the dataset is bound to scenes.

        The anchors of its own entries are included, also of entries outside the train part: a true place that is no
        candidate could not be predicted at all.
        """
        if not self.dataset.scenes:
            return self._known
        entries = [entry for entries in kb.entries.values() for entry in entries]
        named = {place.anchor for entry in entries for place in entry.placements}
        return tuple(sorted(named | self._anchors.get(entries[0].scene or "", set())))


def pair_folds(dataset: HabitDataset, count: int) -> list[tuple[frozenset[Pair], list[Entry]]]:
    """Deal the train (scene, category) pairs into ``count`` folds.

    The prior of a held-out pair then rests on other categories of its scene and on its category in other scenes, as it
    will for pairs of the val and test parts.

    Returns:
        For each fold its pairs, and the train entries of all other folds.
    """
    parts = entry_parts(dataset)
    taught = [e for e in dataset.entries if parts[e.id] == "train"]
    folds = scene_category_folds(taught, count, dataset.name)
    return [(fold, [e for e in taught if (e.scene or "", e.category) not in fold]) for fold in folds]
