"""A finished run as a report needs it: what is stored of it, its configuration, and what was played."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ucon.configuration.kept_config import configuration_of
from ucon.core.errors import ConfigError, DataError
from ucon.evaluation.figures.markdown import Run
from ucon.evaluation.figures.report import episodes_hash
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.naming import level
from ucon.pages.report.overview import figures_of
from ucon.programs.evaluating import chosen_episodes, chosen_requests


@dataclass(frozen=True)
class Part:
    """One run of a report, with everything that is shown of it."""

    run: Run
    kept: FinishedRun
    config: dict[str, Any]
    played: Sequence[Any]
    """Its episodes, or the requests of its lives, in order."""

    def said(self) -> dict[str, Any]:
        """What the table of runs shows: names, folder, set, and ``figures``."""
        return {
            "label": self.run.label,
            "level": level(self.kept.summary),
            "folder": self.kept.folder.resolve().name,
            "set": Path(str(self.config["episodes"])).name,
            "figures": figures_of(self.run.records),
        }


def part_of(folder: Path, run: Run, places: Mapping[str, str], said: Mapping[str, Any]) -> Part:
    """Read a run.

    Args:
        folder: of the run.
        run: its label and records.
        places: new paths by old ones, for paths that its configuration names.
        said: values that a stored configuration must not decide.

    Raises:
        ConfigError: its configuration does not work here.
        DataError: a part of the folder is missing, or other episodes are here than were played.
    """
    try:
        kept = FinishedRun.read(folder)
    except DataError as error:
        raise DataError(f"{error} (a report needs the run's whole folder)") from None
    config = configuration_of(folder, places, said)
    task, chosen = config["task"], (config["episodes"], config["limit"])
    played: Sequence[Any] = (
        chosen_requests(*chosen, every=config["every"])
        if is_of_lives(run)
        else chosen_episodes(*chosen, task["name"], context=task["context"], every=config["every"])
    )
    if episodes_hash(played) != kept.summary["hashes"].get("episodes"):
        raise DataError(f"{folder}: its configuration now names other episodes than those played; evaluate again")
    return Part(run, kept, config, played)


def is_of_lives(run: Run) -> bool:
    """Whether a run played lives (task=resident)."""
    return any(record.life is not None for record in run.records)


def check_alike(runs: Mapping[Path, Run]) -> None:
    """Raise :class:`ConfigError` where some runs are of lives and others of episodes."""
    of_lives = [folder for folder, run in runs.items() if is_of_lives(run)]
    others = [folder for folder in runs if folder not in of_lives]
    if of_lives and others:
        raise ConfigError(
            f"{of_lives[0]}: a run of lives (task=resident), and {others[0]} is one of episodes; "
            "make a report of each kind"
        )
