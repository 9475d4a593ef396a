"""``python -m ucon habits show CATEGORY|SCENE``: a category's entries, or the households of a home, for reading."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from ucon.habits import HabitDataset

_SHOWN_ABSENT = 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("name", metavar="CATEGORY|SCENE", help="a target category (mug), or a home (Rs_int, Rs_int~3)")
    parser.add_argument("--category", metavar="NAME", help="with a scene: show only this category, with its habits")
    parser.add_argument("--seed", type=int, default=0, help="with a scene: another seed, other residents (default 0)")
    parser.add_argument("--habits", metavar="PATH", help="dataset file, task file or book folder; default: the book")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Show what the name stands for, a category or a scene.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: an unknown name, or ``--category`` with a category.
    """
    from ucon.configuration.wiring import load_dataset
    from ucon.core.errors import ConfigError, unknown_name
    from ucon.core.output import stdout_to_stderr
    from ucon.scenes.library import SCENES, is_home_name

    with stdout_to_stderr():
        dataset = load_dataset(args.habits)
        is_scene = is_home_name(args.name)
        if not is_scene and args.name not in dataset.categories:
            raise ConfigError(unknown_name("category or scene", args.name, [*dataset.categories, *SCENES]))
        if args.category and not is_scene:
            raise ConfigError(f"--category {args.category}: '{args.name}' is a category already; name a scene")
        shown = _scene(args, dataset) if is_scene else _category(args.name, dataset)
    if args.json:
        print(json.dumps(shown, indent=1, ensure_ascii=False))
        return 0
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True)  # no line breaks, for grep and less
    if is_scene:
        _print_scene(console, shown, with_habits=bool(args.category))
    else:
        _print_category(console, shown)
    return 0


def _category(name: str, dataset: HabitDataset) -> dict[str, Any]:
    """All entries of a category."""
    from ucon.habits.splits import entry_parts

    parts = entry_parts(dataset)
    entries = [_entry(entry, dataset) | {"part": parts[entry.id]} for entry in dataset.entries_of(name)]
    return {"category": name, "dataset": dataset.name, "entries": entries}


def _entry(entry: Any, dataset: HabitDataset) -> dict[str, Any]:
    """An entry as plain values; ``supports`` counts placements from 1, as the book's files do; None without labels."""
    places = []
    for place in entry.placements:
        verdict = dataset.verdicts.of.get((entry.category, place.relation, place.anchor))
        refused = verdict.reason if verdict else None
        places.append(
            {"relation": place.relation, "anchor": place.anchor, "context": place.context, "implausible": refused}
        )
    habits = [
        {"text": habit.text, "supports": [i + 1 for i in habit.supports] if dataset.labelled else None}
        for habit in entry.habits
    ]
    return {
        "id": entry.id,
        "household": entry.household,
        "kind": entry.kind,
        "scene": entry.scene,
        "placements": places,
        "habits": habits,
    }


def _scene(args: argparse.Namespace, dataset: HabitDataset) -> dict[str, Any]:
    """Households of a home, what can be realised there, and why the rest cannot."""
    from ucon.core.errors import ConfigError, unknown_name
    from ucon.sim.cache import load_house
    from ucon.task.making.living import home_kinds
    from ucon.task.making.residents import IMPORTED, residents

    house = load_house(args.name)
    everybody = residents(house, dataset, args.seed)
    if args.category and args.category not in {one.category for one in everybody}:
        known = [one.category for one in everybody]
        raise ConfigError(unknown_name(f"category of the residents of {args.name}", args.category, known))
    rows = []
    for one in everybody:
        if args.category not in (None, one.category):
            continue
        entries = []
        for host in one.hosts:
            entry = _entry(host.entry, dataset) | {"hosted": host.ok}
            for i, place in enumerate(entry["placements"]):
                note = one.notes.get((host.entry.id, i))
                place["realisable"] = i in host.realisable
                place["imported"] = note == IMPORTED
                place["reason"] = None if i in host.realisable else note
            entries.append(entry)
        rows.append(
            {"category": one.category, "target": one.refusal is None, "reason": one.refusal, "entries": entries}
        )
    return {
        "scene": args.name,
        "kinds": list(home_kinds(house.spec)),
        "seed": args.seed,
        "dataset": dataset.name,
        "categories": rows,
    }


def _print_category(console: Console, shown: dict[str, Any]) -> None:
    from rich.text import Text

    entries = shown["entries"]
    console.print(Text(f"{shown['category']}: {len(entries)} entries ({shown['dataset']})", style="bold"))
    for entry in entries:
        bound = f" {{{entry['kind']}}}" if entry["kind"] else ""
        bound += f", in {entry['scene']}" if entry["scene"] else ""
        console.print()
        console.print(
            Text.assemble((entry["id"], "bold cyan"), f"  {entry['household']}{bound}", (f"  [{entry['part']}]", "dim"))
        )
        _print_entry(console, entry)


_COLORS = ("green", "yellow", "magenta", "blue", "red", "cyan")


def _print_entry(console: Console, entry: dict[str, Any], *, with_habits: bool = True) -> None:
    """Print placements with the numbers of the book's files, each in a colour that its habits share."""
    from rich.text import Text

    supports = [set(habit["supports"] or ()) for habit in entry["habits"]]
    for number, place in enumerate(entry["placements"], 1):
        line = Text(f"   @{number} {place['relation']} {place['anchor']}", style=_COLORS[(number - 1) % len(_COLORS)])
        if place["context"]:
            line.append(f" {{{place['context']}}}", "italic")
        if with_habits and entry["habits"][0]["supports"] is not None and not any(number in s for s in supports):
            line.append("  no habit points to it", "dim")
        if reason := place.get("reason") or place["implausible"]:
            line.append(f"  not here: {reason}" if "realisable" in place else f"  nowhere: {reason}", "bold red")
        elif place.get("imported"):
            line.append("  the anchor is brought in", "dim")
        console.print(line)
    for habit in entry["habits"] if with_habits else ():
        numbers = habit["supports"]
        mark = "?" if numbers is None else ",".join(map(str, numbers)) or "-"
        style = _COLORS[(numbers[0] - 1) % len(_COLORS)] if numbers else "dim"
        console.print(Text.assemble((f"   {mark:>3}: ", style), (habit["text"], "" if numbers else "dim")))


def _print_scene(console: Console, shown: dict[str, Any], *, with_habits: bool) -> None:
    from rich.text import Text

    rows = shown["categories"]
    for row in rows:
        line = Text(row["category"], style="bold" if row["target"] else "bold red")
        if row["reason"]:
            line.append(f"  never a target here: {row['reason']}", "red")
        console.print(line)
        for entry in row["entries"]:
            place = f"{sum(p['realisable'] for p in entry['placements'])} of {len(entry['placements'])}"
            style = "green" if entry["hosted"] else "red"
            who = (entry["household"], "cyan"), (f"  {entry['id']}", "dim")
            console.print(Text.assemble("  ", (f"{place} ", style), *who))
            _print_entry(console, entry, with_habits=with_habits)
    console.print()
    for sentence in _summary(shown):
        console.print(sentence)


def _summary(shown: dict[str, Any]) -> Sequence[str]:
    """Lines of counts, printed after a long listing."""
    rows = shown["categories"]
    entries = [entry for row in rows for entry in row["entries"]]
    places = [place for entry in entries for place in entry["placements"]]
    reasons = Counter(place["reason"] for place in places if place["reason"])
    absent = Counter(place["anchor"] for place in places if place["reason"] == "absent_anchor")
    kinds = f" ({', '.join(shown['kinds'])})" if shown["kinds"] else ""
    lines = [
        f"{shown['scene']}{kinds}, seed {shown['seed']}: {sum(row['target'] for row in rows)} of {len(rows)} "
        f"categories may be targets; {len(entries)} entries, {sum(entry['hosted'] for entry in entries)} hosted.",
        f"{sum(place['realisable'] for place in places)} of {len(places)} placements can be realised, "
        f"{sum(place['imported'] for place in places)} of them with an anchor that is brought in.",
    ]
    if reasons:
        lines.append("Not here: " + ", ".join(f"{reason} {count}" for reason, count in reasons.most_common()) + ".")
    if absent:
        lines.append("Absent anchors: " + ", ".join(f"{n} {c}" for n, c in absent.most_common(_SHOWN_ABSENT)) + ".")
    return lines
