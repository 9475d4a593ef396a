"""A finished run as its folder stores it; all code that reads such folders uses this module."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from ucon.core.errors import DataError, brief
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.yaml_text import without_aliases
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.naming import agent_label, level
from ucon.evaluation.kept.position_bias import PositionBias
from ucon.evaluation.kept.record import EpisodeRecord, EpisodeTiming, json_lines, parse_records
from ucon.evaluation.kept.seal import CONFIG, DECISIONS, RECORDS, SUMMARY, TIMING, RunFiles, has_summary, read_files
from ucon.evaluation.playing.play import PlayedEpisode

#: Entries of a summary that tables show: numbers, and intervals (lists of two numbers).
_NUMBERS: Final = ("n", "success_rate", "spl", "soft_spl", "success_75", "success_150", "success_300", "steps")
_INTERVALS: Final = ("success_rate_ci95", "spl_ci95")
_MAX_CONFIG: Final = 1 << 24
_ALTERED = "the file is altered, restore it or evaluate again"


@dataclass(frozen=True)
class FinishedRun:
    """Content of the folder of a finished run."""

    folder: Path
    summary: dict[str, Any]
    seconds: dict[str, Any]
    records: tuple[EpisodeRecord, ...] | None
    """Records of the episodes; None where only figures are stored."""
    content: Mapping[str, bytes]
    """Bytes of the files by name."""

    @classmethod
    def read(cls, folder: Path) -> FinishedRun:
        """Read and check a folder.

        Args:
            folder: of a finished run.

        Raises:
            DataError: no finished run, one without checksums, or an altered one.
        """
        return cls.of(read_files(folder))

    @classmethod
    def of(cls, files: RunFiles) -> FinishedRun:
        """Parse files that were read.

        Args:
            files: of the run's folder.

        Raises:
            DataError: the summary or a record is damaged, or their numbers of episodes differ.
        """
        folder = files.folder
        check_summary(files.summary, folder / SUMMARY)
        raw, records = files.content.get(RECORDS), None
        if raw is not None:
            records = tuple(parse_records(raw, folder / RECORDS))
            if len(records) != files.summary["n"]:
                n = brief(files.summary["n"])
                raise DataError(f"{folder / RECORDS}: {len(records)} episodes, {SUMMARY} says {n}; {_ALTERED}")
        return cls(folder, files.summary, files.seconds, records, files.content)

    @property
    def label(self) -> str:
        """Label in tables: agent with its parts, and habit level."""
        return f"{agent_label(self.summary)}, {level(self.summary)}"

    def timings(self) -> list[EpisodeTiming]:
        """Timing of each episode, in order; [] where they are not stored.

        Raises:
            DataError: they do not belong to the records.
        """
        path = self.folder / TIMING
        raw = self.content.get(TIMING)
        if raw is None:
            return []
        timings = [EpisodeTiming.from_json(value, where=where) for value, where in json_lines(raw, path)]
        if self.records is not None and [t.episode for t in timings] != [r.episode for r in self.records]:
            raise DataError(f"{path}: does not match the episodes in {RECORDS}, one line each; {_ALTERED}")
        return timings

    def decisions(self) -> dict[str, list[DecisionRecord]]:
        """Decisions by episode; {} where none are stored.

        Raises:
            DataError: one is damaged, or of an episode without a record.
        """
        made: dict[str, list[DecisionRecord]] = defaultdict(list)
        for value, where in json_lines(self.content.get(DECISIONS, b""), self.folder / DECISIONS):
            decision = DecisionRecord.from_json(value, where=where)
            made[decision.episode].append(decision)
        if self.records is not None and (odd := made.keys() - {r.episode for r in self.records}):
            raise DataError(f"{self.folder / DECISIONS}: episode {brief(min(odd))} is not in the run; {_ALTERED}")
        return dict(made)

    def played(self) -> dict[int, PlayedEpisode]:
        """The episodes by index, as they were when they ended.

        Raises:
            DataError: not all of the run is stored.
        """
        timings, decisions = self.timings(), self.decisions()
        if self.records is None or not timings:
            raise DataError(f"{self.folder}: a finished run without all of its records; evaluate again")
        where = str(self.folder / DECISIONS)
        return {
            i: as_played(i, record, timing, decisions.get(record.episode, []), where)
            for i, (record, timing) in enumerate(zip(self.records, timings, strict=True))
        }


def figures_only(folders: Sequence[Path]) -> DataError:
    """The error for runs whose episodes are needed but of which only figures are kept.

    Args:
        folders: of the runs.
    """
    names = " ".join(str(folder) for folder in folders)
    made = " ".join(f"runs/replay/{folder.resolve().name}" for folder in folders)
    return DataError(f"{names}: keeps only figures, no episodes; run `python -m ucon replay {names}`, then give {made}")


def as_played(
    index: int, record: EpisodeRecord, timing: EpisodeTiming, made: list[DecisionRecord], where: str
) -> PlayedEpisode:
    """An episode as it was when it ended; decisions get their seconds back from the timing.

    Args:
        index: of the episode.
        record: of the episode.
        timing: of the episode.
        made: its decisions.
        where: file, for errors.

    Raises:
        DataError: the three are not of one episode.
    """
    seconds = timing.decision_seconds or (0.0,) * len(made)
    if len(seconds) != len(made):
        raise DataError(f"{where}: {len(made)} decisions in {record.episode}, expected {len(seconds)}; {_ALTERED}")
    if {timing.episode, *(d.episode for d in made)} != {record.episode}:
        raise DataError(f"{where}: a timing or decision of another episode than {record.episode}; {_ALTERED}")
    return PlayedEpisode(
        index, record, timing, tuple(replace(d, seconds=s) for d, s in zip(made, seconds, strict=True))
    )


def check_summary(said: Mapping[str, Any], path: Path) -> None:
    """Refuse a summary in which something that tables show is missing or malformed.

    Args:
        said: content of the file.
        path: of the file, for the error.

    Raises:
        DataError: it is no summary of a finished run.
    """
    numbers = [said.get(name) for name in _NUMBERS]
    for name in _INTERVALS:
        pair = said.get(name)
        numbers += pair if isinstance(pair, list) and len(pair) == 2 else [None]
    names, retrieval = [said.get("agent"), said.get("habit_level")], said.get("retrieval")
    parts = [said.get("language_model"), said.get("detector")]
    causes = said.get("failure_causes")
    usable = (
        all(type(number) in (int, float) for number in numbers)
        and all(isinstance(name, str) for name in names)
        and all(isinstance(part, str | None) for part in parts)
        and isinstance(causes, dict)
        and all(type(count) is int for count in causes.values())
        and isinstance(retrieval, dict)
        and all(type(retrieval.get(name)) in (int, float, type(None)) for name in ("recall_20", "mrr"))
        and isinstance(said.get("hashes"), dict)
    )
    if not usable:
        raise DataError(f"{path}: no summary of a finished run of eval.py; give the folder of one")
    PositionBias.in_summary(said, str(path))


def read_config(folder: Path) -> dict[str, Any]:
    """The configuration of a run; with a ``summary.json`` next to it, its checksum is verified.

    Args:
        folder: of the run.

    Raises:
        DataError: there is none, or it is damaged.
    """
    path = folder / CONFIG
    if not path.is_file():
        raise DataError(f"{path}: no such file; expected the folder of a finished run of eval.py")
    if has_summary(folder):
        read_files(folder)
    try:
        config = OmegaConf.to_container(OmegaConf.create(without_aliases(read_plain(path, _MAX_CONFIG).decode())))
    except (DataError, OSError, ValueError, RecursionError, YAMLError, OmegaConfBaseException):
        config = None
    if not isinstance(config, dict) or not {"env", "task", "episodes"} <= config.keys():
        raise DataError(f"{path}: no configuration of a run; {_ALTERED}")
    return {str(name): value for name, value in config.items()}
