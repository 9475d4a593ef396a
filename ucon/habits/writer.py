"""Writes entries in the habit book's format; :func:`ucon.habits.book.parse_book` reads the same entries back."""

from __future__ import annotations

from collections.abc import Iterable

from ucon.core.errors import DataError
from ucon.habits.types import Entry


def format_entries(entries: Iterable[Entry]) -> str:
    """Entries as text, with a blank line between two of them.

    Ids are not written; the parser counts again.

    Raises:
        DataError: an entry is bound to a scene, which the format cannot express.
    """
    return "\n".join(_entry_text(entry) for entry in entries)


def _entry_text(entry: Entry) -> str:
    if entry.scene is not None:
        raise DataError(
            f"entry '{entry.id}' is bound to scene '{entry.scene}', which the book's format cannot say; "
            "save it in a dataset file (*.habits.xz)"
        )
    lines = [f"# {entry.category} | {entry.household}" + _braced(entry.kind)]
    lines += [f"@ {p.relation} {p.anchor}" + _braced(p.context) for p in entry.placements]
    lines += [f"{','.join(str(i + 1) for i in h.supports) or '-'}: {h.text}" for h in entry.habits]
    return "\n".join(lines) + "\n"


def _braced(text: str | None) -> str:
    return "" if text is None else f" {{{text}}}"
