"""Which entries a home can host, and which entries make up its household."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass

from ucon.core.rng import stream
from ucon.habits.splits import Split, entry_filter
from ucon.habits.types import Entry, HabitDataset, Placement
from ucon.habits.verdicts import NO_VERDICTS, Verdicts

#: Number of realisable placements that an entry with several needs to be hosted.
MIN_REALISABLE = 2
#: Probability of 1, 2 and 3 entries per category: 2.3 on average.
N_ENTRIES_P = (0.15, 0.40, 0.45)


@dataclass(frozen=True, slots=True)
class Hosted:
    """An entry, and the indices of its placements that a home can realise."""

    entry: Entry
    realisable: tuple[int, ...]

    @property
    def ok(self) -> bool:
        """Whether the entry may be sampled in the home: two placements can be realised, or its only one."""
        return len(self.realisable) >= max(1, min(MIN_REALISABLE, len(self.entry.placements)))

    @property
    def placements(self) -> tuple[Placement, ...]:
        """The realisable placements."""
        return tuple(self.entry.placements[i] for i in self.realisable)


def hosted(
    entries: Iterable[Entry],
    anchors_present: Collection[str],
    importable: Callable[[str], bool] = lambda _: False,
    *,
    home: str = "",
    verdicts: Verdicts = NO_VERDICTS,
) -> list[Hosted]:
    """The realisable placements of every entry in a home; ``ok`` says whether it is hosted.

    Args:
        entries: of a dataset or household.
        anchors_present: categories in the home.
        importable: whether a missing anchor can be added.
        home: its name; ``verdicts`` of this home take precedence.
        verdicts: of validation; a placement they refuse is not realisable.
    """
    can = dict.fromkeys(anchors_present, True)

    def realisable(anchor: str) -> bool:
        if anchor not in can:
            can[anchor] = bool(importable(anchor))
        return can[anchor]

    def holds(entry: Entry, place: Placement) -> bool:
        triple = (entry.category, place.relation, place.anchor)
        return realisable(place.anchor) and verdicts.refusal(triple, home) is None

    return [Hosted(e, tuple(i for i, p in enumerate(e.placements) if holds(e, p))) for e in entries]


def household(
    home: str,
    dataset: HabitDataset,
    seed: int = 0,
    *,
    kinds: Collection[str] = (),
    part: Split | None = None,
) -> dict[str, tuple[Entry, ...]]:
    """The household of a home: 1 to 3 entries for each category, drawn by the home's name.

    Entries bound to scenes are not drawn: a named scene and its variants have all entries of the scene, other homes all
    entries of one scene, chosen by the home's name.

    Args:
        home: its name.
        dataset: the entries.
        seed: another seed gives another household.
        kinds: of the home (:data:`ucon.habits.types.HOUSEHOLD_KINDS`). Entries bound to these come first, entries bound
            to other kinds are never drawn.
        part: draw only from the entries that episodes of this part may use; None: from all.

    Returns:
        Entries by category.
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
    usable = entry_filter(dataset, part)
    drawn = {}
    for category in dataset.categories:
        entries = [e for e in dataset.entries_of(category) if usable(e) and (e.kind is None or e.kind in kinds)]
        if entries:
            drawn[category] = _draw(home, category, entries, seed)
    return drawn


def _draw(home: str, category: str, entries: Sequence[Entry], seed: int) -> tuple[Entry, ...]:
    """1 to 3 random entries; those bound to a kind of home come first."""
    rng = stream(seed, "household", home, category)
    count = min(int(rng.choice(3, p=N_ENTRIES_P)) + 1, len(entries))
    order = sorted(rng.permutation(len(entries)), key=lambda i: entries[i].kind is None)
    return tuple(entries[i] for i in sorted(order[:count]))
