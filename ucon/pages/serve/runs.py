"""Routes of the page *Runs*: the list, the figures of one run, and its report."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from starlette.responses import Response
from starlette.routing import Route

from ucon.core.errors import ConfigError
from ucon.core.untrusted.plain_file import read_plain
from ucon.pages.serve.answers import asked, text, told
from ucon.pages.serve.guard import REPORT_POLICY
from ucon.pages.serve.report_maker import ReportMaker
from ucon.pages.serve.run_list import REPORT, FoundRun, RunList
from ucon.pages.serve.run_live import LiveFigures

#: Largest number of runs in the list, and the largest report in bytes.
_LISTED, _MOST_REPORT = 300, 1 << 28
_Words = Mapping[str, Any]


def run_routes(runs: RunList, maker: ReportMaker) -> list[Route]:
    """Routes of the page.

    Args:
        runs: the runs that are shown.
        maker: makes their reports.
    """
    figures = LiveFigures()

    def listed(_: _Words) -> dict[str, Any]:
        found = runs.all()
        return {"runs": [_named(run) | figures.row(run) for run in found[:_LISTED]], "n": len(found)}

    def one(words: _Words) -> dict[str, Any]:
        run = runs.get(text(words, "run", 16))
        return _named(run) | maker.state(run) | figures.detail(run)

    def make(words: _Words) -> dict[str, Any]:
        run = runs.get(text(words, "run", 16))
        maker.make(run)
        return maker.state(run)

    def report(words: _Words) -> Response:
        run = runs.get(text(words, "run", 16))
        path = run.path / REPORT
        if path.is_symlink() or not path.is_file():
            raise ConfigError("there is no report of this run")
        return Response(
            read_plain(path, _MOST_REPORT), media_type="text/html", headers={"Content-Security-Policy": REPORT_POLICY}
        )

    return [
        asked("/api/runs/list", listed),
        asked("/api/runs/one", one),
        told("/api/runs/report", make),
        asked("/report/{run}", report),
    ]


def _named(run: FoundRun) -> dict[str, Any]:
    return {
        "id": run.id,
        "name": run.name,
        "kind": run.kind,
        "finished": run.finished,
        "age_s": max(0, round(time.time() - run.written_s)),
        "report": run.report,
        "can_report": run.can_report,
    }
