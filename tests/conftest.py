"""Tests that build homes or place objects are skipped, with the reason, on Pythons that PyBullet has no wheels for."""

from __future__ import annotations

import importlib.util
from collections.abc import Generator

import pytest

_THERE = importlib.util.find_spec("pybullet") is not None
_SAYS = ("PyBullet is needed", "and PyBullet, which builds homes, is missing here", "No module named 'pybullet'")
_WHY = "Skipped: needs PyBullet, which has no wheels for this Python"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Report a test as skipped if it failed only because PyBullet is missing, here or in a process it started."""
    report = yield
    if not _THERE and report.failed:
        told = report.longreprtext + "".join(text for _, text in report.sections)
        if any(part in told for part in _SAYS):
            path, line, _ = item.location
            report.outcome, report.longrepr = "skipped", (path, (line or 0) + 1, _WHY)
    return report
