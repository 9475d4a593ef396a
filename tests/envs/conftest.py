"""Environments on a few stored episodes."""

from __future__ import annotations

import pytest

from ucon.task.episode import Episode
from ucon.task.sets import load_episodes


@pytest.fixture(scope="session")
def episodes() -> tuple[Episode, ...]:
    """Every fifth episode of the mini set: both kinds of homes, free and contained targets."""
    return load_episodes("mini")[::5]
