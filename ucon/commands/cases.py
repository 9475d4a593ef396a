"""``python -m ucon cases RETRIEVAL GT``: episodes in which a habit about something else led to the target."""

from __future__ import annotations

import argparse
import json
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("retrieval", metavar="RETRIEVAL", type=Path, help="run folder of an agent at level retrieval")
    parser.add_argument("gt", metavar="GT", type=Path, help="run folder of the same agent at level gt")
    parser.add_argument("--episodes", default="test", help="set or file that both played (default: test)")
    parser.add_argument("--habits", metavar="PATH", help="habit dataset by path; default: the embedded book")
    parser.add_argument("--out", type=Path, metavar="FILE", help="keep these episodes, to play them again by path")
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")


def run(args: argparse.Namespace) -> int:
    """Print the cases."""
    from ucon.commands.output import stdout_to_stderr
    from ucon.commands.wiring import load_dataset
    from ucon.envs.knowledge import HabitSource
    from ucon.evaluation.cases import landmark_cases
    from ucon.evaluation.record import read_records
    from ucon.task.sets import load_episodes, save_episodes

    with stdout_to_stderr():
        episodes = load_episodes(args.episodes)
        source = HabitSource(load_dataset(args.habits))
        cases = list(landmark_cases(read_records(args.retrieval), read_records(args.gt), episodes, source))
        if args.out is not None and cases:
            kept = {case.episode for case in cases}
            save_episodes([episode for episode in episodes if episode.id in kept], args.out)
    for case in cases:
        if args.json:
            print(json.dumps(case.to_json()))
        else:
            end = f"{case.steps_gt} steps" if case.success_gt else "not found"
            print(f"{case.episode} ({case.scene}): {case.target} by {case.landmark}, {case.distance_m} m apart")
            print(f"  habit {case.rank}: {case.habit}")
            print(f"  found in {case.steps} steps; with the target's own habits: {end}")
    if not args.json:
        kept_in = f", kept in {args.out}" if args.out is not None and cases else ""
        print(f"{len(cases)} cases{kept_in}")
    return 0
