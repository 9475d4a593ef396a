"""``python -m ucon watch RUN [EPISODE]``: lists a run's episodes, or films one and prints its decisions."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from ucon.configuration.kept_config import add_places, bad, configuration_of, places_in

if TYPE_CHECKING:
    from ucon.evaluation.kept.finished import FinishedRun
    from ucon.evaluation.kept.record import EpisodeRecord


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("run", metavar="RUN", type=Path, help="folder of eval.py, or of results/ with its episodes")
    parser.add_argument(
        "episode", metavar="EPISODE", nargs="?", help="its name or its number; without it all are listed"
    )
    parser.add_argument("--lost", action="store_true", help="list those alone that were not found")
    parser.add_argument(
        "--actions", action="store_true", help="film the recorded actions, without the agent and what it thinks"
    )
    parser.add_argument("--out", type=Path, default=Path("runs/watch"), help="folder of the film (runs/watch)")
    add_places(parser)


def run(args: argparse.Namespace) -> int:
    """List the episodes, or film the chosen one.

    Args:
        args: parsed options.

    Returns:
        Exit code 0, or 1 if the filmed episode differs from the stored one.

    Raises:
        DataError: the run stores no episodes.
        ConfigError: an unknown episode.
    """
    from ucon.core.errors import DataError
    from ucon.evaluation.kept.finished import FinishedRun

    kept = FinishedRun.read(args.run)
    if kept.records is None:
        raise DataError(f"{args.run}: it keeps figures alone and no episodes; evaluate again (python -m ucon replay)")
    if args.episode is None:
        _list(kept.records, lost=args.lost)
        return 0
    return _film(args, kept, number_of(args.episode, [r.episode for r in kept.records]))


def _list(records: Sequence[EpisodeRecord], *, lost: bool) -> None:
    shown = [(number, record) for number, record in enumerate(records) if not (lost and record.success)]
    print(f"{'number':>6}  {'episode':<34} {'target':<22} {'found':>5} {'steps':>5}  why not")
    for number, r in shown:
        why = "" if r.success else r.failure_cause.replace("_", " ")
        found = "yes" if r.success else "no"
        print(f"{number:>6}  {r.episode:<34} {r.target:<22} {found:>5} {r.steps:>5}  {why}".rstrip())
    print(f"{len(shown)} of {len(records)} episodes; give a number to film one")


def number_of(word: str, names: Sequence[str]) -> int:
    """Index of an episode, given by its number or name.

    Args:
        word: number or name.
        names: of all episodes.

    Raises:
        ConfigError: it is neither.
    """
    if word in names:
        return names.index(word)
    if word.isdecimal() and int(word) < len(names):
        return int(word)
    close = get_close_matches(word, names, n=1)
    hint = f"; did you mean {close[0]}?" if close else f" such as {names[0]}"
    raise bad("EPISODE", word, f"a number from 0 to {len(names) - 1}, or a name{hint}")


def _film(args: argparse.Namespace, kept: FinishedRun, number: int) -> int:
    from dataclasses import replace

    from ucon.configuration.stored import said_in
    from ucon.core.errors import DataError
    from ucon.core.output import stdout_to_stderr
    from ucon.evaluation.playing.runner import evaluate
    from ucon.programs.evaluating import Evaluation
    from ucon.task.spoken import target_place

    assert kept.records is not None
    record = kept.records[number]
    with stdout_to_stderr():
        config = configuration_of(args.run, places_in(args), said_in(args))
        if args.actions:  # the recorded actions need neither networks nor a language model
            config["agent"] = {"_target_": "ucon.evaluation.playing.recorded.RecordedAgent", "actions": record.actions}
        run = Evaluation(config, args.out / "run", anew=True)
        if [episode.id for episode in run.episodes] != [r.episode for r in kept.records]:
            raise DataError(f"{args.run}: other episodes are kept than its configuration names now")
        others = [k for k in range(len(kept.records)) if k != number]
        (played,) = evaluate(replace(run.spec, films=args.out), run.episodes, workers=0, skip=others)
    ending = "found" if record.success else f"not found ({record.failure_cause.replace('_', ' ')})"
    target, place = record.target.replace("_", " "), target_place(run.episodes[number])
    print(f"{record.episode}: {target} {place}, {ending} after {record.steps} steps")
    for decision in kept.decisions().get(record.episode) or played.decisions:
        print(f"  step {decision.step:>3}  {decision.words:<40} {decision.text}".rstrip())
    print("\n".join(str(path) for path in sorted(args.out.glob(f"{number:03d}_*"))))
    if (played.record.actions, played.record.spl) != (record.actions, record.spl):
        sys.stderr.write("warning: it came out otherwise than it was kept: another code, or an agent that draws\n")
        return 1
    return 0
