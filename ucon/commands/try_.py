"""``python -m ucon try``: searches for an object with the user's own habits, without and with them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ucon.programs.two_searches import Search


#: Places that are read with less than this probability count as a guess.
_UNSURE = 0.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.description = (
        "Put an object where your habits (or --place) say, search for it without habits and with those retrieved from "
        "all habits of the home, and show both searches."
    )
    parser.add_argument("--scene", default="Rs_int", help="a home from `python -m ucon scenes` (Rs_int)")
    parser.add_argument("--object", required=True, help="object to search for, from `python -m ucon catalogue`")
    parser.add_argument(
        "--habit", action="append", required=True, metavar="SENTENCE", help="a habit of your household; may be repeated"
    )
    parser.add_argument(
        "--place",
        metavar="RELATION:ANCHOR",
        help="where it is kept, such as nextto:laptop (default: read from the habits)",
    )
    parser.add_argument("--agent", default="belief", help="agent that searches, a file in configs/agent/ (belief)")
    parser.add_argument(
        "--level", default="retrieval", help="habit level to compare with none: retrieval, full, gt, context"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the start and of where everything else is (0)")
    parser.add_argument("--out", type=Path, help="folder of the results (runs/try/SCENE_OBJECT)")
    parser.add_argument("--video", action=argparse.BooleanOptionalAction, default=True, help="film both searches")


def run(args: argparse.Namespace) -> int:
    """Place the object, search it at level ``none`` and another level, and print both results.

    Args:
        args: parsed options.

    Returns:
        Exit code 0; 2 if the request has faults, which are printed one per line.
    """
    from ucon.core.output import stdout_to_stderr
    from ucon.habits.datafile import save_dataset
    from ucon.programs.two_searches import check_searches, print_searches, search_twice
    from ucon.task.making.own_household import FaultsError, OwnPlacement, own_episode
    from ucon.task.sets import save_episodes
    from ucon.task.spoken import spoken_place

    try:
        wish = OwnPlacement.of(args.scene, args.object, args.habit, args.place)
    except FaultsError as error:
        sys.stderr.write("".join(f"error: {fault}\n" for fault in error.faults))
        return 2
    out = args.out or Path("runs/try") / f"{args.scene.replace(':', '-')}_{args.object}"
    habits, episodes = out / "own.habits.xz", out / "own.jsonl.xz"
    words = (f"agent={args.agent}", "habits=folder", f"habits.path={habits}", f"episodes={episodes}")
    levels = ("none", args.level)
    with stdout_to_stderr():
        check_searches(words, levels)
        episode, dataset, place, chance = own_episode(wish, _read, args.seed)
        out.mkdir(parents=True, exist_ok=True)
        save_dataset(dataset, habits)
        save_episodes([episode], episodes)
        searches = search_twice(words, out, levels, films=args.video)
    read = "" if wish.place else f", as read from your habits ({100 * chance:.0f} %; --place overrides it)"
    name = args.object.replace("_", " ")
    n_habits = sum(len(dataset.entries[dataset.entry_number[entry]].habits) for entry in episode.entries)
    print(f"{name} in {args.scene}: kept {spoken_place(place.relation, place.anchor)}{read}")
    if not wish.place and chance < _UNSURE:
        print(
            "warning: your sentences hardly say where it is; give --place, such as --place nextto:laptop",
            file=sys.stderr,
        )
    others = n_habits - len(args.habit)
    print(f"{len(args.habit)} of your sentences among {others} about other things and people of this home")
    for line in _given_lines(args.habit, searches[-1]):
        print(line)
    print()
    print_searches(searches)
    print(f"\nOne search proves little; another --seed changes the start and everything else. All files: {out}")
    return 0


def _given_lines(habits: Sequence[str], search: Search) -> Iterator[str]:
    """Lines that say which of the user's sentences the agent was given, and at which rank."""
    from ucon.retrieval.levels import RANKED_LEVELS

    level, given = search.record.habit_level, search.given
    if given is None:
        yield f"agent {search.record.agent} reads no habits"
        return
    retrieved = level in RANKED_LEVELS
    for text in habits:
        if text not in given:
            said = f"not among the {len(given)} retrieved" if retrieved else f"not given at level {level}"
        elif retrieved:
            said = f"number {given.index(text) + 1} of {len(given)} retrieved"
        else:
            said = f"one of {len(given)} given"
        yield f'  {said}: "{text}"'


def _read(target: str, habits: Sequence[str]) -> tuple[Sequence[str], NDArray[np.float64]]:
    from ucon.perception.belief.from_habits import ReadHabits

    found = ReadHabits()({"target": target, "habits": tuple(habits), "habit_level": "gt"})
    return found.names, found.p
