"""The rules for entries, shared by the book's parser and every other source of entries.

Each function checks some values. It returns what is wrong, in one line without file and position, or None.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from ucon.core.errors import unknown_name
from ucon.core.text import is_shown
from ucon.habits.types import HOUSEHOLD_KINDS, Placement
from ucon.objects.model import RELATIONS

MAX_LINE: Final = 400


@dataclass(frozen=True)
class Limits:
    """Least and most placements and habits of an entry, and words of a sentence."""

    placements: tuple[int, int]
    habits: tuple[int, int]
    words: tuple[int, int]


#: Limits of the habit book, so that its households are alike.
BOOK_LIMITS: Final = Limits((3, 6), (8, 13), (5, 26))
#: Limits of a user's own households; the format counts the placements of an entry by one digit.
OWN_LIMITS: Final = Limits((1, 9), (1, 1000), (1, 80))

Anchors = Mapping[str, frozenset[str]]
"""Relations that each anchor category allows."""

_HOUSEHOLD = re.compile(r"\S[^{}]*")
_CONTEXT = re.compile(r"[^{}]+")


def line_fault(line: str) -> str | None:
    """What keeps a text from being one line of a habit file: its length, or a control character."""
    if len(line) > MAX_LINE:
        return f"{len(line)} characters, at most {MAX_LINE} are allowed; shorten it"
    if not is_shown(line):
        return "a control character; expected plain text, remove it"
    return None


def header_fault(category: str, household: str, kind: str | None, categories: Collection[str] | None) -> str | None:
    """What is wrong with an entry's header.

    Args:
        category: target category.
        household: description of the people.
        kind: kind of home, or None.
        categories: names that exist; None accepts any.
    """
    if not _HOUSEHOLD.fullmatch(household):
        return f"household '{household[:60]}', expected a description that starts with a word and has no braces"
    if categories is not None and category not in categories:
        return unknown_name("category", category, categories)
    if kind is not None and kind not in HOUSEHOLD_KINDS:
        return unknown_name("kind of place", kind, HOUSEHOLD_KINDS)
    return None


def placement_fault(category: str, earlier: Sequence[Placement], new: Placement, anchors: Anchors) -> str | None:
    """What is wrong with a placement.

    Args:
        category: of the entry.
        earlier: the entry's placements before it.
        new: the placement.
        anchors: allowed relations of each anchor.
    """
    relation, anchor = new.relation, new.anchor
    if relation not in RELATIONS:
        return unknown_name("relation", relation, RELATIONS)
    if anchor not in anchors:
        return unknown_name("anchor", anchor, anchors)
    if relation not in anchors[anchor]:
        return f"nothing is {relation} a {anchor}; expected one of {', '.join(sorted(anchors[anchor]))}"
    if anchor == category:
        return f"a {anchor} placed onto itself; name another anchor"
    if any((p.relation, p.anchor) == (relation, anchor) for p in earlier):
        return f"'{relation} {anchor}' is listed twice; keep one line"
    if new.context is not None and not _CONTEXT.fullmatch(new.context):
        return f"context '{new.context[:60]}', expected words without braces"
    return None


def habit_fault(text: str, supports: Sequence[int], n_placements: int, limits: Limits) -> str | None:
    """What is wrong with a habit.

    Args:
        text: the sentence.
        supports: indices, from 0, of the placements it supports.
        n_placements: of its entry.
        limits: least and most words.
    """
    for index in supports:
        if not 0 <= index < n_placements:
            return f"no placement {index + 1}; the entry has {n_placements}"
    if len(set(supports)) < len(supports):
        return f"a placement is named twice in '{','.join(str(i + 1) for i in supports)}:'; name it once"
    words = len(text.split())
    low, high = limits.words
    if not low <= words <= high:
        return f"{words} words, expected {low} to {high}"
    if "_" in text:
        return "an underscore in a sentence; write names as people do"
    return None


def count_fault(n_placements: int, n_habits: int, limits: Limits) -> str | None:
    """What is wrong with the number of placements or habits of an entry."""
    counted = (("placements", n_placements, limits.placements), ("habits", n_habits, limits.habits))
    for what, found, (low, high) in counted:
        if not low <= found <= high:
            return f"{found} {what}, expected {low} to {high}"
    return None
