"""What may be told in the place of a sentence: the same thing kept elsewhere, or its landmark by another name."""

from __future__ import annotations

import re
from typing import Final

from ucon.core.rng import stream
from ucon.envs.told.falsehoods import elsewhere, place_now, things_of
from ucon.habits.types import HabitDataset
from ucon.language.phrases import phrase
from ucon.language.words import synonyms
from ucon.task.episode import Episode

#: Every home has them, and hardly any sentence names them.
_STRUCTURE: Final = frozenset({"floors", "walls", "ceilings"})


def placed_elsewhere(dataset: HabitDataset, episode: Episode, row: int) -> str | None:
    """A sentence of another household that keeps the same thing elsewhere in this home, drawn by the episode's id.

    Args:
        dataset: of the sentences.
        episode: that it is told in.
        row: of the sentence that it takes the place of.

    Returns:
        The sentence; None where nobody in the dataset says such a thing.
    """
    not_there = {place.anchor for place in dataset.supports(row)} | {place_now(dataset, episode).anchor}
    rows = [
        other
        for other in elsewhere(dataset, episode, dataset.entry_of(row).category)
        if not_there.isdisjoint(place.anchor for place in dataset.supports(other))
    ]
    if not rows:
        return None
    return dataset.texts[rows[int(stream(0, "placed elsewhere", episode.id, row).integers(len(rows)))]]


def renamed(dataset: HabitDataset, episode: Episode, row: int) -> str | None:
    """The sentence with the thing by which it places something replaced by another of this home.

    The other is an anchor of the dataset by which neither this household keeps the thing nor the target is, drawn by
    the episode's id.

    Args:
        dataset: of the sentences.
        episode: that it is told in.
        row: of the sentence.

    Returns:
        The sentence; None where it names no such thing by its name or a synonym.
    """
    entry = dataset.entry_of(row)
    text = dataset.texts[row]
    named = [found for place in dataset.supports(row) if (found := _named(text, place.anchor))]
    kept = {place.anchor for place in entry.placements} | {place_now(dataset, episode).anchor, entry.category}
    others = sorted((things_of(episode) & set(dataset.anchors)) - kept - _STRUCTURE)
    if not named or not others:
        return None
    other = others[int(stream(0, "renamed", episode.id, row).integers(len(others)))]
    return text[: named[0].start()] + phrase(other) + text[named[0].end() :]


def _named(text: str, anchor: str) -> re.Match[str] | None:
    """Where a text names an anchor; its longest name first."""
    names = sorted({phrase(anchor), *synonyms().get(anchor, ())}, key=lambda name: (-len(name), name))
    return re.search(rf"\b(?:{'|'.join(map(re.escape, names))})\b", text, re.IGNORECASE)
