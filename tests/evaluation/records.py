"""Records made by hand, for tests of their readers."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ucon.evaluation.figures.report import summary
from ucon.evaluation.kept.folder import RunFolder
from ucon.evaluation.kept.naming import NameParts
from ucon.evaluation.kept.record import EpisodeRecord, EpisodeTiming
from ucon.evaluation.kept.seal import SEALED, SUMMARY, read_file, sealed
from ucon.evaluation.playing.play import PlayedEpisode

BASE = EpisodeRecord(
    episode="e0",
    scene="Rs_int",
    split="seen",
    target="coffee_cup",
    relation="inside",
    contained=True,
    agent="belief",
    habit_level="retrieval",
    seed=0,
    success=True,
    success_75=True,
    success_150=True,
    success_300=True,
    spl=0.5,
    soft_spl=0.5,
    shortest_path_m=2.0,
    path_length_m=4.0,
    steps=30,
    actions="0012305" + "1" * 22 + "6",
    opens=1,
    collisions=0,
    first_seen_step=20,
    failure_cause="none",
    n_habits=20,
    recall_10=0.5,
    recall_20=0.75,
    mrr=1.0,
)


def record(number: int, *, success: bool = True, **changes: Any) -> EpisodeRecord:
    """A consistent record, except where ``changes`` make it inconsistent."""
    if not success:
        failed = {"spl": 0.0, "soft_spl": 0.1, "failure_cause": "never_seen", "first_seen_step": -1, "steps": 300}
        changes = {"success": False, **failed, **changes}
    steps, found = changes.get("steps", BASE.steps), changes.get("success", True)
    fitting = {f"success_{limit}": found and steps <= limit for limit in (75, 150, 300)}
    if steps != BASE.steps:
        fitting["actions"] = ("001235" + "1" * steps)[: steps - 1] + "6"
    if found and "spl" in changes:
        fitting["path_length_m"] = BASE.shortest_path_m / changes["spl"]
    return replace(BASE, episode=f"e{number}", **{**fitting, **changes})


def played(number: int, **changes: Any) -> PlayedEpisode:
    made = record(number, **changes)
    return PlayedEpisode(number, made, EpisodeTiming(made.episode, 0.5 + number))


def store(
    folder: Path, played: Sequence[PlayedEpisode], parts: NameParts | None = None, config: str = "x: 1\n"
) -> Path:
    """The folder of a finished run with these episodes."""
    run = RunFolder(folder, {})
    run.open([p.record.episode for p in played])
    run.finish(played, summary(played, {}, parts), config)
    return folder


def reseal(folder: Path, **changes: Any) -> None:
    """Update the checksums of a folder after a test has changed its files."""
    for name, parts in SEALED.items():
        said = {k: v for k, v in json.loads((folder / name).read_text()).items() if k not in ("files", "checksum")}
        content = {part: data for part in parts if (data := read_file(folder, part)) is not None}
        (folder / name).write_text(sealed(said | (changes if name == SUMMARY else {}), content))
