"""Makes the report of some runs: tables, and what happened in every episode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, Literal

import ucon
from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError
from ucon.core.progress import Progress
from ucon.evaluation.figures.markdown import area_m2, kind_of_home, read_runs
from ucon.pages.document import document, joined, packed
from ucon.pages.home_plan import plan_of
from ucon.pages.report.lives import lives_report
from ucon.pages.report.overview import differences_of, groups_of
from ucon.pages.report.parts import Part, check_alike, is_of_lives, part_of
from ucon.pages.report.pictures import Pictures
from ucon.pages.report.teller import Telling, mind_of, stories
from ucon.pages.report.texts import HabitTexts
from ucon.sim.cache import load_house

#: With more episodes than the first, pictures are taken at key steps only; with more than the second, not at all.
_ALL_UP_TO, _KEY_UP_TO = 60, 200
_STYLES: Final = ("theme.css", "report.css")
_SCRIPTS: Final = ("page.js", "packed.js", "plan.js", "charts.js", "tables.js", "episode.js", "report.js")


def build_report(
    folders: Sequence[Path],
    pictures: Pictures | Literal["auto"] = "auto",
    places: Mapping[str, str] | None = None,
    said: Mapping[str, Any] | None = None,
    *,
    actions_only: bool = False,
) -> str:
    """The report of one or more finished evaluations, as the text of an HTML file; for lives see :func:`lives_report`.

    Args:
        folders: of the runs.
        pictures: steps at which the camera's picture is shown; ``auto``: all steps for up to 60 episodes, key steps for
            up to 200, else none.
        places: new paths by old ones, for paths that a configuration names.
        said: values that a stored configuration must not decide.
        actions_only: show the recorded actions only, without running the agents for their beliefs.

    Raises:
        ConfigError: runs whose configuration does not work here, some of lives and some of episodes, or pictures of
            lives.
        DataError: a run without records, damaged, or whose episodes are not here.
    """
    found = read_runs(folders)
    check_alike(found)
    parts = [part_of(folder, run, places or {}, said or {}) for folder, run in found.items()]
    if is_of_lives(parts[0].run):
        if pictures not in ("auto", "none"):
            raise ConfigError(f"--pictures {pictures}: a report of lives has no pictures; omit this option")
        return lives_report(parts)
    total = sum(len(part.played) for part in parts)
    if pictures == "auto":
        pictures = "all" if total <= _ALL_UP_TO else "key" if total <= _KEY_UP_TO else "none"
    texts = HabitTexts()
    data: dict[str, str] = {}
    about: list[dict[str, Any]] = []
    for number, part in enumerate(parts):
        thinks, missing = (False, "") if actions_only else mind_of(part.config)
        told, said_of_run = _told(number, part, Telling(part.config, thinks, pictures), texts, missing)
        data |= told
        about.append(said_of_run)
    scenes = list(dict.fromkeys(r.scene for part in parts for r in part.run.records))
    for k, scene in enumerate(scenes):
        data[f"home-{k}"] = packed(plan_of(load_house(scene)))
    data["texts"] = packed(texts.all)
    runs = [part.run for part in parts]
    index = {
        "version": ucon.__version__,
        "runs": about,
        "scenes": scenes,
        "kinds": [[kind_of_home(scene), round(area_m2(scene), 1)] for scene in scenes],
        "groups": groups_of(runs),
        "differences": differences_of(runs),
        "pictures": pictures,
    }
    title = f"UcON: {', '.join(run.label for run in runs)}"
    return document(title, _STYLES, _SCRIPTS, {"index": packed(index), **data})


def _told(
    number: int, part: Part, how: Telling, texts: HabitTexts, missing: str
) -> tuple[dict[str, str], dict[str, Any]]:
    """Packed data of a run's episodes by name, and what the page says about the run."""
    made, records, summary = part.kept.decisions(), part.run.records, part.kept.summary
    jobs = [(e, r, made.get(r.episode, [])) for e, r in zip(part.played, records, strict=True)]
    reads, habit_level = bool(summary.get("uses_habits", True)), str(part.config["habit_level"]["name"])
    source = Factory(part.config["env"]["source"])()
    data: dict[str, str] = {}
    otherwise = 0
    with Progress(part.run.label, len(jobs), unit="episodes") as progress:
        for k, (story, (episode, record, _)) in enumerate(zip(stories(how, jobs), jobs, strict=True)):
            otherwise += not story.same
            facts = story.facts | {
                "actions": record.actions,
                "habits": texts.of(source, episode, habit_level) if reads else None,
            }
            if story.pictures:
                data[f"pictures-{number}-{k}"], facts["ends"] = joined(story.pictures)
            data[f"episode-{number}-{k}"] = packed(facts)
            progress.update(k + 1)
    if otherwise:
        missing = (
            f"In {otherwise} of {len(jobs)} episodes the agent acted differently here than recorded (another processor "
            "or version); its beliefs are shown up to that point."
        )
    return data, part.said() | {"note": missing, "rows": [_row(record) for record in records]}


def _row(record: Any) -> dict[str, Any]:
    """The row of one episode in the list of episodes."""
    return {
        "id": record.episode,
        "scene": record.scene,
        "target": record.target,
        "relation": record.relation,
        "contained": record.contained,
        "split": record.split,
        "found": record.success,
        "spl": round(record.spl, 3),
        "steps": record.steps,
        "metres": round(record.path_length_m, 2),
        "shortest": round(record.shortest_path_m, 2),
        "seen": record.first_seen_step,
        "cause": record.failure_cause,
        "recall": record.recall_20,
    }
