"""Entries proposed by language models: the JSON schema of an entry, and the check of an answer.

Entries must keep the rules of the habit book's parser (:mod:`ucon.habits.rules`). All faults are reported together, so
that the model can correct them in one go.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Final, cast

from ucon.habits.rules import (
    BOOK_LIMITS,
    Anchors,
    count_fault,
    habit_fault,
    header_fault,
    line_fault,
    placement_fault,
)
from ucon.habits.types import Entry, Habit, Placement
from ucon.habits.writer import format_entries
from ucon.objects.model import RELATIONS, Relation

#: Special spaces that some models use; replaced by plain ones.
_SPACES: Final = str.maketrans(dict.fromkeys("\u00a0\u2009\u202f", " "))


@dataclass(frozen=True)
class Material:
    """What an entry may be made of."""

    category: str
    kind: str | None
    anchors: Anchors
    contexts: Collection[str]
    """Contexts that a placement may have."""
    sentences: Collection[str]
    """Keys (:func:`sentence_key`) of existing sentences."""
    households: Collection[str]
    """Existing households of the category."""


def sentence_key(text: str) -> str:
    """Key of a sentence; sentences that differ only in case, punctuation and spaces have equal keys."""
    return " ".join(re.findall(r"\w+", text.casefold()))


def entry_schema(offer: Material, contexts: Collection[str]) -> dict[str, Any]:
    """JSON schema of an entry.

    Args:
        offer: category, anchors and households.
        contexts: the contexts to choose from.
    """
    text, number = {"type": "string"}, {"type": "integer", "minimum": 1, "maximum": BOOK_LIMITS.placements[1]}
    told = {"anyOf": [{"type": "null"}, {"type": "string", "enum": list(contexts)}]} if contexts else {"type": "null"}
    names = {"type": "string", "enum": sorted(set(offer.anchors) - {offer.category})}
    relations = {"type": "string", "enum": list(RELATIONS)}
    placement = _object(relation=relations, anchor=names, context=told)
    habit = _object(text=text, supports={"type": "array", "items": number})
    return _object(
        household=text,
        placements=_array(placement, BOOK_LIMITS.placements),
        habits=_array(habit, BOOK_LIMITS.habits),
    )


def entry_json(entry: Entry) -> dict[str, Any]:
    """An entry as a model should give it, for examples in prompts."""
    return {
        "household": entry.household,
        "placements": [{"relation": p.relation, "anchor": p.anchor, "context": p.context} for p in entry.placements],
        "habits": [{"text": h.text, "supports": [i + 1 for i in h.supports]} for h in entry.habits],
    }


def read_entry(data: Mapping[str, Any], offer: Material, number: int) -> tuple[Entry | None, list[str]]:
    """Read the entry in a model's answer.

    Args:
        data: the JSON object.
        offer: what the entry may be made of.
        number: of the entry; its id is ``category/number``.

    Returns:
        The entry or None, and all faults.
    """
    faults: list[str] = []
    household = _text(data.get("household"), "household", faults)
    fault = header_fault(offer.category, household, offer.kind, None) if not faults else None
    if fault is None and household.casefold() in {known.casefold() for known in offer.households}:
        fault = "this household is described already; invent another"
    if fault:
        faults.append(f"household: {fault}")
    placements = _placements(data.get("placements"), offer, faults)
    habits = _habits(data.get("habits"), len(_list(data.get("placements"))), offer, faults)
    if fault := count_fault(len(_list(data.get("placements"))), len(_list(data.get("habits"))), BOOK_LIMITS):
        faults.append(f"the entry: {fault}")
    if faults:
        return None, faults
    entry = Entry(
        f"{offer.category}/{number}", offer.category, household, tuple(placements), tuple(habits), kind=offer.kind
    )
    long = [line_fault(line) for line in format_entries([entry]).split("\n")]
    faults += [f"the entry: {fault}" for fault in long if fault]
    return (None, faults) if faults else (entry, [])


def _placements(given: object, offer: Material, faults: list[str]) -> list[Placement]:
    out: list[Placement] = []
    for number, item in enumerate(_list(given), 1):
        where = f"placement {number}"
        if not isinstance(item, dict):
            faults.append(f"{where}: expected an object with relation, anchor and context")
            continue
        before = len(faults)
        relation = _text(item.get("relation"), f"{where}: relation", faults)
        anchor = _text(item.get("anchor"), f"{where}: anchor", faults)
        told = item.get("context")
        context = _text(told, f"{where}: context", faults) if told not in (None, "") else None
        if len(faults) > before:
            continue
        placement = Placement(cast(Relation, relation), anchor, context)
        fault = placement_fault(offer.category, out, placement, offer.anchors)
        if fault is None and context is not None and context not in offer.contexts:
            fault = f"context '{context[:60]}' is not in the list; take one of the list, or null"
        if fault:
            faults.append(f"{where}: {fault}")
        out.append(placement)
    return out


def _habits(given: object, n_placements: int, offer: Material, faults: list[str]) -> list[Habit]:
    out: list[Habit] = []
    said: set[str] = set()
    for number, item in enumerate(_list(given), 1):
        where = f"habit {number}"
        if not isinstance(item, dict):
            faults.append(f"{where}: expected an object with text and supports")
            continue
        before = len(faults)
        text = _text(item.get("text"), f"{where}: text", faults)
        numbers = item.get("supports")
        if not isinstance(numbers, list) or not all(type(n) is int for n in numbers):
            faults.append(f"{where}: supports: expected a list of numbers of placements")
        if len(faults) > before:
            continue
        supports = tuple(n - 1 for n in cast("list[int]", numbers))
        key = sentence_key(text)
        fault = habit_fault(text, supports, n_placements, BOOK_LIMITS)
        if fault is None and (key in said or key in offer.sentences):
            fault = "this sentence exists already; write another"
        said.add(key)
        if fault:
            faults.append(f"{where}: {fault}")
        out.append(Habit(text, supports))
    return out


def _text(value: object, where: str, faults: list[str]) -> str:
    """A text without surrounding spaces; anything else is a fault."""
    if not isinstance(value, str):
        faults.append(f"{where}: expected a text")
        return ""
    text = value.translate(_SPACES).strip(" ")
    if fault := line_fault(text):
        faults.append(f"{where}: {fault}")
    return text


def _list(value: object) -> list[Any]:
    return value if isinstance(value, list) else []


def _object(**properties: Any) -> dict[str, Any]:
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def _array(items: dict[str, Any], size: tuple[int, int]) -> dict[str, Any]:
    return {"type": "array", "items": items, "minItems": size[0], "maxItems": size[1]}
