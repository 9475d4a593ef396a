"""Step 1 of the pipeline: a language model proposes entries for new categories and households.

Answers are checked by the rules of the habit book (:mod:`ucon.generation.proposal`). The model is told all faults and
may correct them a few times; entries that stay wrong are reported and left out. The result is a text file in the book's
format, which a person can read and edit. Entries already in the file are kept, so an interrupted run is continued.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from string import Template
from typing import Final

from ucon.core.errors import AnswerError, ConfigError, unknown_name
from ucon.core.files import write_atomic
from ucon.core.rng import derived_seed, stream
from ucon.generation.proposal import Material, entry_json, entry_schema, read_entry, sentence_key
from ucon.habits.book import book, book_anchors, parse_book
from ucon.habits.contexts import context_table
from ucon.habits.rules import Anchors
from ucon.habits.splits import entry_parts
from ucon.habits.types import HOUSEHOLD_KINDS, Entry, HabitDataset
from ucon.habits.writer import format_entries
from ucon.language.servers.chat import ChatClient, Usage
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS

PROMPTS: Final = Path(__file__).parent / "prompts"
ROUNDS: Final = 3
N_EXAMPLES: Final = 2
N_CONTEXTS: Final = 48
_MOST_COMPLAINTS: Final = 20
_MOST_HOUSEHOLDS: Final = 40

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class EntryWish:
    """A number of entries of one category, in homes or in one kind of home.

    Attributes:
        category: of the entries.
        count: number in all, existing ones included.
        kind: of :data:`ucon.habits.types.HOUSEHOLD_KINDS`; None: homes.
    """

    category: str
    count: int = 1
    kind: str | None = None


@dataclass(frozen=True, slots=True)
class LeftOut:
    """An entry that could not be obtained, and the last faults."""

    category: str
    kind: str | None
    complaints: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Proposed:
    """The result of a run: entries of the file, the number of new ones, those left out, and the cost."""

    entries: tuple[Entry, ...]
    new: int
    left_out: tuple[LeftOut, ...]
    usage: Usage


def propose(
    client: ChatClient,
    wishes: Sequence[EntryWish],
    out: Path,
    *,
    known: HabitDataset | None = None,
    anchors: Anchors | None = None,
    categories: Collection[str] | None = None,
    rounds: int = ROUNDS,
    seed: int = 0,
    progress: Progress | None = None,
) -> Proposed:
    """Ask for the entries that a file lacks and write them to it, one by one.

    Args:
        client: the model.
        wishes: how many entries of which categories the file should have.
        out: text file in the book's format; completed where it exists.
        known: existing entries, for examples and so that sentences are not repeated; by default the book.
        anchors: anchors with their relations; by default the book's.
        categories: categories that exist; by default the catalogue's.
        rounds: most answers for one entry.
        seed: another seed gives other entries.
        progress: called with (entries tried or present, entries wanted).

    Raises:
        ConfigError: an unknown category or kind of home, or a count or number of rounds below 1.
        DataError: ``out`` exists and is malformed; names file and line.
        ServerError: the server cannot be reached or refuses; entries proposed before are in ``out``.
    """
    names = catalogue().names if categories is None else categories
    _check(wishes, names, rounds)
    allowed = book_anchors() if anchors is None else anchors
    entries = parse_book(out, allowed, names) if out.is_file() else []
    asker = _Asker(client, book() if known is None else known, allowed, rounds, seed)
    there = len(entries)
    left_out: list[LeftOut] = []
    total, done = sum(wish.count for wish in wishes), 0
    for wish in wishes:
        have = sum((e.category, e.kind) == (wish.category, wish.kind) for e in entries)
        for number in range(wish.count):
            if number >= have:
                entry, complaints = asker.entry(wish, number, entries)
                if entry is None:
                    left_out.append(LeftOut(wish.category, wish.kind, tuple(complaints)))
                else:
                    entries.append(entry)
                    write_atomic(out, format_entries(entries))
            done += 1
            if progress:
                progress(done, total)
    return Proposed(tuple(entries), len(entries) - there, tuple(left_out), client.usage)


class _Asker:
    """Asks for one entry at a time."""

    def __init__(self, client: ChatClient, known: HabitDataset, anchors: Anchors, rounds: int, seed: int) -> None:
        self._client = client
        self._known = known
        self._anchors = anchors
        self._rounds = rounds
        self._seed = seed
        self._sentences = frozenset(map(sentence_key, known.texts))
        told = Counter(p.context for e in known.entries for p in e.placements if p.context in context_table())
        self._contexts = sorted(sorted(filter(None, told)), key=lambda text: -told[text])[:N_CONTEXTS]

    def entry(self, wish: EntryWish, number: int, there: Sequence[Entry]) -> tuple[Entry | None, list[str]]:
        """Ask for one entry.

        Returns:
            The entry or None, and the faults of the last answer.
        """
        offer = self._offer(wish, there)
        schema = entry_schema(offer, self._contexts)
        messages = [_message("system", _prompt("entry_system").template.strip()), self._ask(offer, number)]
        seed = derived_seed(self._seed, "propose", wish.category, wish.kind or "", number)
        complaints: list[str] = []
        for _ in range(self._rounds):
            try:
                reply = self._client.ask(messages, schema=schema, seed=seed)
            except AnswerError as error:
                return None, [*complaints, str(error)]
            entry, complaints = read_entry(reply.data or {}, offer, sum(e.category == wish.category for e in there))
            if entry is not None:
                return entry, []
            told = "\n".join(f"- {complaint}" for complaint in complaints[:_MOST_COMPLAINTS])
            again = _message("user", _prompt("entry_again").substitute(complaints=told))
            messages = [*messages[:2], _message("assistant", reply.text), again]
        return None, complaints

    def _offer(self, wish: EntryWish, there: Sequence[Entry]) -> Material:
        same = [e.household for e in (*self._known.entries, *there) if e.category == wish.category]
        new = frozenset(sentence_key(h.text) for e in there for h in e.habits)
        return Material(
            wish.category, wish.kind, self._usual(wish.kind), context_table(), self._sentences | new, frozenset(same)
        )

    def _usual(self, kind: str | None) -> Anchors:
        """Anchors that known entries of this kind of home use: shops have checkout counters, homes do not."""
        used = {p.anchor for e in self._known.entries if e.kind in (None, kind) for p in e.placements}
        return {name: relations for name, relations in self._anchors.items() if name in used} or self._anchors

    def _ask(self, offer: Material, number: int) -> dict[str, str]:
        anchors = [
            f"{anchor}: {' '.join(r for r in RELATIONS if r in allowed)}"
            for anchor, allowed in sorted(offer.anchors.items())
            if anchor != offer.category
        ]
        examples = [
            f"An example, an entry about {_words(entry.category)}:\n{json.dumps(entry_json(entry), ensure_ascii=False)}"
            for entry in self._examples(offer, number)
        ]
        others = [f"- {household}" for household in sorted(offer.households)[:_MOST_HOUSEHOLDS]]
        told = _prompt("entry_ask").substitute(
            category=_words(offer.category),
            people=f"people of a {offer.kind}" if offer.kind else "people at home",
            anchors="\n".join(anchors),
            contexts="\n".join(self._contexts) or "(none: every context is null)",
            examples="\n\n".join(examples) or "(no examples)",
            households="\n".join(others) or "(none)",
        )
        return _message("user", told)

    def _examples(self, offer: Material, number: int) -> list[Entry]:
        """Entries of other categories from the training part, so that no test sentence is shown to a model."""
        if not self._known.labelled:
            return []
        parts = entry_parts(self._known)
        fit = [
            entry
            for entry in self._known.entries
            if parts[entry.id] == "train" and entry.kind == offer.kind and entry.category != offer.category
        ]
        rng = stream(self._seed, "propose", "examples", offer.category, offer.kind or "", number)
        return [fit[int(i)] for i in rng.permutation(len(fit))[:N_EXAMPLES]]


def _check(wishes: Sequence[EntryWish], categories: Collection[str], rounds: int) -> None:
    for wish in wishes:
        if wish.category not in categories:
            raise ConfigError(unknown_name("category", wish.category, categories))
        if wish.kind is not None and wish.kind not in HOUSEHOLD_KINDS:
            raise ConfigError(unknown_name("kind of place", wish.kind, HOUSEHOLD_KINDS))
        if wish.count < 1:
            raise ConfigError(f"{wish.count} entries of '{wish.category}' requested, expected at least 1")
    twice = [key for key, n in Counter((wish.category, wish.kind) for wish in wishes).items() if n > 1]
    if twice:
        raise ConfigError(f"entries of '{twice[0][0]}' are requested twice; give one count")
    if rounds < 1:
        raise ConfigError(f"rounds={rounds}, expected at least 1")


def _words(category: str) -> str:
    return category.replace("_", " ")


def _message(role: str, content: str) -> dict[str, str]:
    return {"role": role, "content": content}


@cache
def _prompt(name: str) -> Template:
    return Template((PROMPTS / f"{name}.txt").read_text(encoding="utf-8"))
