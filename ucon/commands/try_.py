"""``python -m ucon try``: one's own habits, searched without and with them."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from ucon.evaluation.record import EpisodeRecord
    from ucon.habits.types import Placement
    from ucon.task.episode import Episode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.description = (
        "Put an object where your habits say (or --place), search it without habits and with those that are "
        "retrieved among the whole household's, and show both."
    )
    parser.add_argument("--scene", default="Rs_int", help="a home of `python -m ucon scenes` (Rs_int)")
    parser.add_argument("--object", required=True, help="what is searched, of `python -m ucon catalogue`")
    parser.add_argument(
        "--habit", action="append", required=True, metavar="SENTENCE", help="what your people do; repeat it"
    )
    parser.add_argument(
        "--place", metavar="RELATION:ANCHOR", help="where it is kept, as nextto:laptop; default: as the habits are read"
    )
    parser.add_argument("--agent", default="belief", help="who searches, a file of configs/agent/ (belief)")
    parser.add_argument("--level", default="retrieval", help="habit level beside none: retrieval, full, gt, context")
    parser.add_argument("--seed", type=int, default=0, help="of where everything else is and where it starts (0)")
    parser.add_argument("--out", type=Path, help="folder of the results (runs/try/SCENE_OBJECT)")
    parser.add_argument("--video", action=argparse.BooleanOptionalAction, default=True, help="film both searches")


def run(args: argparse.Namespace) -> int:
    """Place, play twice, tell."""
    from ucon.commands.output import stdout_to_stderr
    from ucon.task.own import FaultsError, Wish, own_episode

    try:
        wish = Wish.of(args.scene, args.object, args.habit, args.place)
    except FaultsError as error:
        sys.stderr.write("".join(f"error: {fault}\n" for fault in error.faults))
        return 2
    out = args.out or Path("runs/try") / f"{args.scene.replace(':', '-')}_{args.object}"
    with stdout_to_stderr():
        episode, dataset, place, chance = own_episode(wish, _read, args.seed)
        runs = _save_and_play(args, out, episode, dataset)
    _tell(args, episode, place, chance if wish.place is None else None, runs, out)
    return 0


def _read(target: str, habits: Sequence[str]) -> tuple[Sequence[str], NDArray[np.float64]]:
    from ucon.perception.reading import ReadHabits

    found = ReadHabits()({"target": target, "habits": tuple(habits), "habit_level": "gt"})
    return found.names, found.p


def _save_and_play(args: argparse.Namespace, out: Path, episode: Episode, dataset: Any) -> dict[str, EpisodeRecord]:
    """The records of both searches, by level; what is played again is what ``eval.py`` would play."""
    from ucon.commands.evaluating import Evaluation
    from ucon.evaluation.finished import FinishedRun
    from ucon.habits.datafile import save_dataset
    from ucon.task.sets import save_episodes

    out.mkdir(parents=True, exist_ok=True)
    habits, episodes = out / "own.habits.xz", out / "own.jsonl.xz"
    save_dataset(dataset, habits)
    save_episodes([episode], episodes)
    records = {}
    for level in ("none", args.level):
        config = _config(
            f"agent={args.agent}", f"habit_level={level}", "habits=folder", f"habits.path={habits}",
            f"episodes={episodes}", f"out={out / level}", "workers=0", "progress=false", f"pictures={int(args.video)}",
        )  # fmt: skip
        played = Evaluation(config, out / level, anew=True)
        played.play()
        found = FinishedRun.read(played.out).records
        assert found is not None
        records[str(played.out)] = found[0]
    return records


def _config(*words: str) -> dict[str, Any]:
    from hydra import compose, initialize_config_dir
    from omegaconf import OmegaConf

    import ucon
    from ucon.core.errors import ConfigError

    configs = Path(ucon.__file__).parents[1] / "configs"
    if not configs.is_dir():
        raise ConfigError(f"{configs}: no such folder; agents are in the clone, not in the package: run it there")
    with initialize_config_dir(str(configs), version_base="1.3"):
        return OmegaConf.to_container(compose("eval", overrides=list(words)), resolve=True)  # type: ignore[return-value]


def _tell(
    args: argparse.Namespace,
    episode: Episode,
    place: Placement,
    chance: float | None,
    runs: dict[str, EpisodeRecord],
    out: Path,
) -> None:
    name = args.object.replace("_", " ")
    read = "" if chance is None else f", as your habits are read ({100 * chance:.0f} %; --place says otherwise)"
    print(f"{name} in {args.scene}: kept {place.relation} {place.anchor.replace('_', ' ')}{read}")
    others = len(episode.entries) - 1
    print(f"your {_count(len(args.habit), 'habit')} among those of {_count(others, 'other household entry')}\n")
    print(f"{'habits':<12}{'found':>6}{'steps':>8}{'metres':>9}{'shortest':>10}")
    for record in runs.values():
        print(
            f"{record.habit_level:<12}{'yes' if record.success else 'no':>6}{record.steps:>8}"
            f"{record.path_length_m:>9.2f}{record.shortest_path_m:>10.2f}"
        )
    films = [film for folder in runs for film in sorted(Path(folder, "pictures").glob("*.webm"))]
    print("\nOne search says little: another --seed starts elsewhere, among other things.")
    print("\n".join(map(str, films or [out])))


def _count(n: int, what: str) -> str:
    return f"1 {what}" if n == 1 else f"{n} {what[:-1]}ies" if what.endswith("y") else f"{n} {what}s"
