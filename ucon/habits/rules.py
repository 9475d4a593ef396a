"""What makes an entry: the rules that the book's parser and every other source of entries share.

Each function looks at values and returns what is wrong with them, in one line without a place, or None.
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
    """How much an entry may have, least and most."""

    placements: tuple[int, int]
    habits: tuple[int, int]
    words: tuple[int, int]
    """Of a sentence."""


#: What the habit book keeps, so that its households are alike.
BOOK_LIMITS: Final = Limits((3, 6), (8, 13), (5, 26))
#: What anybody's own households keep; the format counts the placements of an entry by one digit.
OWN_LIMITS: Final = Limits((1, 9), (1, 1000), (1, 80))

Anchors = Mapping[str, frozenset[str]]
"""Relations that each anchor category allows."""

_HOUSEHOLD = re.compile(r"\S[^{}]*")
_CONTEXT = re.compile(r"[^{}]+")


def line_fault(line: str) -> str | None:
    """What keeps a text from being one line of a habit file: its length, or a character that cannot be seen."""
    if len(line) > MAX_LINE:
        return f"{len(line)} characters, at most {MAX_LINE} are allowed; shorten it"
    if not is_shown(line):
        return "a control character; expected plain text, remove it"
    return None


def header_fault(category: str, household: str, kind: str | None, categories: Collection[str] | None) -> str | None:
    """What is wrong with whose entry it is; ``categories`` that exist, None accepts any name."""
    if not _HOUSEHOLD.fullmatch(household):
        return f"household '{household[:60]}', expected a description that starts with a word and has no braces"
    if categories is not None and category not in categories:
        return unknown_name("category", category, categories)
    if kind is not None and kind not in HOUSEHOLD_KINDS:
        return unknown_name("kind of place", kind, HOUSEHOLD_KINDS)
    return None


def placement_fault(category: str, earlier: Sequence[Placement], new: Placement, anchors: Anchors) -> str | None:
    """What is wrong with a placement that follows ``earlier`` ones of its entry."""
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
    """What is wrong with a sentence and the placements (from 0) that it supports."""
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
    """What is wrong with how much an entry has."""
    counted = (("placements", n_placements, limits.placements), ("habits", n_habits, limits.habits))
    for what, found, (low, high) in counted:
        if not low <= found <= high:
            return f"{found} {what}, expected {low} to {high}"
    return None
