"""``python -m ucon info [EPISODE]``: the seven actions; for an episode also its home, household and target."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ucon.habits.types import HabitDataset
    from ucon.task.episode import Episode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("episode", metavar="EPISODE", nargs="?", help="its name or its number in the set")
    parser.add_argument("--episodes", metavar="SET", default="mini", help="its set or file (default mini)")
    parser.add_argument(
        "--task", help="rules: paper, released_code, real_robot (default: those of the episode, or paper)"
    )
    parser.add_argument("--habits", metavar="PATH", help="its habit dataset, by path (default: the book)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Print the information as text or JSON.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: an unknown episode, set or task.
    """
    from ucon.configuration.wiring import load_dataset
    from ucon.core.output import stdout_to_stderr
    from ucon.envs.own_home import episodes_of
    from ucon.task.rules import PAPER, task_rules

    facts: dict[str, Any] = {}
    with stdout_to_stderr():
        rules = task_rules(args.task or PAPER.name)
        if args.episode is not None:
            episode = _chosen(args.episode, episodes_of(args.episodes, rules.name))
            rules = task_rules(args.task or episode.task)
            facts = _episode(episode, load_dataset(args.habits))
    facts |= {"task": rules.name, "steps": rules.max_steps, "actions": rules.actions()}
    if args.json:
        print(json.dumps(facts, indent=1, ensure_ascii=False))
    else:
        _print(facts)
    return 0


def _chosen(word: str, episodes: tuple[Episode, ...]) -> Episode:
    from ucon.commands.watch import number_of

    return episodes[number_of(word, [episode.id for episode in episodes])]


def _episode(episode: Episode, dataset: HabitDataset) -> dict[str, Any]:
    """Home, household and target of an episode; the household only if its habits are those of ``dataset``."""
    from ucon.sim.cache import load_house
    from ucon.task.spoken import target_place

    spec = load_house(episode.scene).spec
    facts = {
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
        return facts | {"household": None, "people": None, "habits": None}
    entries = [dataset.entries[dataset.entry_number[name]] for name in episode.entries]
    name, _ = episode.placed_by[episode.target]
    owner = dataset.entries[dataset.entry_number[name]] if name else None
    return facts | {
        "household": owner and owner.household,
        "people": len({entry.household for entry in entries}),
        "habits": sum(len(entry.habits) for entry in entries),
    }


def _print(facts: dict[str, Any]) -> None:
    if "episode" in facts:
        target = facts["target"].replace("_", " ")
        print(f"{facts['episode']}: find the {target}; shortest path {facts['shortest_m']:.2f} m")
        print(f"home: {facts['home']} ({facts['kind']}), rooms: {', '.join(facts['rooms'])}")
        if facts["people"] is None:
            print(f"whose: people of the habit dataset '{facts['habits_of']}'; give it with --habits PATH")
        else:
            print(f"whose {target}: {facts['household']}")
            print(f"{facts['habits']} habits about {facts['people']} households")
        print(f"kept {facts['place']} (agents are not told this)\n")
    print(f"task={facts['task']}: at most {facts['steps']} steps, each one of seven actions")
    for number, action in enumerate(facts["actions"]):
        print(f"  {number}  {action['name']:<13} {action['effect']}")
