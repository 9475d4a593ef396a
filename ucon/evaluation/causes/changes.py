"""Sentences that may stand in the place of another: the same thing kept elsewhere, or its landmark by another name."""

from __future__ import annotations

import re
from typing import Final

from ucon.core.rng import stream
from ucon.envs.told.falsehoods import elsewhere, place_now, things_of
from ucon.habits.types import HabitDataset
from ucon.language.phrases import phrase
from ucon.language.words import synonyms
from ucon.objects.model import Relation
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

    The other is an anchor at which somebody keeps things likewise (in it, on it, ...), but neither this household the
    thing, nor is the target there; it is drawn by the episode's id.

    Args:
        dataset: of the sentences.
        episode: that it is told in.
        row: of the sentence.

    Returns:
        The sentence; None where it names no such thing by its name or a synonym.
    """
    entry = dataset.entry_of(row)
    text = dataset.texts[row]
    named = [(found, place) for place in dataset.supports(row) if (found := _named(text, place.anchor))]
    if not named:
        return None
    found, named_place = named[0]
    kept = {place.anchor for place in entry.placements} | {place_now(dataset, episode).anchor, entry.category}
    others = sorted((things_of(episode) & _anchors(dataset, named_place.relation)) - kept - _STRUCTURE)
    if not others:
        return None
    other = others[int(stream(0, "renamed", episode.id, row).integers(len(others)))]
    return text[: found.start()] + phrase(other) + text[found.end() :]


def _anchors(dataset: HabitDataset, relation: Relation) -> set[str]:
    """Anchors in, on, under or beside which somebody keeps something."""
    return {place.anchor for entry in dataset.entries for place in entry.placements if place.relation == relation}


def _named(text: str, anchor: str) -> re.Match[str] | None:
    """Where a text names an anchor; its longest name first."""
    names = sorted({phrase(anchor), *synonyms().get(anchor, ())}, key=lambda name: (-len(name), name))
    return re.search(rf"\b(?:{'|'.join(map(re.escape, names))})\b", text, re.IGNORECASE)
