"""Sweeps (``eval.py -m``): the folders of their runs, and what is printed at the end."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from itertools import permutations
from pathlib import Path
from typing import Any, Final

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.experimental.callback import Callback
from omegaconf import DictConfig, OmegaConf

from ucon.core.files import sha256_bytes

#: Prefix of the set's name in the names of folders.
_SET: Final = "episodes-"
#: Endings of episode files, which the names of folders leave out.
_ENDINGS: Final = (".jsonl.xz", ".jsonl", ".yaml", ".yml")


def folder_of(hydra_config: Any, episodes: str) -> Path:
    """Folder of one run of a sweep, named by its overrides, and also by its set if the sweep plays several.

    Args:
        hydra_config: of the run.
        episodes: its set, or file of episodes.
    """
    folder, sweep = (
        Path(hydra_config.runtime.cwd, path) for path in (hydra_config.runtime.output_dir, hydra_config.sweep.dir)
    )
    if not _sweeps_over_sets(sweep / "multirun.yaml"):
        return folder
    name = _SET + folder_name(episodes)
    return sweep / name if folder == sweep else folder.with_name(f"{folder.name}+{name}")


def _sweeps_over_sets(asked: Path) -> bool:
    """Whether a sweep, by the file in which Hydra keeps its overrides, plays more than one set of episodes."""
    words = OmegaConf.load(asked).hydra.overrides.task if asked.is_file() else ()
    over = OverridesParser.create().parse_overrides(list(words))
    return any(one.key_or_group == "episodes" and one.is_sweep_override() for one in over)


def folder_name(episodes: str) -> str:
    """Name of a set, or of a file with a hash of its path, since files in different folders may share a name."""
    ending = next(filter(episodes.endswith, _ENDINGS), "")
    if not ending:
        return episodes
    return f"{Path(episodes).name.removesuffix(ending)}-{sha256_bytes(episodes.encode())[:6]}"


class CompareAtEnd(Callback):
    """Prints a table of all runs and their paired differences after a sweep, and removes empty folders."""

    def on_multirun_end(self, config: DictConfig, **kwargs: Any) -> None:
        """Print the tables of the sweep's folder. Called by Hydra.

        Args:
            config: of the sweep.
            kwargs: unused.
        """
        folder = Path(config.hydra.sweep.dir)
        for path in filter(Path.is_dir, folder.glob("*")):  # Hydra makes one for each run, by its overrides alone
            with suppress(OSError):
                path.rmdir()
        print_sweep(folder)


def print_sweep(folder: Path) -> None:
    """Print the tables of all finished runs of a sweep, for each set of episodes that it played.

    Args:
        folder: of the sweep; its subfolders are runs.
    """
    from ucon.evaluation.kept.seal import SUMMARY

    paths = sorted(p.parent for p in folder.glob(f"*/{SUMMARY}"))
    if len(paths) < 2:
        return
    for played in sorted({_set_of(path) for path in paths}):
        _print_set(
            [path for path in paths if _set_of(path) == played], f"{folder}: {played}" if played else str(folder)
        )
    print(f"see all of them, episode by episode: python -m ucon report {folder}")


def _print_set(paths: Sequence[Path], title: str) -> None:
    """Print the results of runs on one set, and the paired differences worth comparing."""
    from ucon.core.output import wide_console
    from ucon.evaluation.figures.paired import compare_records, comparison_table
    from ucon.evaluation.figures.report import results_table
    from ucon.evaluation.kept.finished import FinishedRun
    from ucon.evaluation.kept.naming import agent_label, is_worth_comparing, level

    runs = [(run.summary, run.records or ()) for run in map(FinishedRun.read, paths)]
    runs.sort(key=lambda run: (agent_label(run[0]), _LEVEL_ORDER.get(level(run[0]), 9)))
    console = wide_console()
    console.print(results_table([summary for summary, _ in runs], title=title))
    pairs = [
        compare_records(records_a, records_b, (f"{agent_label(a)} {level(a)}", f"{agent_label(b)} {level(b)}"))
        for (a, records_a), (b, records_b) in permutations(runs, 2)
        if is_worth_comparing(a, b) and {r.episode for r in records_a} & {r.episode for r in records_b}
    ]
    if pairs:
        console.print(comparison_table(pairs, ("success_rate", "spl")))


def _set_of(path: Path) -> str:
    """Set of episodes that a run's folder is named by; "" where the sweep played one."""
    *_, last = path.name.split("+")
    return last.removeprefix(_SET) if last.startswith(_SET) else ""


_LEVEL_ORDER = {"none": 0, "full": 1, "gt": 2, "retrieval": 3, "context": 4}
