"""Which entries a home can host, and which of them its household has."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass

from ucon.core.rng import stream
from ucon.habits.types import Entry, HabitDataset, Placement

MIN_REALISABLE = 2
#: Probability of 1, 2 and 3 entries a category: 2.3 in the mean.
N_ENTRIES_P = (0.15, 0.40, 0.45)


@dataclass(frozen=True, slots=True)
class Hosted:
    """An entry with the indices of its placements that a home can realise."""

    entry: Entry
    realisable: tuple[int, ...]

    @property
    def ok(self) -> bool:
        """Whether at least two placements can be realised, so that the entry may be sampled there."""
        return len(self.realisable) >= MIN_REALISABLE

    @property
    def placements(self) -> tuple[Placement, ...]:
        """The realisable placements."""
        return tuple(self.entry.placements[i] for i in self.realisable)


def hosted(
    entries: Iterable[Entry], anchors_present: Collection[str], importable: Callable[[str], bool] = lambda _: False
) -> list[Hosted]:
    """Every entry with what a home can realise of it; ``ok`` says whether it is hosted, the others are listed too.

    Args:
        entries: of a dataset or household.
        anchors_present: categories that stand in the home.
        importable: whether a missing anchor can be brought in.
    """
    can = dict.fromkeys(anchors_present, True)

    def realisable(anchor: str) -> bool:
        if anchor not in can:
            can[anchor] = bool(importable(anchor))
        return can[anchor]

    return [Hosted(e, tuple(i for i, p in enumerate(e.placements) if realisable(p.anchor))) for e in entries]


def household(home: str, dataset: HabitDataset, seed: int = 0) -> dict[str, tuple[Entry, ...]]:
    """What the people of a home are like: for each category 1 to 3 entries, seeded by the home's name.

    Entries bound to scenes are not drawn: a named scene and its variants have all of their own, other homes borrow
    those of one scene, chosen by the home's name.
    """
    if dataset.scenes:
        scene = home.split("~")[0]
        if scene not in dataset.scenes:
            scene = dataset.scenes[int(stream(seed, "household", home, "scene").integers(len(dataset.scenes)))]
        found: dict[str, list[Entry]] = {}
        for entry in dataset.entries:
            if entry.scene == scene:
                found.setdefault(entry.category, []).append(entry)
        return {category: tuple(entries) for category, entries in sorted(found.items())}
    return {category: _draw(home, dataset, category, seed) for category in dataset.categories}


def _draw(home: str, dataset: HabitDataset, category: str, seed: int) -> tuple[Entry, ...]:
    entries = dataset.entries_of(category)
    rng = stream(seed, "household", home, category)
    count = min(int(rng.choice(3, p=N_ENTRIES_P)) + 1, len(entries))
    return tuple(entries[i] for i in sorted(rng.choice(len(entries), size=count, replace=False)))
