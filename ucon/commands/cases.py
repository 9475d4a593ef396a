"""``python -m ucon cases RETRIEVAL GT``: episodes where a habit about a thing beside the target was given.

The habits are read as the retrieval run read them: its folder names retriever and knowledge base.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from ucon.commands.home import case_figure


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    from ucon.configuration.stored import add_said

    case_figure.add_arguments(parser)
    parser.add_argument(
        "retrieval", nargs="?", metavar="RETRIEVAL", type=Path, help="run folder of an agent at level retrieval"
    )
    parser.add_argument("gt", nargs="?", metavar="GT", type=Path, help="run folder of the same agent at level gt")
    parser.add_argument("--episodes", help="set or file that both played (default: what the runs say)")
    parser.add_argument("--out", type=Path, metavar="FILE", help="keep these episodes, to play them again by path")
    add_said(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")


def run(args: argparse.Namespace) -> int:
    """Print the episodes with the landmark and its habit, or JSON lines.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: runs that differ in more than their habit level, or of the wrong levels.
        DataError: a run that cannot be read.
    """
    from ucon.configuration.stored import checked, said_in
    from ucon.configuration.wiring import Factory
    from ucon.core.errors import ConfigError
    from ucon.core.output import stdout_to_stderr
    from ucon.envs.own_home import episodes_of
    from ucon.evaluation.figures.landmark_cases import landmark_cases
    from ucon.evaluation.kept.finished import read_config
    from ucon.evaluation.kept.record import read_records
    from ucon.evaluation.kept.seal import CONFIG
    from ucon.task.sets import save_episodes
    from ucon.task.spoken import target_place

    if args.figure is not None:
        return case_figure.run(args)
    if args.gt is None:
        raise ConfigError("RETRIEVAL GT: expected the folders of two runs, or --figure")
    config, said, where = read_config(args.retrieval), said_in(args), str(args.retrieval / CONFIG)
    checked(config, where, (), said, "--set ")
    _require_one_setting(config, read_config(args.gt))
    with stdout_to_stderr():
        task = config["task"]
        episodes = episodes_of(args.episodes or config["episodes"], task["name"], context=task["context"])
        of_source = {"env": {"source": config["env"]["source"]}}
        source = Factory(checked(of_source, where, ("env",), said, "--set ")["env"]["source"])()
        source.prepare(level="retrieval")
        cases = list(landmark_cases(read_records(args.retrieval), read_records(args.gt), episodes, source))
        kept = {case.episode for case in cases}
        places = {episode.id: target_place(episode) for episode in episodes if episode.id in kept}
        if args.out is not None and cases:
            save_episodes([episode for episode in episodes if episode.id in kept], args.out)
    for case in cases:
        if args.json:
            print(json.dumps(case.to_json()))
        else:
            end = f"{case.steps_gt} steps" if case.success_gt else "not found"
            print(f"{case.episode} ({case.scene}): {case.target} {places[case.episode]}")
            print(f"  {case.landmark} {case.distance_m} m away")
            print(f"  habit {case.rank}: {case.habit}")
            print(f"  found in {case.steps} steps; with the target's own habits: {end}")
    if not args.json:
        kept_in = f", kept in {args.out}" if args.out is not None and cases else ""
        print(f"{len(cases)} cases{kept_in}")
    return 0


def _require_one_setting(retrieval: dict[str, Any], own: dict[str, Any]) -> None:
    """Refuse runs that differ in more than their habit level (the retriever may differ; level ``gt`` uses none).

    Otherwise a difference in results might not be due to the habits.
    """
    from ucon.core.errors import ConfigError
    from ucon.evaluation.kept.twins import without_level

    a, b = without_level(retrieval), without_level(own)
    different = sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))
    if different:
        raise ConfigError(
            f"the two runs differ in {', '.join(different)}; give two runs that differ in their habit level alone"
        )
