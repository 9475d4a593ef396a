"""A pytest plugin that records which lines each test runs, how long it takes and whether it passes.

``python -m pytest -p tests.mutants.recorder --record FILE.json tests/task/test_rules.py``. Cases of one parametrised
test are one test here. Lines that run while modules are imported belong to no test; nor do those of compiled kernels.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Generator
from pathlib import Path
from typing import Any, Final

import coverage
import pytest

#: Folders whose lines are recorded: product code, and tests because some call kernels directly.
MEASURED: Final = ("ucon", "models", "tests")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--record", type=Path, help="where to write what each test runs")


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Recorder(config.getoption("--record"), config.rootpath))


class Recorder:
    """Writes ``{"tests": {test: {"seconds": s, "passed": p}}, "lines": {file: {line: [number of a test]}}}``."""

    def __init__(self, out: Path, root: Path) -> None:
        self._out, self._root = out, root
        self._seconds: dict[str, float] = defaultdict(float)
        self._bad: set[str] = set()
        self._coverage = coverage.Coverage(
            data_file=None, config_file=False, source=[str(root / name) for name in MEASURED], messages=False
        )
        self._coverage.start()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        self._coverage.switch_context(_test(item.nodeid))
        try:
            return (yield)
        finally:
            self._coverage.switch_context("")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        test = _test(report.nodeid)
        self._seconds[test] += report.duration
        if not report.passed:  # a skipped test kills nothing either
            self._bad.add(test)

    def pytest_sessionfinish(self) -> None:
        self._coverage.stop()
        data, number = self._coverage.get_data(), {test: k for k, test in enumerate(self._seconds)}
        lines = {}
        for file in sorted(data.measured_files()):
            found = data.contexts_by_lineno(file)
            ran = {line: sorted(number[t] for t in tests if t in number) for line, tests in sorted(found.items())}
            lines[Path(file).relative_to(self._root).as_posix()] = {line: tests for line, tests in ran.items() if tests}
        tests = {t: {"seconds": round(s, 3), "passed": t not in self._bad} for t, s in self._seconds.items()}
        self._out.write_text(json.dumps({"tests": tests, "lines": lines}, separators=(",", ":")))


def _test(nodeid: str) -> str:
    return nodeid.split("[", 1)[0]
