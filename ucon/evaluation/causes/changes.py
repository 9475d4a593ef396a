"""Sentences that can replace another: one that keeps the same thing elsewhere, or one that names another landmark."""

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

#: Never used as the other landmark: every home has them, and hardly any sentence names them.
_STRUCTURE: Final = frozenset({"floors", "walls", "ceilings"})


def placed_elsewhere(dataset: HabitDataset, episode: Episode, row: int) -> str | None:
    """A sentence of another household that keeps the same thing elsewhere in this home, drawn by the episode's id.

    Args:
        dataset: of the sentences.
        episode: the episode in which it is told.
        row: row of the sentence that it replaces.

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
    """The sentence with its landmark, the anchor at which it places something, replaced by another of this home.

    The other landmark is an anchor at which somebody keeps things in the same relation (in it, on it, ...), but where
    neither this household keeps the thing nor the target is; it is drawn by the episode's id.

    Args:
        dataset: of the sentences.
        episode: the episode in which it is told.
        row: of the sentence.

    Returns:
        The sentence; None where it does not name its landmark (or a synonym), or the home has no other one.
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
    """Anchors at which somebody keeps something in this relation."""
    return {place.anchor for entry in dataset.entries for place in entry.placements if place.relation == relation}


def _named(text: str, anchor: str) -> re.Match[str] | None:
    """Where a text names an anchor; the longest names are tried first."""
    names = sorted({phrase(anchor), *synonyms().get(anchor, ())}, key=lambda name: (-len(name), name))
    return re.search(rf"\b(?:{'|'.join(map(re.escape, names))})\b", text, re.IGNORECASE)
