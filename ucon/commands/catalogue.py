"""``python -m ucon catalogue``: the names of the object catalogue, its JSON, or a labelled contact sheet."""

from __future__ import annotations

import argparse
import json
import textwrap
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from ucon.objects.model import Category

_WIDTH: Final = 80


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("word", metavar="WORD", nargs="?", help="only names, or groups, that contain this word")
    parser.add_argument("--category", action="append", metavar="NAME", help="only this category (may be repeated)")
    parser.add_argument("--sheet", type=Path, metavar="FILE.png", help="draw a labelled contact sheet into a picture")
    parser.add_argument("--json", action="store_true", help="print the categories as JSON")


def run(args: argparse.Namespace) -> int:
    """Print names and counts, or JSON, and draw the sheet if asked for.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: no such category, or none with the word.
    """
    from dataclasses import asdict

    from ucon.objects.catalogue import catalogue

    names = _chosen(args.category or (), args.word)
    rows = [catalogue()[name] for name in names]
    if args.sheet:
        from ucon.core.output import say_written
        from ucon.sim.sheets import catalogue_sheet

        catalogue_sheet(names, args.sheet)
        say_written(args.sheet, f"{len(names)} categories")
    if args.json:
        print(json.dumps([asdict(row) for row in rows], indent=1))
    else:
        print(*_names_by_group(rows), sep="\n")
        print(f"\n{len(rows)} categories, {len({row.archetype for row in rows})} archetypes")
        for title, count in (
            ("role", Counter(row.role for row in rows)),
            ("mount", Counter(row.mount for row in rows)),
            ("group", Counter(row.semantic_group for row in rows)),
        ):
            print(_wrapped(f"{title}: " + ", ".join(f"{name} {n}" for name, n in count.most_common())))
        print(
            f"openable: {sum(row.openable for row in rows)}, official targets: {sum(r.official_target for r in rows)}"
        )
    return 0


def _chosen(categories: Sequence[str], word: str | None) -> tuple[str, ...]:
    """Names to show, in alphabetical order, or in that of ``categories``.

    Args:
        categories: names to choose from; () for all.
        word: part of a name or of a group's name; None: all.

    Raises:
        ConfigError: no such category, or none with the word.
    """
    from ucon.core.errors import ConfigError
    from ucon.language.near_names import unknown_category
    from ucon.objects.catalogue import catalogue

    if odd := [name for name in categories if name not in catalogue()]:
        raise ConfigError(unknown_category("category", odd[0]))
    rows = [catalogue()[name] for name in categories or catalogue().names]
    if word is None:
        return tuple(row.name for row in rows)
    part = word.lower().replace(" ", "_")
    found = tuple(row.name for row in rows if part in row.name or part in row.semantic_group)
    if not found:
        raise ConfigError(unknown_category("category", part))
    return found


def _names_by_group(rows: Sequence[Category]) -> Iterator[str]:
    """Lines of at most 80 characters with the names of each group, the groups in alphabetical order."""
    groups = defaultdict(list)
    for row in rows:
        groups[row.semantic_group].append(row.name)
    for group, names in sorted(groups.items()):
        yield _wrapped(f"{group}: {', '.join(names)}")


def _wrapped(text: str) -> str:
    return textwrap.fill(text, _WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
