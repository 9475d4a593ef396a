"""Searches one episode at two habit levels, with films and a table; used by ``try`` and ``demo``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from ucon.evaluation.kept.record import EpisodeRecord


class Search(NamedTuple):
    """A run of one episode."""

    folder: Path
    record: EpisodeRecord
    given: tuple[str, ...] | None
    """Habits that the agent was given at the start, in order; None for an agent that reads none."""
    lost: str
    """Why the target was not found; "" where it was."""


def search_twice(words: Sequence[str], out: Path, levels: Sequence[str], *, films: bool) -> list[Search]:
    """Play one episode as ``eval.py WORDS`` would, once at each level.

    What an earlier call left in ``out`` is not changed; the new run goes into a folder next to it.

    Args:
        words: options of ``eval.py``.
        out: folder of the runs.
        levels: habit levels.
        films: whether to make videos.

    Raises:
        ConfigError: not in a clone, or a wrong option.
    """
    from ucon.evaluation.kept.endings import why_lost
    from ucon.evaluation.kept.finished import FinishedRun
    from ucon.programs.composing import eval_config
    from ucon.programs.evaluating import Evaluation

    fixed = ("workers=0", "progress=false", f"pictures={int(films)}")
    configs = {level: eval_config(*words, *fixed, f"habit_level={level}", f"out={out / level}") for level in levels}
    found = []
    for level, config in configs.items():
        run = Evaluation(config, out / level, anew=True)
        run.play()
        kept = FinishedRun.read(run.out)
        assert kept.records is not None, "a run just played keeps its records"
        record = kept.records[0]
        lost = why_lost(record, kept.decisions().get(record.episode, ()))
        found.append(Search(run.out, record, run.given(run.episodes[0]), lost))
    return found


def check_searches(words: Sequence[str], levels: Sequence[str]) -> None:
    """Check options and weights of what :func:`search_twice` would play, but not its episodes and habits.

    Nothing is written.

    Args:
        words: options of ``eval.py``.
        levels: habit levels.

    Raises:
        ConfigError: not in a clone, or a wrong option.
        DataError: weights are missing.
    """
    from ucon.configuration.wiring import Factory
    from ucon.evaluation.playing.needed_weights import check_weights
    from ucon.programs.composing import eval_config

    for config in [eval_config(*words, f"habit_level={level}") for level in levels]:
        check_weights(Factory(config["agent"])(), Factory(config["env"]["detector"])())


def print_searches(searches: Sequence[Search]) -> None:
    """Print a table of the searches, why some were lost, and the paths of the films."""
    print(f"{'habits':<12}{'found':>6}{'steps':>8}{'metres':>9}{'shortest':>10}")
    for record in (search.record for search in searches):
        print(
            f"{record.habit_level:<12}{'yes' if record.success else 'no':>6}{record.steps:>8}"
            f"{record.path_length_m:>9.2f}{record.shortest_path_m:>10.2f}"
        )
    print("".join(f"{search.record.habit_level}: {search.lost}\n" for search in searches if search.lost), end="")
    films = [film for search in searches for film in sorted((search.folder / "pictures").glob("*.webm"))]
    print("".join(f"film: {film}\n" for film in films), end="")
