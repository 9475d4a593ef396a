"""``python -m ucon info [EPISODE]``: the seven actions; of an episode, whose home it is and what is searched there."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ucon.habits.types import HabitDataset
    from ucon.task.episode import Episode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("episode", metavar="EPISODE", nargs="?", help="its name, or its number in the set")
    parser.add_argument("--episodes", metavar="SET", default="mini", help="its set or file (default mini)")
    parser.add_argument("--task", help="rules: paper, released_code (default: those of the episode, or paper)")
    parser.add_argument("--habits", metavar="PATH", help="its habit dataset by path; default: the book")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Print what is known."""
    from ucon.configuration.wiring import load_dataset
    from ucon.core.output import stdout_to_stderr
    from ucon.task.rules import PAPER, task_rules
    from ucon.task.sets import load_episodes

    told: dict[str, Any] = {}
    with stdout_to_stderr():
        rules = task_rules(args.task or PAPER.name)
        if args.episode is not None:
            episode = _chosen(args.episode, load_episodes(args.episodes, rules.name))
            rules = task_rules(args.task or episode.task)
            told = _episode(episode, load_dataset(args.habits))
    told |= {"task": rules.name, "steps": rules.max_steps, "actions": rules.actions()}
    if args.json:
        print(json.dumps(told, indent=1, ensure_ascii=False))
    else:
        _print(told)
    return 0


def _chosen(word: str, episodes: tuple[Episode, ...]) -> Episode:
    from ucon.commands.watch import number_of

    return episodes[number_of(word, [episode.id for episode in episodes])]


def _episode(episode: Episode, dataset: HabitDataset) -> dict[str, Any]:
    """The home, its people and the target; of people only where their habits are those of ``dataset``."""
    from ucon.sim.cache import load_house
    from ucon.task.spoken import target_place

    spec = load_house(episode.scene).spec
    told = {
        "episode": episode.id,
        "home": episode.scene,
        "kind": spec.kind,
        "rooms": [room.name for room in spec.rooms],
        "target": episode.target_category,
        "place": target_place(episode),
        "shortest_m": episode.shortest_path_m,
        "habits_of": episode.habits,
    }
    if episode.habits_hash != dataset.sha256:
        return told | {"household": None, "people": None, "habits": None}
    entries = [dataset.entries[dataset.entry_number[name]] for name in episode.entries]
    name, _ = episode.placed_by[episode.target]
    owner = dataset.entries[dataset.entry_number[name]] if name else None
    return told | {
        "household": owner and owner.household,
        "people": len({entry.household for entry in entries}),
        "habits": sum(len(entry.habits) for entry in entries),
    }


def _print(told: dict[str, Any]) -> None:
    if "episode" in told:
        target = told["target"].replace("_", " ")
        print(f"{told['episode']}: find the {target}; shortest path {told['shortest_m']:.2f} m")
        print(f"home: {told['home']} ({told['kind']}), rooms: {', '.join(told['rooms'])}")
        if told["people"] is None:
            print(f"whose: people of the habit dataset '{told['habits_of']}'; give it by --habits PATH")
        else:
            print(f"whose {target}: {told['household']}")
            print(f"{told['people']} households are told of in {told['habits']} habits")
        print(f"kept {told['place']} (what no agent is told)\n")
    print(f"task={told['task']}: at most {told['steps']} steps, each one of seven actions")
    for number, action in enumerate(told["actions"]):
        print(f"  {number}  {action['name']:<13} {action['effect']}")
