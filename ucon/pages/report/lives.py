"""Makes the report of runs of lives: tables, the learning curve, and every life with its calendar and its things."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import ucon
from ucon.evaluation.figures.lives_table import grouped
from ucon.evaluation.figures.markdown import Run
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.evaluation.kept_memories import Truth
from ucon.lives.life import Life
from ucon.pages.document import document, packed
from ucon.pages.report.life_records import curves_of
from ucon.pages.report.life_story import LifeStory, head_of
from ucon.pages.report.overview import differences_of, figures_of
from ucon.pages.report.parts import Part

#: Resamples of the intervals within groups.
_RESAMPLES: Final = 2_000
_STYLES: Final = ("theme.css", "report.css")
_SCRIPTS: Final = ("page.js", "packed.js", "charts.js", "tables.js", "lives.js", "lives_report.js")


def lives_report(parts: Sequence[Part]) -> str:
    """The report of runs of lives, as the text of an HTML file, made from the records and lives without playing them.

    Args:
        parts: the runs.
    """
    runs = [part.run for part in parts]
    lives = {asked.life.hash: asked.life for part in parts for asked in part.played}
    index = {
        "version": ucon.__version__,
        "runs": [part.said() | {"curves": curves_of(part.run.records)} for part in parts],
        "differences": differences_of(runs),
        "groups": groups_of(runs),
        "lives": [head_of(life) for life in lives.values()],
    }
    data = {"index": packed(index)}
    for number, life in enumerate(lives.values()):
        data[f"life-{number}"] = packed(told(life, parts))
    return document(f"UcON: {', '.join(run.label for run in runs)}", _STYLES, _SCRIPTS, data)


def groups_of(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Figures of all requests and of each group of them.

    Args:
        runs: of lives.

    Returns:
        In the order of :func:`ucon.evaluation.figures.lives_table.grouped`: ``name``, and ``runs``, the figures of each
        run, None where it has no such request.
    """
    by_name: dict[str, list[Any]] = {}
    for number, run in enumerate(runs):
        for name, records in grouped(run.records):
            by_name.setdefault(name, [None] * len(runs))[number] = figures_of(records, _RESAMPLES)
    return [{"name": name, "runs": figures} for name, figures in by_name.items()]


def told(life: Life, parts: Sequence[Part]) -> dict[str, Any]:
    """A life, and what each run did in it.

    Args:
        life: the life.
        parts: the runs.

    Returns:
        ``things`` and ``runs``, one list of requests per run, None where it did not play this life.
    """
    story = LifeStory(Truth.of(life))
    mine = [_records_in(life, part) for part in parts]
    return {"things": story.things(), "runs": [story.rows(records) if records else None for records in mine]}


def _records_in(life: Life, part: Part) -> list[EpisodeRecord]:
    if not any(asked.life.hash == life.hash for asked in part.played):
        return []
    return [record for record in part.run.records if record.life is not None and record.life.life == life.id]
