"""Makes the report of some runs: tables, and what happened in every episode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

import ucon
from ucon.configuration.kept_config import configuration_of
from ucon.configuration.wiring import Factory
from ucon.core.errors import DataError
from ucon.core.progress import Progress
from ucon.evaluation.figures.markdown import Run, area_m2, kind_of_home, read_runs
from ucon.evaluation.figures.report import episodes_hash
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.naming import level
from ucon.pages.document import document, joined, packed
from ucon.pages.home_plan import plan_of
from ucon.pages.report.overview import differences_of, figures_of, groups_of
from ucon.pages.report.pictures import Pictures
from ucon.pages.report.teller import Telling, mind_of, stories
from ucon.pages.report.texts import HabitTexts
from ucon.programs.evaluating import chosen_episodes
from ucon.sim.cache import load_house
from ucon.task.episode import Episode

#: With more episodes than these, pictures are taken at decisions only, and not at all.
_ALL_UP_TO, _KEY_UP_TO = 60, 200
_STYLES: Final = ("theme.css", "report.css")
_SCRIPTS: Final = ("page.js", "packed.js", "plan.js", "charts.js", "episode.js", "report.js")


@dataclass(frozen=True)
class _Part:
    """One run of the report, ready to be told."""

    run: Run
    kept: FinishedRun
    config: dict[str, Any]
    episodes: Sequence[Episode]


def build_report(
    folders: Sequence[Path],
    pictures: Pictures | Literal["auto"] = "auto",
    places: Mapping[str, str] | None = None,
    said: Mapping[str, Any] | None = None,
    *,
    actions_only: bool = False,
) -> str:
    """The report of one or more finished evaluations, as the text of an HTML file.

    Args:
        folders: of the runs.
        pictures: at which steps the camera's picture is shown; ``auto``: at all up to 60 episodes, at decisions up to
            200, else nowhere.
        places: new paths by old ones, of what a configuration names.
        said: values that a stored configuration must not decide.
        actions_only: tell the recorded actions alone, without the agents and what they believed.

    Raises:
        ConfigError: runs that do not fit here.
        DataError: a run without records, damaged, or whose episodes are not here.
    """
    parts = [_part(folder, run, places or {}, said or {}) for folder, run in read_runs(folders).items()]
    total = sum(len(part.episodes) for part in parts)
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


def _part(folder: Path, run: Run, places: Mapping[str, str], said: Mapping[str, Any]) -> _Part:
    try:
        kept = FinishedRun.read(folder)
    except DataError as error:
        raise DataError(f"{error} (a report needs the run's whole folder)") from None
    config = configuration_of(folder, places, said)
    task = config["task"]
    episodes = chosen_episodes(
        config["episodes"], config["limit"], task["name"], context=task["context"], every=config["every"]
    )
    if episodes_hash(episodes) != kept.summary["hashes"].get("episodes"):
        raise DataError(f"{folder}: other episodes were played than its configuration names now; evaluate again")
    return _Part(run, kept, config, episodes)


def _told(
    number: int, part: _Part, how: Telling, texts: HabitTexts, missing: str
) -> tuple[dict[str, str], dict[str, Any]]:
    """Packed data of a run's episodes by name, and what the page says of the run."""
    made, records, summary = part.kept.decisions(), part.run.records, part.kept.summary
    jobs = [(e, r, made.get(r.episode, [])) for e, r in zip(part.episodes, records, strict=True)]
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
            f"In {otherwise} of {len(jobs)} episodes the agent did something else here than was recorded (another "
            "processor or version); what it believed is told until then."
        )
    said = {
        "label": part.run.label,
        "level": level(summary),
        "folder": part.kept.folder.resolve().name,
        "set": Path(str(part.config["episodes"])).name,
        "note": missing,
        "figures": figures_of(records),
        "rows": [_row(record) for record in records],
    }
    return data, said


def _row(record: Any) -> dict[str, Any]:
    """What the list of episodes shows of one."""
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
