"""``python -m ucon demo``: one search without and with habits, and the sentence that makes the difference."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ucon.task.episode import Episode

#: Index in ``mini`` of an episode where habits help. Their average worth is in results/.
_EPISODE = 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("--agent", default="belief", help="agent that searches, a file in configs/agent/ (belief)")
    parser.add_argument("--out", type=Path, default=Path("runs/demo"), help="folder of the results (runs/demo)")
    parser.add_argument("--video", action=argparse.BooleanOptionalAction, default=True, help="film both searches")


def run(args: argparse.Namespace) -> int:
    """Play the episode at levels ``none`` and ``retrieval``, print both results, and film them.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.
    """
    from ucon.core.output import stdout_to_stderr
    from ucon.programs.two_searches import check_searches, print_searches, search_twice
    from ucon.task.sets import load_episodes, save_episodes

    episode = load_episodes("mini")[_EPISODE]
    file = args.out / "episode.jsonl.xz"
    words = (f"agent={args.agent}", f"episodes={file}")
    with stdout_to_stderr():
        check_searches(words, ("none", "retrieval"))
        args.out.mkdir(parents=True, exist_ok=True)
        save_episodes([episode], file)
        searches = search_twice(words, args.out, ("none", "retrieval"), films=args.video)
    print(_introduction(episode))
    print_searches(searches)
    print("\nThis episode was chosen to show the point. Averages are in results/README.md.")
    print('With your own object and habits: python -m ucon try --object mug --habit "..."')
    return 0


def _introduction(episode: Episode) -> str:
    """Lines about the episode: the target, its place, and the household's sentences that name it."""
    from ucon.habits import book
    from ucon.task.spoken import spoken_place

    entry_id, index = episode.placed_by[episode.target]
    entry = book().entries[book().entry_number[entry_id]]
    place = entry.placements[index]
    n = sum(len(book().entries[book().entry_number[name]].habits) for name in episode.entries)
    name = entry.category.replace("_", " ")
    said = "".join(f'  "{habit.text}"\n' for habit in entry.habits if index in habit.supports)
    what = f"One search: the {name} in {episode.scene}, kept {spoken_place(place.relation, place.anchor)}."
    return f"{what}\nOf {n} habits, these say where it is:\n{said}"
