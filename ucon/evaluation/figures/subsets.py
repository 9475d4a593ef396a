"""Episodes in which habits may pay off: the target's place is against common sense, or varies among people.

A record does not say where the target is, so the episode is looked up in the set that its id names. For other episodes
(the official release's, those in a user's own home) neither is known.
"""

from __future__ import annotations

import math
from collections import Counter
from functools import lru_cache
from typing import Final

from ucon.core.errors import UconError
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.habits.book import book
from ucon.task.episode import Episode
from ucon.task.sets import episode_sets, load_episodes

#: Limits of :func:`common_sense`: below the first, common sense speaks against a place; from the second on, for it.
AGAINST: Final = 1.0
FOR: Final = 3.0
#: Limits of :func:`variety`, which divide the test episodes into thirds.
VARIETY: Final = (15.0, 17.0)
UNKNOWN: Final = "not known"


def is_against_common_sense(record: EpisodeRecord) -> bool:
    """Whether common sense speaks against the place of an episode's target, as far as that is known."""
    found = common_sense(record)
    return found is not None and found < AGAINST


def by_common_sense(record: EpisodeRecord) -> str:
    """How likely the target's place is by common sense, in words: ``0-1 times chance`` is against common sense."""
    found = common_sense(record)
    return UNKNOWN if found is None else _class(found, 0, (AGAINST, FOR), "times chance")


def by_variety(record: EpisodeRecord) -> str:
    """Number of anchors over which households spread such a thing, in words."""
    found = variety(record.target) if _episode(record) is not None else None
    return UNKNOWN if found is None else _class(found, 1, VARIETY, "anchors")


def common_sense(record: EpisodeRecord) -> float | None:
    """Probability of the target's anchor without any habit, as a multiple of that of an anchor picked at random.

    The probability is that of the shipped fitted reader, which learned from other categories' households.

    Returns:
        The ratio; 0 for an anchor that the reader does not know, None where the episode is in no shipped set.
    """
    episode = _episode(record)
    if episode is None:
        return None
    dataset = book()
    entry, number = episode.placed_by[episode.target]
    anchor = dataset.entries[dataset.entry_number[entry]].placements[number].anchor
    likely = _without_habits(record.target)
    return likely.get(anchor, 0.0) * len(likely)


@lru_cache(maxsize=4096)
def variety(category: str) -> float | None:
    """Effective number of anchors over which the book's households spread a thing: the exponential of the entropy.

    Each household counts once, and its placements count equally.

    Args:
        category: of the thing.

    Returns:
        1 where all keep it at one anchor; None for a category that the book does not have.
    """
    dataset = book()
    if category not in dataset.categories:
        return None
    entries, share = dataset.entries_of(category), Counter[str]()
    for entry in entries:
        for place in entry.placements:
            share[place.anchor] += 1.0 / len(entry.placements) / len(entries)  # type: ignore[assignment]
    return math.exp(-sum(p * math.log(p) for p in share.values()))


def _class(value: float, least: float, limits: tuple[float, float], unit: str) -> str:
    """Class of a value, in words: ``1-15 anchors``."""
    low, high = limits
    if value < low:
        return f"{least:g}-{low:g} {unit}"
    return f"{low:g}-{high:g} {unit}" if value < high else f"from {high:g} {unit}"


@lru_cache(maxsize=4096)
def _without_habits(target: str) -> dict[str, float]:
    """Probability of each anchor before any habit is read."""
    from ucon.perception.belief.from_habits import ReadHabits  # weights, which most tables do not need

    found = ReadHabits()({"target": target, "habits": (), "habit_level": "none"})
    return dict(zip(found.names, found.p.sum(1).tolist(), strict=True))


def _episode(record: EpisodeRecord) -> Episode | None:
    """The episode of a record, if it is one of a shipped set of the habit book."""
    found = _set(record.episode.partition("/")[0]).get(record.episode)
    same = found is not None and (found.scene, found.target_category) == (record.scene, record.target)
    return found if same else None


@lru_cache(maxsize=16)
def _set(name: str) -> dict[str, Episode]:
    if name not in episode_sets():
        return {}
    try:
        episodes = load_episodes(name)
    except UconError:  # a damaged set is reported where it is played
        return {}
    return {episode.id: episode for episode in episodes if episode.habits_hash == book().sha256}
