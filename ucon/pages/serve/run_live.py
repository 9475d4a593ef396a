"""Figures of runs, also while they run: of evaluations from finished episodes, of training runs from their metrics."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import yaml

from ucon.core.errors import DataError
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.strict_json import JsonError, parse_json, read_json
from ucon.core.untrusted.yaml_text import MOST_BYTES, without_aliases
from ucon.evaluation.figures.intervals import wilson_interval
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.kept.finished import FinishedRun, check_summary
from ucon.evaluation.kept.naming import agent_label, level
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.evaluation.kept.seal import CONFIG, PARTIAL, SUMMARY
from ucon.learning.run.run_folder import METRICS
from ucon.pages.report.life_records import curves_of, rows_by_life
from ucon.pages.serve.run_list import MOST_SUMMARY, FoundRun
from ucon.pages.serve.tails import Tails
from ucon.pages.thinning import thinned

#: Figures of a summary that the page shows.
_SHOWN: Final = ("n", "success_rate", "success_rate_ci95", "spl", "spl_ci95", "steps", "failure_causes")
#: Largest number of points of a curve, of episodes listed, and of lives listed.
_POINTS, _LISTED, _LIVES = 400, 12, 50
#: Largest number of finished runs whose figures are kept.
_KEPT: Final = 1000


def _line_of_partial(line: bytes) -> Any:
    """A record, or the first line's number of episodes (-1 where it has none); None for a damaged line.

    Checksums are not verified here, where a line is only shown, but by the command that continues the run.
    """
    try:
        value = parse_json(line.partition(b" ")[2])
        if isinstance(value, dict) and "hashes" in value:
            return value["n"] if type(value.get("n")) is int else -1
        return EpisodeRecord.from_json(value["record"])
    except (JsonError, DataError, LookupError, TypeError):
        return None


def _line_of_metrics(line: bytes) -> Mapping[str, Any] | None:
    """Figures of a step; None for an invalid line, such as one with NaN, which a diverged run may have."""
    try:
        value = parse_json(line)
    except JsonError:
        return None
    return value if isinstance(value, dict) and type(value.get("step")) is int else None


class LiveFigures:
    """Reads the figures of runs."""

    def __init__(self) -> None:
        self._partial, self._metrics = Tails(_line_of_partial), Tails(_line_of_metrics)
        self._finished: OrderedDict[tuple[str, str, float], dict[str, Any]] = OrderedDict()

    def row(self, run: FoundRun) -> dict[str, Any]:
        """A line of the list of runs.

        Args:
            run: the run.

        Returns:
            ``label``, ``level``, ``done`` and ``total`` (episodes or steps; None where unknown), and where they are
            known ``success_rate`` and ``spl`` with their intervals, or ``score``.
        """
        return self._kept("row", run, self._row)

    def _row(self, run: FoundRun) -> dict[str, Any]:
        try:
            return self._trained(run) if run.kind == "train" else self._evaluated(run)
        except (OSError, DataError) as error:
            return {"label": "cannot be read", "problem": " ".join(str(error).split())}

    def detail(self, run: FoundRun) -> dict[str, Any]:
        """What the page shows of one run.

        Args:
            run: the run.

        Returns:
            The row, and ``curves``: for each a name and its points; of evaluations also ``episodes``, the last ones;
            of lives also ``by_day`` and ``lives``, see :mod:`ucon.pages.report.life_records`.

        Raises:
            DataError: it cannot be read.
        """
        return self._kept("detail", run, self._detail)

    def _detail(self, run: FoundRun) -> dict[str, Any]:
        row = self.row(run)
        if "problem" in row:
            raise DataError(row["problem"])
        if run.kind == "train":
            metrics = run.path / METRICS
            return {**row, "curves": _curves(self._metrics.lines(metrics)) if metrics.is_file() else []}
        records = list(FinishedRun.read(run.path).records or ()) if run.finished else self._records(run.path)[1]
        listed = [
            {
                "episode": r.episode, "target": r.target, "success": r.success, "steps": r.steps,
                "why": r.failure_cause.replace("_", " "),
            }
            for r in records[-_LISTED:]
        ]  # fmt: skip
        if lives := rows_by_life(records):
            shown = dict(list(lives.items())[-_LIVES:])
            return {**row, "curves": [], "by_day": curves_of(records), "lives": shown, "episodes": listed[::-1]}
        return {**row, "curves": _success_curve(records), "episodes": listed[::-1]}

    def _kept(self, what: str, run: FoundRun, read: Callable[[FoundRun], dict[str, Any]]) -> dict[str, Any]:
        """What ``read`` gives for a run; a finished run is read only once."""
        key = (what, run.id, run.written_s)
        if key in self._finished:
            return self._finished[key]
        found = read(run)
        if run.finished:
            self._finished[key] = found
            while len(self._finished) > _KEPT:
                self._finished.popitem(last=False)
        return found

    def _evaluated(self, run: FoundRun) -> dict[str, Any]:
        if run.finished:
            said = read_json(run.path / SUMMARY, "evaluate again", max_bytes=MOST_SUMMARY)
            check_summary(said if isinstance(said, dict) else {}, run.path / SUMMARY)
            return _row(agent_label(said), level(said), said, said["n"])
        total, records = self._records(run.path)
        if not records:
            return {"label": "", "level": "", "done": 0, "total": total}
        return _row(records[0].agent, records[0].habit_level, summarise(records), total)

    def _records(self, folder: Path) -> tuple[int | None, list[EpisodeRecord]]:
        """Number of episodes of an unfinished run, None where unknown, and the records so far, each episode once."""
        lines = self._partial.lines(folder / PARTIAL)
        total = next((line for line in lines if isinstance(line, int) and line > 0), None)
        return total, list({line.episode: line for line in lines if isinstance(line, EpisodeRecord)}.values())

    def _trained(self, run: FoundRun) -> dict[str, Any]:
        if not (run.path / METRICS).is_file():
            return _trained_once(run.path)
        lines, said = self._metrics.lines(run.path / METRICS), _said(run.path)
        scores = [line["val/score"] for line in lines if _is_number(line.get("val/score"))]
        return {
            "label": said.get("label", ""),
            "level": "",
            "done": max((line["step"] for line in lines), default=0),
            "total": said.get("steps"),
            "score": max(scores, default=None),
        }


def _row(label: str, habits: str, figures: Mapping[str, Any], total: int | None) -> dict[str, Any]:
    return {"label": label, "level": habits, "done": figures["n"], "total": total} | {
        name: figures[name] for name in _SHOWN if name in figures
    }


def _trained_once(folder: Path) -> dict[str, Any]:
    """The row of a training run of which only the summary is kept, as in ``results/``."""
    said = read_json(folder / SUMMARY, "train again", max_bytes=MOST_SUMMARY)
    steps, score = said.get("steps"), said["best"].get("score")
    return {
        "label": _said(folder).get("label", ""),
        "level": "",
        "done": steps if type(steps) is int else None,
        "total": None,
        "score": score if _is_number(score) else None,
    }


def _said(folder: Path) -> dict[str, Any]:
    """Facts from a training run's configuration: constructors of the agent's policy and the learner, and last step."""
    try:
        config = yaml.safe_load(without_aliases(read_plain(folder / CONFIG, MOST_BYTES).decode()))
        agent, learner = config["agent"], config["learner"]["_target_"]
        made = agent.get("policy", agent)["_target_"] if isinstance(agent, dict) else ""
        steps = config["training"]["steps"]
        words = [str(name).rpartition(".")[2] for name in (made, learner) if name]
        return {"label": ", ".join(words)[:120], "steps": steps if type(steps) is int else None}
    except (OSError, DataError, ValueError, LookupError, TypeError, AttributeError, RecursionError, yaml.YAMLError):
        return {}


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)


def _curves(lines: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Curves of the training loss and of all validation figures, against steps."""
    names = sorted({name for line in lines for name in line if name.startswith("val/")})
    found = []
    for name in ["loss", *names]:
        points = [[line["step"], line[name]] for line in lines if _is_number(line.get(name))]
        if points:
            label = f"{name.removeprefix('val/').replace('_', ' ')}{'' if name == 'loss' else ' (validation)'}"
            found.append({"name": label[:80], "x": "step", "points": thinned(points, _POINTS)})
    return found[:12]


def _success_curve(records: Sequence[EpisodeRecord]) -> list[dict[str, Any]]:
    """Success rate in % after each episode, with Wilson's interval of 95 %."""
    points, found = [], 0
    for n, record in enumerate(records, 1):
        found += record.success
        low, high = wilson_interval(found / n, n).ci95
        points.append([n, 100 * found / n, 100 * low, 100 * high])
    if not points:
        return []
    return [{"name": "SR % so far, with its 95 % interval", "x": "episodes", "points": thinned(points, _POINTS)}]
