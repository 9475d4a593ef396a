"""``python -m ucon watch RUN [EPISODE]``: lists a run's episodes, or films one and prints its decisions."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ucon.configuration.kept_config import add_places, bad, configuration_of, places_in

if TYPE_CHECKING:
    from ucon.evaluation.kept.decisions import DecisionRecord
    from ucon.evaluation.kept.finished import FinishedRun
    from ucon.evaluation.kept.record import EpisodeRecord
    from ucon.programs.evaluating import Evaluation

#: Largest number of habits that are printed.
_MOST_HABITS: Final = 5
#: What a computed choice promises, in the text of its decision.
_PROMISE: Final = re.compile(r"worth (\S+), (.+? away), score ([^\s,]+)")
_LEGEND: Final = (
    "worth: the agent's estimate of how likely a view shows the target; score: worth over its cost; the highest is\n"
    "chosen; belief: how likely the target is at that place"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument(
        "run", metavar="RUN", type=Path, help="run folder of eval.py, or of results/ if it has its episodes"
    )
    parser.add_argument("episode", metavar="EPISODE", nargs="?", help="its name or its number (default: list all)")
    parser.add_argument("--lost", action="store_true", help="list only the failed episodes")
    parser.add_argument(
        "--actions", action="store_true", help="film the recorded actions only, without running the agent"
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
    from ucon.evaluation.kept.finished import FinishedRun, figures_only

    kept = FinishedRun.read(args.run)
    if kept.records is None:
        raise figures_only([args.run])
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
    from ucon.evaluation.figures.report import episodes_hash
    from ucon.evaluation.kept.endings import why_lost
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
        if episodes_hash(run.episodes) != kept.summary["hashes"].get("episodes"):
            raise DataError(f"{args.run}: its configuration now names other episodes than those played; evaluate again")
        others = [k for k in range(len(kept.records)) if k != number]
        (played,) = evaluate(replace(run.spec, films=args.out), run.episodes, workers=0, skip=others)
        habits = [*_habit_lines(run, config["agent"], number, reads=kept.summary.get("uses_habits", True))]
    ending = "found" if record.success else f"not found ({record.failure_cause.replace('_', ' ')})"
    made = kept.decisions().get(record.episode) or played.decisions
    target, place = record.target.replace("_", " "), target_place(run.episodes[number])
    print(f"{record.episode}: {target} {place}, {ending} after {record.steps} steps")
    print(*habits, sep="\n")
    for line in _decision_lines(made):
        print(line)
    if lost := why_lost(record, made):
        print(f"not found: {lost}")
    print("\n".join(str(path) for path in sorted(args.out.glob(f"{number:03d}_*"))))
    if (played.record.actions, played.record.spl) != (record.actions, record.spl):
        sys.stderr.write("warning: this search differs from the recorded one: other code, or an agent that samples\n")
        return 1
    return 0


def _decision_lines(made: Sequence[DecisionRecord]) -> Iterator[str]:
    """Lines of an episode's decisions, after a legend of their numbers where they have any."""
    texts = [d.text if d.asked else _evenly(d.text) for d in made]
    if any(not d.asked and _PROMISE.search(d.text) for d in made):
        yield _LEGEND
    for decision, text in zip(made, texts, strict=True):
        yield f"  step {decision.step:>3}  {decision.words:<40} {text}".rstrip()


def _evenly(text: str) -> str:
    """The text of a computed choice, with four decimals in its worth and its score."""

    def four_digits(found: re.Match[str]) -> str:
        worth, away, score = found.groups()
        return f"worth {float(worth):.4f}, {away}, score {float(score):.4f}"

    return _PROMISE.sub(four_digits, text)


def _habit_lines(run: Evaluation, agent: Any, number: int, *, reads: bool) -> Iterator[str]:
    """Lines with habits that the agent was given at the start: those from which it reads most, or the first ones.

    Args:
        run: the run.
        agent: configuration of the agent.
        number: of the episode.
        reads: whether the agent that was played reads habits.
    """
    from ucon.configuration.wiring import Factory
    from ucon.retrieval.levels import RANKED_LEVELS

    episode = run.episodes[number]
    given = run.given(episode) if reads else None
    if not given:
        yield "habits: the agent reads none" if given is None else f"habits: none at level {run.level}"
        return
    info = {"target": episode.target_category, "habits": given, "habit_level": run.level}
    locate = getattr(Factory(agent)(), "locate", None)
    relevance = None if locate is None else locate(info).relevance
    says = [0.0] * len(given) if relevance is None else [float(share) for share in relevance]
    shown = sorted(range(len(given)), key=lambda k: -says[k])[:_MOST_HABITS]
    known = "those the agent reads most from, and how much each says about the place"
    order = "the first" if relevance is None else known
    yield f"habits: {len(given)} {'retrieved' if run.level in RANKED_LEVELS else 'given'}; {order}:"
    for k in shown:
        share = "" if relevance is None else f"{says[k]:>4.0%}  "
        yield f'  number {k + 1:>3}  {share}"{given[k]}"'
